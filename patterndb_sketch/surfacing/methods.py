"""The methods that make the surface of a loop: one table, which all who offer a choice read.

:func:`patterndb_sketch.surfacing.surfaces.surface`, the command line, the window and the docs read
METHODS. To add a method, write its function here, or in a module of its own, and enter it in the
table; a test finds it there and surfaces a set of loops with it.

The functions import what they need when they are called: who only lists the methods, such as a
command's help, need not wait for solvers.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from patterndb.system.requests import Positive, Request, option
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.defaults import (
    ALPHA,
    AREA_PRICE,
    MAX_SUBPROBLEMS,
    TURNING_BOUND,
    Flatness,
)

if TYPE_CHECKING:
    from patterndb.core.halfedge import Int64Array
    from patterndb.geometry.points import Points
    from patterndb_sketch.surfacing.chords import Decomposition
    from patterndb_sketch.surfacing.sampling import Loop
    from query.engine import PatternSource


@dataclass(frozen=True, slots=True)
class MadeSurface:
    """What a method has made of a loop of n vertices, before it is measured.

    method: the name of the one that answered, which need not be the one asked for.
    note:   why it is another, and what else a user should know; "" if there is nothing to say.
    points: (k, 3) float64, the vertices inside. faces: per piece (f, 3) or (f, 4) int64, in the
            loop's sense; below n a position in the loop, n + i row i of points.
    cut:    how the loop was cut by chords, if it was.
    corners: positions in the loop of the corners of a grid that fills it, if one does.
    """

    method: str
    note: str
    points: Points
    faces: tuple[Int64Array, ...]
    cut: Decomposition | None = None
    corners: tuple[int, ...] = ()


#: The method where nothing else is asked for: the first of METHODS.
DEFAULT_METHOD = "smooth"


#: Makes the surface of a loop: (loop, options, spacing, database). It answers for every valid
#: loop; where its own way fails, by another method, and says so in the note.
MakeSurface = Callable[["Loop", "SurfaceRequest", float, "PatternSource | None"], MadeSurface]


@dataclass(frozen=True, slots=True)
class SurfacingMethod:
    """A way to make the surface of a loop.

    name:           what settings, results and the command line call it.
    help:           what it does, as a part of a sentence: "cut along chords".
    make:           makes it.
    needs_database: does it take patterns from a database? Without one, the default answers.
    makes_quads:    are its faces quads? Then every cycle is given an even number of edges, and
                    vertices are further apart.
    coarsens_flat:  has a flat loop no vertices but its own? Then straight curves between flat
                    patches have none inside, either.
    """

    name: str
    help: str
    make: MakeSurface
    needs_database: bool = False
    makes_quads: bool = False
    coarsens_flat: bool = False


def make_by_chords(
    loop: Loop, options: SurfaceRequest, spacing: float, _db: PatternSource | None
) -> MadeSurface:
    """Cut a loop along chords into nearly flat pieces, and relax each: the paper's way.

    Where the search for chords is too large, the triangulation of least area answers.
    """
    from patterndb_sketch.surfacing.chords import decompose
    from patterndb_sketch.surfacing.tessellation import tessellate_patch

    cut = decompose(
        loop,
        options.alpha,
        area_price=options.area_price,
        flatness=options.flatness,
        turning_bound=options.turning_bound,
        max_subproblems=options.max_subproblems,
    )
    if cut.exhausted:
        why = (
            "half of the candidate chords already make more than "
            f"{options.max_subproblems:,} sub-problems; the triangulation of least area stands in"
        )
        return replace(make_by_area(loop, options, spacing, None), note=why, cut=cut)
    dropped = (
        f"the {cut.n_dropped} longest candidates were left out of a search too large"
        if cut.n_dropped
        else ""
    )
    mesh = tessellate_patch(loop, cut.chords, cut.pieces, spacing)
    return MadeSurface("chords", _join(dropped, *mesh.notes), mesh.points, mesh.faces, cut)


def make_by_area(
    loop: Loop, _options: SurfaceRequest, _spacing: float, _db: PatternSource | None
) -> MadeSurface:
    """Take the triangulation of least area of a loop, without vertices inside."""
    from patterndb_sketch.surfacing.tessellation import patch_of_least_area

    mesh = patch_of_least_area(loop)
    return MadeSurface("area", "", mesh.points, mesh.faces)


def make_smooth(
    loop: Loop, options: SurfaceRequest, spacing: float, _db: PatternSource | None
) -> MadeSurface:
    """Fill a loop with a grid of quads as near to parallelograms as can be, cut into triangles.

    A loop that lies in a plane is triangulated there, without vertices inside: its surface is
    known, and a grid might leave its outline. Where the best choices of corners make faces that
    pass through each other, chords answer.
    """
    import numpy as np

    from patterndb.geometry.quadshape import plane_normal
    from patterndb_sketch.surfacing.tessellation import triangulate_flat

    flat = None if plane_normal(loop.points) is None else triangulate_flat(loop.points)
    if flat is not None:
        return MadeSurface("smooth", "", np.zeros((0, 3)), (flat,))
    return _make_ground(loop, options, spacing)


def _make_ground(loop: Loop, options: SurfaceRequest, spacing: float) -> MadeSurface:
    """Make the surface of a loop by a smooth grid, by chords if it is flat or no grid is sound."""
    import numpy as np

    from patterndb.geometry.quadshape import plane_normal
    from patterndb_sketch.surfacing.parallelograms import fill_with_parallelograms, rank_corners
    from patterndb_sketch.surfacing.tessellation import find_self_intersections

    if plane_normal(loop.points) is not None:
        flat = make_by_chords(loop, options, spacing, None)
        return replace(flat, method="smooth") if flat.method == "chords" else flat
    named = np.flatnonzero(loop.corners).tolist()
    for choice in rank_corners(loop.points, named)[:MOST_GRIDS]:
        mesh = fill_with_parallelograms(loop.points, choice.corners)
        together = np.concatenate([loop.points, mesh.points])
        if not len(find_self_intersections(together, mesh.triangles)):
            return MadeSurface("smooth", "", mesh.points, (mesh.triangles,), corners=mesh.corners)
    made = make_by_chords(loop, options, spacing, None)
    return replace(made, note=_join("every smooth grid tried crosses itself", made.note))


def make_by_quads(
    loop: Loop, options: SurfaceRequest, spacing: float, db: PatternSource | None
) -> MadeSurface:
    """Fill a loop with quads from the database, on the surface that the default method gives.

    That surface answers where there are no quads for the loop.
    """
    import numpy as np

    from patterndb_sketch.surfacing.patch import as_triangles
    from patterndb_sketch.surfacing.quads import fill_with_quads

    assert db is not None, "the method says that it needs one"
    # Vertices inside flat loops, too: quads are laid onto them.
    ground = _make_ground(loop, options, spacing)
    points = np.concatenate([loop.points, ground.points])
    try:
        filled = fill_with_quads(db, loop, points, as_triangles(ground.faces))
    except InvalidNetworkError as error:
        return replace(ground, note=_join(f"no quads: {error}", ground.note))
    return MadeSurface("quads", _join(ground.note, filled.note), filled.points, (filled.quads,))


#: Grids that are tried for a smooth surface: crossings with the best choices of corners are seldom
#: gone with others.
MOST_GRIDS = 4


def _join(*notes: str) -> str:
    return "; ".join(note for note in notes if note)


#: The methods by name, in the order in which they are offered; the first is the default.
METHODS: dict[str, SurfacingMethod] = {
    method.name: method
    for method in (
        SurfacingMethod(
            "smooth", "lay a smooth grid into the loop", make_smooth, coarsens_flat=True
        ),
        SurfacingMethod("chords", "cut along chords", make_by_chords),
        SurfacingMethod("area", "take the triangulation of least area", make_by_area),
        SurfacingMethod(
            "quads", "fill with quads", make_by_quads, needs_database=True, makes_quads=True
        ),
    )
}


def describe_methods() -> str:
    """Write a sentence that says what the methods do, in their order."""
    *first, end = (method.help for method in METHODS.values())
    sentence = f"{', '.join(first)}, or {end}."
    return sentence[0].upper() + sentence[1:]


if TYPE_CHECKING:
    MethodName = str
else:
    MethodName = Literal[tuple(METHODS)]


class SurfaceRequest(Request, frozen=True, kw_only=True):
    """How a network is surfaced.

    alpha and the four after it matter where chords cut a loop. area_price: the area that chords
    may add, see :func:`patterndb_sketch.surfacing.chords.find_affordable`; math.inf: any.

    Raises InvalidNetworkError for an invalid value.
    """

    error = InvalidNetworkError

    method: Annotated[MethodName, option(describe_methods(), section="surface")] = DEFAULT_METHOD
    fair: Annotated[
        bool,
        option(
            "Make smooth grids share normals across curves through which the surface goes on.",
            hint="give True or False",
            section="surface",
        ),
    ] = False
    alpha: Annotated[
        Annotated[float, Meta(ge=0, le=sys.float_info.max)],
        option(
            "The price of a chord: more makes fewer and larger pieces.",
            hint="give a number from 0 on",
            section="surface",
        ),
    ] = ALPHA
    area_price: Annotated[
        Annotated[float, Meta(ge=0)],
        option(
            "Take chords no matter how much area they add, as the paper does.",
            flag="--any-chord",
            constant=math.inf,
            hint="give a number from 0 on, or math.inf",
            section="surface",
        ),
    ] = AREA_PRICE
    flatness: Annotated[
        Flatness,
        option('Of a loop: "relative", or "printed" as in the paper, the product of eigenvalues.'),
    ] = "relative"
    turning_bound: Annotated[
        Annotated[float, Meta(gt=0)],
        option(
            "Radians by which a loop may turn between two ends of chords.",
            hint="give a number above 0",
        ),
    ] = TURNING_BOUND
    max_subproblems: Annotated[
        Positive, option("Sub-problems that the search for chords scores.")
    ] = MAX_SUBPROBLEMS
    spacing: Annotated[
        Annotated[float, Meta(gt=0, le=sys.float_info.max)] | None,
        option(
            "How far vertices are apart, in the network's unit.",
            hint="give a number above 0, or None",
            section="surface",
        ),
    ] = None
