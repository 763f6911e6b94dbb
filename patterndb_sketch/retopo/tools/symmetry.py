"""The tool that switches symmetry on and off."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import Argument, Flag, Number, Vector, Word
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.invariants import list_kept_faces
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.symmetry import (
    Plane,
    Proposal,
    begin_symmetry,
    cut_half,
    end_symmetry,
    format_share,
    propose_given,
    propose_plane,
)
from patterndb_sketch.retopo.symmetry.proposal import SYMMETRIC
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.wording import format_place

#: Normals of the planes that have a name.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    now = work.state.plane
    if a["axis"] is not None and a["normal"] is not None:
        raise InvalidRetopoError("symmetry needs either axis or normal, not both")
    named = any(a[name] is not None for name in ("point", "normal", "axis"))
    if not a["on"]:
        if named or a["find"]:
            raise InvalidRetopoError("switching symmetry off needs no plane; leave it out")
        if now is None:
            raise RefusedError("symmetry is off already")
        return _switch_off(work, now)
    if now is not None:
        raise RefusedError("symmetry is on already; switch it off first")
    faces = list_kept_faces(work.network)
    if faces:
        at = work.network.nodes[work.network.origin(faces[0][0])].point
        raise RefusedError(
            f"{len(faces)} faces that were given stay as they are, the first at "
            f"{format_place(at)}: no plane can cut the mesh; make it of quads alone, or work on "
            "both sides"
        )
    if a["find"] and named:
        raise InvalidRetopoError("symmetry needs either find, or a plane (axis, point, normal)")
    if a["tolerance"] is not None and not a["find"]:
        raise InvalidRetopoError(
            "tolerance is how far off a plane may be that find takes; give find"
        )
    found = _find_own(work.surface, a["tolerance"]) if a["find"] else _read_plane(work.surface, a)
    plane = found.plane
    notes: tuple[str, ...] = ()
    if a["find"]:
        notes = (f"symmetry is on: {found.describe()}",)
    elif not found.symmetric:
        notes = (
            f"the surface is not symmetric in {found.describe()}: the other half's quads will not "
            "lie on it",
        )
    half = cut_half(work.surface, plane)
    edit = begin_symmetry(work.network, half, work.state.sizes.sampling)
    return Result(replace(work.state, network=edit.network, plane=plane), (*notes, *edit.notes))


def _read_plane(surface: Surface, a: dict[str, Any]) -> Proposal:
    """The plane that a call names, with how far off it is."""
    point = (0.0, 0.0, 0.0) if a["point"] is None else a["point"]
    normal = AXES[a["axis"] or "x"] if a["normal"] is None else a["normal"]
    return propose_given(surface, Plane.of(point, normal))


def _find_own(surface: Surface, tolerance: float | None) -> Proposal:
    """The surface's own plane; raises RefusedError, with what there is instead, if it has none."""
    found = propose_plane(surface)
    most = SYMMETRIC if tolerance is None else tolerance
    if found.off <= most:
        return found
    even = ", ".join(
        f"{name} {format_share(propose_given(surface, Plane.of((0.0, 0.0, 0.0), across)).off)}"
        for name, across in AXES.items()
    )
    raise RefusedError(
        f"the surface is symmetric in no plane, to {format_share(most)} of its diagonal: the "
        f"nearest is {found.describe()}. Across the axes through the origin: {even} off; give "
        "axis, or point and normal, to take a plane all the same, or a greater tolerance"
    )


def _switch_off(work: ToolWork, plane: Plane) -> Result:
    chains = work.network.chains.values()
    if not any(SYMMETRY in chain.marks for chain in chains):
        # The plane misses the surface: there is no seam, and nothing to mirror across it.
        return Result(replace(work.state, plane=None))
    edit = end_symmetry(work.network, work.whole, work.state.sizes, plane)
    return Result(replace(work.state, network=edit.network, plane=None), edit.notes)


SYMMETRY_TOOL = Tool(
    "symmetry",
    "Work on one side of a plane, and get both; or switch that off.",
    {
        "on": Argument(Flag(), "on or off", True, option=False),
        "point": Argument(Vector(), "of the plane; [0, 0, 0] if left out", None),
        "normal": Argument(
            Vector(direction=True), "to the side that is worked on; x if left out", None
        ),
        "find": Argument(
            Flag(), "take the surface's own plane, if it has one", False, option=False
        ),
        "axis": Argument(Word(tuple(AXES)), "the normal, by its name", None),
        "tolerance": Argument(
            Number(0.0, 1.0),
            f"with find, how far off the plane may be, as a part of the diagonal; {SYMMETRIC} if "
            "left out",
            None,
        ),
    },
    _act,
    position=230,
    control=Control("M", "mirror", "work on one half, and get both"),
)
