"""How cycles are found where a network brings none."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from patterndb_sketch.surfacing.network import CurveNetwork, Cycle

#: Finds the cycles of a network: (network, added, banned) -> cycles, and notes on them.
Find = Callable[
    [CurveNetwork, Sequence[Cycle], Sequence[Cycle]], tuple[Sequence[Cycle], Sequence[str]]
]


def found(
    network: CurveNetwork, added: Sequence[Cycle], banned: Sequence[Cycle]
) -> tuple[Sequence[Cycle], Sequence[str]]:
    """As :func:`patterndb_sketch.surfacing.cycles.find_cycles`."""
    # Its solver takes a second to import, which networks with cycles need not wait for.
    from patterndb_sketch.surfacing.cycles import find_cycles

    result = find_cycles(network, added=added, banned=banned)
    return result.cycles, result.notes
