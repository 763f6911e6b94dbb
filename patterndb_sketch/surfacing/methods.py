"""Loop -> surface, by the method asked for or, where that cannot answer, by the next."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.chords import (
    ALPHA,
    AREA_PRICE,
    MAX_SUBPROBLEMS,
    TURNING_BOUND,
    Decomposition,
    Flatness,
    decompose,
)
from patterndb_sketch.surfacing.network import InvalidNetworkError
from patterndb_sketch.surfacing.patch import LoopSurface, Method, as_triangles
from patterndb_sketch.surfacing.quads import fill_with_quads
from patterndb_sketch.surfacing.sampling import Loop
from patterndb_sketch.surfacing.tessellation import (
    area,
    find_self_intersections,
    patch_of_least_area,
    tessellate_patch,
)
from query.engine import PatternSource


@dataclass(frozen=True, slots=True)
class Settings:
    """How loops are surfaced.

    method:           chords, area or quads, see :data:`patterndb_sketch.surfacing.patch.Method`.
    alpha:            the price of chords (section 3.2); more makes fewer, larger pieces.
    area_price:       the area that chords may add, see
    :func:`patterndb_sketch.surfacing.chords.affordable`;
                      None, as in the paper: any.
    flatness:         "relative", or "printed" as in the paper: the product of eigenvalues.
    turning_bound:    radians by which a loop may turn between two chord endpoints.
    max_subproblems:  what the search for chords may score.
    """

    method: Method = "chords"
    alpha: float = ALPHA
    area_price: float | None = AREA_PRICE
    flatness: Flatness = "relative"
    turning_bound: float = TURNING_BOUND
    max_subproblems: int = MAX_SUBPROBLEMS

    def __post_init__(self) -> None:
        if self.method not in ("chords", "area", "quads"):
            raise InvalidNetworkError(
                f'the method is {self.method!r}; give "chords", "area" or "quads"'
            )
        if not (math.isfinite(self.alpha) and self.alpha >= 0):
            raise InvalidNetworkError(f"alpha is {self.alpha}; give a number from 0 on")


def surface_loop(
    loop: Loop, settings: Settings, spacing: float, db: PatternSource | None = None
) -> LoopSurface:
    """The surface of a loop: the method asked for, else chords, else the least area.

    spacing: about how far inner vertices are apart. db: where quads come from. Never fails on
    a valid loop: the triangulation of least area always exists.
    """
    started = time.perf_counter()
    if settings.method == "area":
        found = _by_area(loop, "")
    elif settings.method == "chords" or db is None:
        found = _by_chords(loop, settings, spacing, "")
    else:
        found = _by_quads(loop, settings, spacing, db)
    return _measured(loop, found, time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class _Found:
    """What a method made, before it is measured. cut: how the loop was cut, if it was."""

    method: Method
    note: str
    points: Points
    faces: tuple[Int64Array, ...]
    cut: Decomposition | None = None


def _by_area(loop: Loop, note: str, cut: Decomposition | None = None) -> _Found:
    mesh = patch_of_least_area(loop)
    return _Found("area", note, mesh.points, mesh.faces, cut)


def _by_chords(loop: Loop, settings: Settings, spacing: float, note: str) -> _Found:
    cut = decompose(
        loop,
        settings.alpha,
        area_price=settings.area_price,
        flatness=settings.flatness,
        turning_bound=settings.turning_bound,
        max_subproblems=settings.max_subproblems,
    )
    if cut.exhausted:
        why = (
            "half of the candidate chords already make more than "
            f"{settings.max_subproblems:,} sub-problems; the triangulation of least area stands in"
        )
        return _by_area(loop, _joined(note, why), cut)
    if cut.n_dropped:
        note = _joined(
            note, f"the {cut.n_dropped} longest candidates were left out of a search too large"
        )
    mesh = tessellate_patch(loop, cut.chords, cut.pieces, spacing)
    return _Found("chords", _joined(note, *mesh.notes), mesh.points, mesh.faces, cut)


def _by_quads(loop: Loop, settings: Settings, spacing: float, db: PatternSource) -> _Found:
    ground = _by_chords(loop, settings, spacing, "")
    points = np.concatenate([loop.points, ground.points])
    try:
        filled = fill_with_quads(db, loop, points, as_triangles(ground.faces))
    except InvalidNetworkError as error:
        return replace(ground, note=_joined(f"no quads: {error}", ground.note))
    return _Found("quads", _joined(ground.note, filled.note), filled.points, (filled.quads,))


def _measured(loop: Loop, found: _Found, seconds: float) -> LoopSurface:
    points = np.concatenate([loop.points, found.points])
    cut = found.cut
    return LoopSurface(
        method=found.method,
        note=found.note,
        points=found.points,
        faces=found.faces,
        candidates=0 if cut is None else len(cut.candidates),
        costly=0 if cut is None else cut.n_costly,
        unmatched=0 if cut is None else cut.n_unmatched,
        chords=np.zeros((0, 2), np.int64) if cut is None else cut.chords,
        n_subproblems=0 if cut is None else cut.n_subproblems,
        cost=math.nan if cut is None else cut.cost,
        area=sum(area(points, piece) for piece in found.faces),
        self_intersections=len(find_self_intersections(points, as_triangles(found.faces))),
        seconds=seconds,
    )


def _joined(*notes: str) -> str:
    return "; ".join(note for note in notes if note)


def start_of(points: Points) -> tuple[int, bool]:
    """Where, and in which sense, a closed loop (n, 3) is walked by convention.

    It begins at its lowest vertex by x, then y, then z, and goes on to the lower of the two
    beside: that depends on the loop alone, not on how it was handed over.
    """
    n = len(points)
    start = int(np.lexsort(points.T[::-1])[0])
    after, before = points[(start + 1) % n].tolist(), points[start - 1].tolist()
    return start, before < after


def turned(loop: Loop, start: int, backward: bool) -> Loop:
    """The same loop from vertex ``start`` on, walked the other way round if ``backward``."""
    order = (start + np.arange(len(loop.points)) * (-1 if backward else 1)) % len(loop.points)
    return Loop(loop.points[order], loop.corners[order], loop.vertices[order])
