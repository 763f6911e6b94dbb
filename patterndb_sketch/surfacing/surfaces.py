"""Loops and networks -> surfaces: every cycle a patch, on vertices that neighbours share.

:func:`surface_loop` makes the surface of one loop, :func:`surface` that of a network, patch by
patch; a :class:`GrowingSketch` does so at every stage, with only what changed worked out again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import find_turned_corners
from patterndb.system.requests import make_request
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
from patterndb_sketch.surfacing.cycles.found import list_users
from patterndb_sketch.surfacing.fairing import (
    FilledLoop,
    fair_patches,
    find_guided_curves,
    find_smooth_curves,
)
from patterndb_sketch.surfacing.methods import (
    DEFAULT_METHOD,
    METHODS,
    MadeSurface,
    SurfaceRequest,
)
from patterndb_sketch.surfacing.patch import LoopSurface, SurfacePatch, Surfacing, as_triangles
from patterndb_sketch.surfacing.quads import count_even_edges
from patterndb_sketch.surfacing.sampling import (
    EDGES_OF_MEDIAN_CURVE,
    EDGES_OF_MEDIAN_QUADS,
    Loop,
    Sampling,
    count_coarse_edges,
    default_spacing,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import area, find_self_intersections
from query.engine import PatternSource

NO_POINTS = np.zeros((0, 3))

#: Loops that so many stages in a row have not met are forgotten: an undone stroke may be redone.
STAGES_KEPT = 16


def surface_loop(
    loop: Loop, options: SurfaceRequest, spacing: float, db: PatternSource | None = None
) -> LoopSurface:
    """Make the surface of a loop by the method asked for, else by another that its note names.

    spacing: about how far inner vertices are apart. db: where quads come from. Never fails on
    a valid loop: the triangulation of least area always exists.
    """
    started = perf_counter()
    method = METHODS[options.method]
    if method.needs_database and db is None:
        method = METHODS[DEFAULT_METHOD]
    made = method.make(loop, options, spacing, db)
    return _measure(loop, made, perf_counter() - started)


def _measure(loop: Loop, made: MadeSurface, seconds: float) -> LoopSurface:
    points = np.concatenate([loop.points, made.points])
    cut = made.cut
    return LoopSurface(
        method=made.method,
        note=made.note,
        points=made.points,
        faces=made.faces,
        candidates=0 if cut is None else len(cut.candidates),
        costly=0 if cut is None else cut.n_costly,
        unmatched=0 if cut is None else cut.n_unmatched,
        chords=np.zeros((0, 2), np.int64) if cut is None else cut.chords,
        n_subproblems=0 if cut is None else cut.n_subproblems,
        cost=math.nan if cut is None else cut.cost,
        area=sum(area(points, piece) for piece in made.faces),
        self_intersections=len(find_self_intersections(points, as_triangles(made.faces))),
        seconds=seconds,
        corners=made.corners,
        turned=sum(
            int(find_turned_corners(piece, points).any(axis=1).sum())
            for piece in made.faces
            if piece.shape[1] == 4
        ),
    )


def surface(
    network: CurveNetwork,
    cycles: Sequence[Cycle] | None = None,
    request: SurfaceRequest | None = None,
    *,
    methods: Mapping[Cycle, str] | None = None,
    db: PatternSource | None = None,
    memory: LoopMemory | None = None,
    **options: Any,
) -> Surfacing:
    """Make the surface of a network: a patch for each of its cycles.

    cycles:   what to surface, by default the network's own. For a network that has none, find
              them first (:func:`patterndb_sketch.surfacing.cycles.find_cycles`).
    request, options: see SurfaceRequest; options are its entries, alone or in place of those of a
              request. Flat faces of the method smooth have vertices at their
              outline alone, straight curves between them at their ends. Where a patch is to have
              quads, edges are counted such that every cycle has an even number, and a regular fill
              where the network allows it.
    methods:  the names of other methods for some of the cycles.
    db:       where quads come from; needed for that method.
    memory:   loops surfaced before; those met again are taken from it, new ones are added.

    Raises InvalidNetworkError for a network without curves or cycles, for a cycle that is no
    closed walk along it, and for quads without a database. A cycle that no method can surface
    has a patch without faces, whose note tells why.
    """
    asked = make_request(SurfaceRequest, request, options)
    chosen = network.cycles if cycles is None else tuple(cycles)
    named = {} if methods is None else methods
    wanted = [asked.having(method=named.get(c, asked.method)) for c in chosen]
    if not chosen:
        raise InvalidNetworkError("the network has no cycles to surface; find them first")
    ways = [METHODS[one.method] for one in wanted]
    lacking = [way.name for way in ways if way.needs_database and db is None]
    if lacking:
        raise InvalidNetworkError(f"{lacking[0]} come from a pattern database; give one as db")
    quads = any(way.makes_quads for way in ways)
    median = EDGES_OF_MEDIAN_QUADS if quads else EDGES_OF_MEDIAN_CURVE
    step = default_spacing(network, median) if asked.spacing is None else asked.spacing
    if quads:
        edges = count_even_edges(network, chosen, step).edges
    else:
        coarse = [way.coarsens_flat for way in ways]
        edges = count_coarse_edges(network, chosen, coarse, step)
    sampling = sample(network, step, edges)
    notes: tuple[str, ...] = ()
    memory = LoopMemory() if memory is None else memory
    points = [sampling.points]
    patches: list[SurfacePatch] = []
    n_points = len(sampling.points)
    for cycle, of_cycle in zip(chosen, wanted, strict=True):
        patch, inner = _make_patch(network, sampling, cycle, of_cycle, db, memory, n_points)
        patches.append(patch)
        points.append(inner)
        n_points += len(inner)
    if asked.fair or any(curve.normals is not None for curve in network.curves):
        patches, told = _fair_patches(network, sampling, patches, asked.fair)
        notes += told
        points[1:] = [p.surface.points for p in patches if p.surface is not None]
    together = np.concatenate(points)
    crossings = _find_crossings(together, patches)
    return Surfacing(network, sampling, together, tuple(patches), crossings, notes)


def _make_patch(
    network: CurveNetwork,
    sampling: Sampling,
    cycle: Cycle,
    options: SurfaceRequest,
    db: PatternSource | None,
    memory: LoopMemory,
    n_points: int,
) -> tuple[SurfacePatch, Points]:
    """Make a cycle's patch and its inner vertices, which are numbered from ``n_points`` on."""
    network.walk(cycle)
    try:
        loop = loop_of(network, sampling, cycle)
        # Every loop is surfaced from the same vertex on in the same sense, wherever its cycle
        # begins: the result does not depend on that, and a loop met again is known.
        start, backward = find_start(loop.points)
        upright = turn_loop(loop, start, backward)
        key = repr(options.having(fair=False, spacing=sampling.spacing)).encode()
        key += upright.points.tobytes() + upright.corners.tobytes()
        result = memory.recall(key)
        reused = result is not None
        if result is None:
            result = surface_loop(upright, options, sampling.spacing, db)
            memory.remember(key, result)
    except InvalidNetworkError as error:
        # The other patches are none the worse for one that cannot be had.
        return SurfacePatch(
            cycle, (), np.zeros((0, 2), np.int64), None, str(error), False
        ), NO_POINTS
    names = np.r_[upright.vertices, n_points + np.arange(len(result.points))]
    faces = tuple(names[piece[:, ::-1] if backward else piece] for piece in result.faces)
    return SurfacePatch(
        cycle, faces, names[result.chords], result, result.note, reused
    ), result.points


