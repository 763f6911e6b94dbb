"""Network -> surface: every cycle a patch, on the vertices that the network's patches share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
from patterndb_sketch.surfacing.methods import Settings, start_of, surface_loop, turned
from patterndb_sketch.surfacing.network import CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.patch import (
    LoopSurface,
    Method,
    SurfacePatch,
    Surfacing,
    as_triangles,
)
from patterndb_sketch.surfacing.quads import even_edges
from patterndb_sketch.surfacing.sampling import (
    EDGES_OF_MEDIAN_CURVE,
    EDGES_OF_MEDIAN_QUADS,
    Sampling,
    default_spacing,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import find_self_intersections
from query.engine import PatternSource

NO_POINTS = np.zeros((0, 3))
NOT_LEAST = "edge counts are even, but not proven to be the nearest to the spacing"

#: Loops that so many stages in a row have not met are forgotten: an undone stroke may be redone.
STAGES_KEPT = 16


def surface(
    network: CurveNetwork,
    cycles: Sequence[Cycle] | None = None,
    *,
    settings: Settings | None = None,
    methods: Mapping[Cycle, Method] | None = None,
    spacing: float | None = None,
    db: PatternSource | None = None,
    memory: LoopMemory | None = None,
) -> Surfacing:
    """The surface of a network: a patch for each of its cycles.

    cycles:   what to surface, by default the network's own. For a network that has none, find
              them first (:func:`patterndb_sketch.surfacing.cycles.find_cycles`).
    settings: the method and its parameters.
    methods:  another method for some of the cycles.
    spacing:  about how far vertices are apart, by default
              :func:`patterndb_sketch.surfacing.sampling.default_spacing`. Where a patch is to
              have quads, edges are counted such that every cycle has an even number.
    db:       where quads come from; needed for that method.
    memory:   loops surfaced before; those met again are taken from it, new ones are added.

    Raises InvalidNetworkError for a network without curves or cycles, for a cycle that is no
    closed walk along it, and for quads without a database. A cycle that no method can surface
    has a patch without faces, whose note tells why.
    """
    settings = Settings() if settings is None else settings
    chosen = network.cycles if cycles is None else tuple(cycles)
    ways = [settings.method if methods is None else methods.get(c, settings.method) for c in chosen]
    if not chosen:
        raise InvalidNetworkError("the network has no cycles to surface; find them first")
    quads = "quads" in ways
    if quads and db is None:
        raise InvalidNetworkError("quads come from a pattern database; give one as db")
    coarse = EDGES_OF_MEDIAN_QUADS if quads else EDGES_OF_MEDIAN_CURVE
    step = default_spacing(network, coarse) if spacing is None else spacing
    even = even_edges(network, chosen, step) if quads else None
    sampling = sample(network, step, None if even is None else even.edges)
    notes = () if even is None or even.least else (NOT_LEAST,)
    memory = LoopMemory() if memory is None else memory
    points = [sampling.points]
    patches: list[SurfacePatch] = []
    n_points = len(sampling.points)
    for cycle, way in zip(chosen, ways, strict=True):
        patch, inner = _patch(
            network, sampling, cycle, replace(settings, method=way), db, memory, n_points
        )
        patches.append(patch)
        points.append(inner)
        n_points += len(inner)
    together = np.concatenate(points)
    between = _intersections(together, patches)
    return Surfacing(network, sampling, together, tuple(patches), between, notes)


def _patch(
    network: CurveNetwork,
    sampling: Sampling,
    cycle: Cycle,
    settings: Settings,
    db: PatternSource | None,
    memory: LoopMemory,
    n_points: int,
) -> tuple[SurfacePatch, Points]:
    """A cycle's patch and its inner vertices, which are numbered from ``n_points`` on."""
    network.walk(cycle)
    try:
        loop = loop_of(network, sampling, cycle)
        # Every loop is surfaced from the same vertex on in the same sense, wherever its cycle
        # begins: the result does not depend on that, and a loop met again is known.
        start, backward = start_of(loop.points)
        upright = turned(loop, start, backward)
        key = repr((settings, sampling.spacing)).encode()
        key += upright.points.tobytes() + upright.corners.tobytes()
        result = memory.recall(key)
        reused = result is not None
        if result is None:
            result = surface_loop(upright, settings, sampling.spacing, db)
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


def _intersections(points: Points, patches: Sequence[SurfacePatch]) -> int:
    triangles = [as_triangles(patch.faces) for patch in patches]
    owner = np.repeat(np.arange(len(patches)), [len(part) for part in triangles])
    if len(owner) == 0:
        return 0
    pairs = find_self_intersections(points, np.concatenate(triangles))
    return int((owner[pairs[:, 0]] != owner[pairs[:, 1]]).sum())


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

    settings: the method and its parameters; may be changed between stages.
    spacing:  about how far vertices are apart. Where it is not given, the default of the first
              stage that has a cycle stays: another one would move the vertices of every loop.
    db:       where quads come from.
    """

    settings: Settings = field(default_factory=Settings)
    spacing: float | None = None
    db: PatternSource | None = None
    _memory: LoopMemory = field(default_factory=LoopMemory, repr=False)

    def stage(
        self,
        network: CurveNetwork,
        *,
        added: Sequence[Cycle] = (),
        banned: Sequence[Cycle] = (),
        methods: Mapping[Cycle, Method] | None = None,
    ) -> Stage:
        """The surface of the sketch as it is now.

        added, banned: cycles of this network that shall, or shall not, be patches. methods:
        another method for some cycles. Raises as
        :func:`patterndb_sketch.surfacing.cycles.find_cycles` and
        :func:`patterndb_sketch.surfacing.surface.surface` do.
        """
        found = find_cycles(network, added=added, banned=banned)
        if not found.cycles:
            return Stage(found, None)
        if self.spacing is None:
            self.spacing = default_spacing(network)
        result = surface(
            network,
            found.cycles,
            settings=self.settings,
            methods=methods,
            spacing=self.spacing,
            db=self.db,
            memory=self._memory,
        )
        self._memory.end_stage()
        return Stage(found, result)
