"""Found cycles, and what their user must be told."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from patterndb_sketch.surfacing.cycles.consistency import pinched, users
from patterndb_sketch.surfacing.cycles.pruning import dangling
from patterndb_sketch.surfacing.network import Cycle, Network


@dataclass(frozen=True, slots=True)
class FoundCycles:
    """The cycles of a network.

    cycles:      the cycles; neighbours walk a shared curve in opposite senses where the surface
                 can be oriented.
    dangling:    numbers of curves that end where nothing goes on, and bound nothing.
    unused:      numbers of other curves that bound no cycle.
    once:        numbers of curves that bound one cycle only: the surface's boundary.
    candidates:  how many cycles were considered.
    cut_short:   pairs of curves for which not all closing paths were looked through.
    proven:      is there surely no better choice among the candidates that took part? False too
                 where a choice was mended because it was no surface.
    orientable:  could all cycles be oriented?
    pinches:     nodes around which a surface is closed while other cycles touch it there.
    notes:       the same in words, for what a user should look at; empty if all is well.
    """

    cycles: tuple[Cycle, ...]
    dangling: tuple[int, ...] = ()
    unused: tuple[int, ...] = ()
    once: tuple[int, ...] = ()
    candidates: int = 0
    cut_short: int = 0
    proven: bool = True
    orientable: bool = True
    pinches: tuple[int, ...] = ()
    notes: tuple[str, ...] = field(default=(), repr=False)


def told(
    network: Network,
    cycles: tuple[Cycle, ...],
    twisted: bool,
    candidates: int,
    cut_short: int,
    proven: bool,
) -> FoundCycles:
    """The cycles with what is to be known about them.

    twisted: can they not be oriented? The others as in :class:`FoundCycles`.
    """
    gone = dangling(network)
    count = {curve: len(walks) for curve, walks in users(cycles).items()}
    living = np.flatnonzero(~gone).tolist()
    unused = tuple(curve for curve in living if curve not in count)
    once = tuple(curve for curve in living if count.get(curve) == 1)
    pinches = tuple(sorted({node for node, _ in pinched(network, cycles)}))
    notes: list[str] = []

    def note(number: int, one: str, many: str) -> None:
        if number:
            notes.append(f"1 {one}" if number == 1 else f"{number:,} {many}")

    note(
        int(gone.sum()),
        "curve dangles and bounds no cycle",
        "curves dangle and bound no cycle",
    )
    note(len(unused), "other curve bounds no cycle", "other curves bound no cycle")
    note(
        cut_short,
        "pair of curves was not closed in all ways: too many paths",
        "pairs of curves were not closed in all ways: too many paths",
    )
    note(
        len(pinches),
        "node is pinched: a closed surface is touched there by another",
        "nodes are pinched: a closed surface is touched there by another",
    )
    if not proven:
        notes.append(
            "a better choice among the cycles considered may exist: this one is not proven best"
        )
    if twisted:
        notes.append("the surface cannot be oriented: it turns over, as a Moebius strip does")
    return FoundCycles(
        cycles,
        tuple(np.flatnonzero(gone).tolist()),
        unused,
        once,
        candidates,
        cut_short,
        proven,
        not twisted,
        pinches,
        tuple(notes),
    )