def _fair_patches(
    network: CurveNetwork, sampling: Sampling, patches: Sequence[SurfacePatch], fair: bool
) -> tuple[list[SurfacePatch], tuple[str, ...]]:
    """The patches, their grids moved so that they have the normals that curves are given, and
    share them across smooth curves if they are to be fair; and notes.

    A patch that would pass through itself in more places stays as it is, and says so.
    """
    cycles = [patch.cycle for patch in patches if patch.surface is not None]
    guides = find_guided_curves(network, sampling, cycles)
    guided = {guide.curve for guide in guides}
    curves = find_smooth_curves(network, sampling, cycles) if fair else []
    curves = [one for one in curves if one.curve not in guided]
    placed: list[FilledLoop] = []
    for patch in patches:
        if patch.surface is not None:
            loop = loop_of(network, sampling, patch.cycle)
            loop = turn_loop(loop, *find_start(loop.points))
            points = np.concatenate([loop.points, patch.surface.points])
            faces = as_triangles(patch.surface.faces)
            placed.append(FilledLoop(loop, patch.surface.corners, points, faces))
    moved = iter(zip(placed, fair_patches(sampling, placed, curves, guides), strict=True))
    faired: list[SurfacePatch] = []
    for patch in patches:
        before = patch.surface
        if before is not None:
            one, inner = next(moved)
            if inner is not None:
                after = _move_inner(one, before, inner)
                patch = replace(patch, surface=after, note=after.note)
        faired.append(patch)
    # A curve between two patches without grids is as it was.
    curves = [one for one in curves if any(placed[k].corners for k in one.patches)]
    between = sum(len(users) == 2 for users in list_users(cycles).values())
    notes: tuple[str, ...] = ()
    if fair:
        notes += (f"faired across {len(curves)} of {between} curves between patches",)
    if guides:
        followed = sum(any(placed[k].corners for k in guide.patches) for guide in guides)
        notes += (
            f"normals followed along {followed} of {len(guides)} curves that have them; flat "
            "patches and those of other methods than smooth do not follow them",
        )
    return faired, notes


