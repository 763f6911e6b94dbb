"""Growing sketches: surfaced anew at every stage, with only what changed worked out again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
from patterndb_sketch.surfacing.memory import Memory
from patterndb_sketch.surfacing.network import Cycle, Network
from patterndb_sketch.surfacing.patch import Method, Surfacing
from patterndb_sketch.surfacing.sampling import default_spacing
from patterndb_sketch.surfacing.surface import surface
from patterndb_sketch.surfacing.surfaceloop import Settings
from query.engine import PatternSource


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
    _memory: Memory = field(default_factory=Memory, repr=False)

    def stage(
        self,
        network: Network,
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
