"""Fills of holes as they are returned: quads in numbers of the mesh, lists, and welding."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError, TimeLimitError
from patterndb.system.deadline import end_by, get_deadline, run_until_late
from patterndb.verbs import PlotVerbs
from query.fill import Fill
from query.holes.loops import Hole
from query.holes.neighbourhood import find_border_places

#: Seconds after a time limit in which a fill that was found by then may be placed.
PLACING_SECONDS = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class HoleFill(PlotVerbs):
    """A fill of a hole, in numbers of the mesh.

    hole:     what it fills.
    quads:    (q, 4) int32, vertices of the mesh; new ones from the mesh's number of vertices on.
    points:   (k, 3) float64, where the new vertices lie.
    local:    (q, 4) int32, the same quads with the loop's vertices as 0..L-1.
    corners:  (L,) int32 quads at each loop vertex.
    score:    the greater, the likelier that an artist made it; inf for a twin.
    twin:     is it the mirror image of the other side of the mesh, or of the fill of a hole there?
    flipped:  quads that are turned over where they lie.
    valences: (L + k,) int32 faces around the loop's vertices and the new ones; 0 on the border that
              stays, where no number of them is regular.
    fill:     what the database gave; None for a twin and an n-gon. Where the other side of the mesh
              shows a part of the hole, that of the rest.
    ngon:     (L,) int32 the corners of the one face that fills the hole instead of quads; None
              where quads do.
    flat:     was it laid in the plane of the hole's boundary?
    """

    hole: Hole
    quads: Int32Array
    points: NDArray[np.float64]
    local: Int32Array
    corners: Int32Array
    score: float
    valences: Int32Array
    twin: bool = False
    flipped: int = 0
    fill: Fill | None = None
    ngon: Int32Array | None = None
    flat: bool = False

    @property
    def n_quads(self) -> int:
        """How many quads fill the hole."""
        return len(self.quads)

    @property
    def n_faces(self) -> int:
        """How many faces fill the hole: quads, or one n-gon."""
        return len(self.quads) if self.ngon is None else 1

    @property
    def n_irregular(self) -> int:
        """Vertices of the fill and its loop around which there are not 4 faces."""
        return int(((self.valences != 4) & (self.valences != 0)).sum())

    @property
    def pattern(self) -> str:
        """The name of the pattern, "twin" or "n-gon"."""
        return self._kind if self.fill is None else self.fill.pattern.name

    @property
    def origin(self) -> str:
        """Where the pattern comes from; "twin" for a mirror image, "n-gon" for an n-gon."""
        return self._kind if self.fill is None else self.fill.origin

    @property
    def _kind(self) -> str:
        return "twin" if self.ngon is None else "n-gon"

    def weld(self) -> PolygonMesh:
        """Return the mesh with the hole filled; :func:`weld_fills` takes fills of several holes."""
        return weld_fills([self])

    def to_json(self) -> dict[str, Any]:
        """The fill as JSON takes it."""
        return {
            "pattern": self.pattern,
            "origin": self.origin,
            "score": round(self.score, 6) if np.isfinite(self.score) else None,
            "quads": self.quads.tolist(),
            "ngon": None if self.ngon is None else self.ngon.tolist(),
            "points": self.points.tolist(),
            "n_irregular": self.n_irregular,
            "flipped": self.flipped,
            "flat": self.flat,
        }


def number_fill(
    hole: Hole,
    regular_valence: Int32Array,
    local: Int32Array,
    points: NDArray[np.float64],
    **entries: Any,
) -> HoleFill:
    """Make a fill from quads in the loop's numbering.

    regular_valence: (L,) the quads that make each loop vertex regular. local: (q, 4) int32, loop
    vertices 0..L-1, inner ones after. points: (k, 3) the inner vertices. entries: others of the
    fill.
    """
    n, first_new = len(hole), len(hole.topology.mesh.points)
    quads = np.where(local < n, hole.loop[np.minimum(local, n - 1)], local - n + first_new)
    counts = np.bincount(local.ravel(), minlength=n + len(points))
    valences = counts.copy()
    valences[:n] = np.where(find_border_places(hole), 0, counts[:n] - regular_valence + 4)
    return HoleFill(
        hole=hole,
        quads=quads.astype(np.int32),
        points=points,
        local=local,
        corners=counts[:n].astype(np.int32),
        valences=valences.astype(np.int32),
        **entries,
    )


class HoleFills(Iterator[HoleFill]):
    """An iterator over the fills of a hole, best first.

    hole: what they fill. twin: was a mirror twin found? seconds: spent so far. stopped: "time
    limit" where that ended the list, else None. complete: was everything searched that was asked
    for?
    """

    def __init__(
        self, hole: Hole, found: Iterator[HoleFill], limit: int | None, time_limit: float | None
    ) -> None:
        self.hole = hole
        self.twin = False
        self.seconds = 0.0
        self.stopped: str | None = None
        self._found = found
        self._limit, self._time_limit = limit, time_limit
        self._count = 0
        self._deadline: float | None = None

    def __iter__(self) -> HoleFills:
        return self

    @property
    def complete(self) -> bool:
        return self.stopped is None

    def __next__(self) -> HoleFill:
        begin = perf_counter()
        if self._deadline is None:
            mine = math.inf if self._time_limit is None else begin + self._time_limit
            self._deadline = min(mine, get_deadline())
        if self.stopped is not None or self._count == self._limit:
            raise StopIteration
        try:
            fill = self._find_next(self._deadline)
        finally:
            self.seconds += perf_counter() - begin
        if fill is None:
            if perf_counter() >= self._deadline:
                self.stopped = "time limit"
            raise StopIteration
        self._count += 1
        self.twin = self.twin or fill.twin
        return fill

    def _find_next(self, deadline: float) -> HoleFill | None:
        # The search ends at the deadline, with what it has: to place that takes a moment more. A
        # single step that takes longer, on a very large hole, is left to itself.
        def search() -> HoleFill | None:
            with end_by(deadline):
                return next(self._found, None)

        try:
            with end_by(deadline + PLACING_SECONDS):
                return run_until_late(search, "a fill was placed")
        except TimeLimitError:
            self.stopped = "time limit"
            return None

    def to_json(self, fills: Sequence[HoleFill]) -> dict[str, Any]:
        """The hole and those of its fills that were listed, as JSON takes them."""
        return {
            "loop": self.hole.loop.tolist(),
            "corners": fills[0].corners.tolist() if fills else [],
            "twin": self.twin,
            "stopped": self.stopped,
            "complete": self.complete,
            "seconds": round(self.seconds, 4),
            "fills": [fill.to_json() for fill in fills],
        }


def weld_fills(fills: Sequence[HoleFill]) -> PolygonMesh:
    """Weld fills of different holes of one mesh into it.

    All old vertices keep their numbers and places to the bit; faces that stay keep their order,
    less those that the fills replace; new vertices and faces come after, fill by fill. Raises
    InvalidMeshError for fills of different meshes.
    """
    if not fills:
        raise InvalidMeshError("give one fill or more")
    mesh = fills[0].hole.topology.mesh
    if any(fill.hole.topology.mesh is not mesh for fill in fills):
        raise InvalidMeshError("the fills are of different meshes; weld those of one mesh")
    stays = np.ones(mesh.n_faces, np.bool_)
    for fill in fills:
        stays[fill.hole.removed] = False
    arity = mesh.arities()
    kept = mesh.corners[np.repeat(stays, arity)]
    points = [mesh.points]
    new: list[Int32Array] = []
    sizes: list[int] = []
    n = len(mesh.points)
    for fill in fills:
        first = len(mesh.points)
        faces = fill.quads if fill.ngon is None else fill.ngon[None]
        moved = np.where(faces >= first, faces - first + n, faces)
        new.append((moved[:, ::-1] if fill.hole.runs_backwards() else moved).ravel())
        sizes += [faces.shape[1]] * len(faces)
        points.append(fill.points)
        n += len(fill.points)
    lengths = np.concatenate([arity[stays], np.array(sizes, np.int64)])
    return PolygonMesh(
        np.concatenate(points),
        np.concatenate([kept, *new]).astype(np.int32),
        np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
    )
