"""What is known of loops that were surfaced before, so that unchanged ones are not done again."""

from __future__ import annotations

from patterndb_sketch.surfacing.patch import LoopSurface

#: Loops that so many stages in a row have not met are forgotten: an undone stroke may be redone.
STAGES_KEPT = 16


class Memory:
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
