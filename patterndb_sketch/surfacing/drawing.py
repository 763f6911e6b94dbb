"""Drawings: a network, the stages in which it was drawn, and what was left out of it."""

from __future__ import annotations

from dataclasses import dataclass

from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.network import Cycle, Network


@dataclass(frozen=True, slots=True)
class Drawing:
    """A network as a file has it.

    network: all of it.
    stages:  the numbers of the curves that were drawn in every stage, in the order of drawing;
             empty if the file does not say. A curve that a later one splits is in its parts
             from the start.
    notes:   what was left out or changed on the way, a sentence each.
    """

    network: Network
    stages: tuple[tuple[int, ...], ...] = ()
    notes: tuple[str, ...] = ()

    def after(self, n_stages: int) -> Network:
        """The network as it was after some stages, 0 to all: their curves, in their order.

        The nodes are those of the whole network, with the same numbers. A cycle that the file
        gives is there as soon as all its curves are. Raises InvalidNetworkError for a number
        of stages that the drawing does not have.
        """
        if not 0 <= n_stages <= len(self.stages):
            raise InvalidNetworkError(
                f"after {n_stages} stages: the drawing has {len(self.stages)}; give 0 to "
                f"{len(self.stages)}"
            )
        drawn = sorted({curve for stage in self.stages[:n_stages] for curve in stage})
        number = {curve: i for i, curve in enumerate(drawn)}
        cycles = [
            Cycle(tuple((number[curve], backward) for curve, backward in cycle.steps))
            for cycle in self.network.cycles
            if all(curve in number for curve in cycle.curves)
        ]
        curves = tuple(self.network.curves[curve] for curve in drawn)
        return Network(curves, self.network.nodes, tuple(cycles))