def _move_inner(patch: FilledLoop, before: LoopSurface, inner: Points) -> LoopSurface:
    """A loop's surface with its inner vertices elsewhere, unless it would cross itself more."""
    points = np.concatenate([patch.loop.points, inner])
    crossed = len(find_self_intersections(points, patch.faces))
    if crossed > before.self_intersections:
        note = "not faired: its faces would pass through each other"
        return replace(before, note="; ".join(filter(None, (before.note, note))))
    covered = sum(area(points, piece) for piece in before.faces)
    return replace(before, points=inner, area=covered, self_intersections=crossed)


def find_start(points: Points) -> tuple[int, bool]:
    """Tell where, and in which sense, a closed loop (n, 3) is walked by convention.

    It begins at its lowest vertex by x, then y, then z, and goes on to the lower of the two
    beside: that depends on the loop alone, not on how it was handed over.
    """
    n = len(points)
    start = int(np.lexsort(points.T[::-1])[0])
    after, before = points[(start + 1) % n].tolist(), points[start - 1].tolist()
    return start, before < after


def turn_loop(loop: Loop, start: int, backward: bool) -> Loop:
    """Begin a loop at vertex ``start``, and walk it the other way round if ``backward``."""
    order = (start + np.arange(len(loop.points)) * (-1 if backward else 1)) % len(loop.points)
    return Loop(loop.points[order], loop.corners[order], loop.vertices[order])


def _find_crossings(
    points: Points, patches: Sequence[SurfacePatch]
) -> tuple[tuple[int, int, int], ...]:
    """The pairs of patches that pass through each other, as :class:`Surfacing` has them."""
    triangles = [as_triangles(patch.faces) for patch in patches]
    owner = np.repeat(np.arange(len(patches)), [len(part) for part in triangles])
    if len(owner) == 0:
        return ()
    faces = find_self_intersections(points, np.concatenate(triangles))
    pairs = np.sort(owner[faces].reshape(-1, 2), axis=1)
    pairs, counts = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0, return_counts=True)
    found = [(i, j, n) for (i, j), n in zip(pairs.tolist(), counts.tolist(), strict=True)]
    return tuple(sorted(found, key=lambda one: (-one[2], one)))


class LoopMemory:
    """Surfaces of loops by what they depend on.

    Loops count as met when they are recalled or remembered; :meth:`end_stage` forgets those
    that have not been met for STAGES_KEPT stages.
    """

    __slots__ = ("_known", "_last_met", "_stage")

    def __init__(self) -> None:
        self._known: dict[bytes, LoopSurface] = {}
        self._last_met: dict[bytes, int] = {}
        self._stage = 0

    def __len__(self) -> int:
        return len(self._known)

    def recall(self, key: bytes) -> LoopSurface | None:
        """The surface kept under the key, None if there is none."""
        if key in self._known:
            self._last_met[key] = self._stage
        return self._known.get(key)

    def remember(self, key: bytes, surface: LoopSurface) -> None:
        """Keep a surface under the key."""
        self._known[key] = surface
        self._last_met[key] = self._stage

    def end_stage(self) -> None:
        """Forget what has not been met for long."""
        self._stage += 1
        for key in [k for k, last in self._last_met.items() if last < self._stage - STAGES_KEPT]:
            del self._known[key], self._last_met[key]


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage of a growing sketch.

    found:     the cycles of this stage, and what is to be known about them.
    surfacing: the surface, None as long as there is no cycle.
    """

    found: FoundCycles
    surfacing: Surfacing | None


@dataclass(slots=True)
class GrowingSketch:
    """A sketch whose surface follows it from stage to stage.

    Cycles are found afresh at every stage. Loops that were there before, with the same
    vertices, corners and settings, keep their surface: the result equals a run from scratch.

    options: the method and its parameters; may be changed between stages.
    spacing: that of the latest stage. Where the options have none, the default of the first stage
             that has a cycle stays: another one would move the vertices of every loop.
    db:      where quads come from.
    """

    options: SurfaceRequest = field(default_factory=SurfaceRequest)
    db: PatternSource | None = None
    spacing: float | None = field(default=None, init=False)
    _memory: LoopMemory = field(default_factory=LoopMemory, repr=False)

    def stage(
        self,
        network: CurveNetwork,
        *,
        added: Sequence[Cycle] = (),
        banned: Sequence[Cycle] = (),
        methods: Mapping[Cycle, str] | None = None,
    ) -> Stage:
        """Make the surface of the sketch as it is now.

        added, banned: cycles of this network that shall, or shall not, be patches. methods:
        another method for some cycles. Raises as
        :func:`patterndb_sketch.surfacing.cycles.find_cycles` and
        :func:`patterndb_sketch.surfacing.surfaces.surface` do.
        """
        found = find_cycles(network, added=added, banned=banned)
        if not found.cycles:
            return Stage(found, None)
        if self.options.spacing is not None:
            self.spacing = self.options.spacing
        elif self.spacing is None:
            self.spacing = default_spacing(network)
        result = surface(
            network,
            found.cycles,
            self.options.having(spacing=self.spacing),
            methods=methods,
            db=self.db,
            memory=self._memory,
        )
        self._memory.end_stage()
        return Stage(found, result)
