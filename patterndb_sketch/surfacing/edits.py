"""What the user has made of a drawing: cycles on and off, methods, strokes, new curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import (
    CurveNetwork,
    Cycle,
    InvalidNetworkError,
    Step,
    turn_walk,
)
from patterndb_sketch.surfacing.inking import InkedStroke, add_ink_curves
from patterndb_sketch.surfacing.methods import DEFAULT_METHOD, METHODS

#: A cycle's key: what two cycles that differ in start and sense only have in common.
Key = tuple[tuple[int, bool], ...]


@dataclass(frozen=True, slots=True, eq=False)
class SurfacingEdits:
    """A drawing, and all that can be taken back step by step.

    drawing: with new curves in it. stage: after how many of its stages it is looked at.
    given:   the cycles that it came with, None if they are to be found. Cycles go by the curves
             of the whole drawing, in every stage.
    added, banned: cycles that shall, or shall not, be patches.
    method:  of all patches; methods: of some others, by the cycle's key.
    inks:    the strokes on the surface.
    """

    drawing: Drawing
    stage: int
    given: tuple[Cycle, ...] | None
    added: tuple[Cycle, ...] = ()
    banned: tuple[Cycle, ...] = ()
    method: str = DEFAULT_METHOD
    methods: Mapping[Key, str] = field(default_factory=dict)
    inks: tuple[InkedStroke, ...] = ()

    def asks_like(self, other: SurfacingEdits) -> bool:
        """Is the same surface made of both? Strokes on it are no matter."""
        return (
            self.drawing is other.drawing
            and self.given is other.given
            and (self.stage, self.added, self.banned) == (other.stage, other.added, other.banned)
            and (self.method, self.methods) == (other.method, other.methods)
        )

    def switched_off(self, cycle: Cycle) -> SurfacingEdits:
        """With a cycle that is no patch."""
        added = _without(self.added, cycle)
        return replace(self, added=added, banned=(*_without(self.banned, cycle), cycle))

    def switched_on(self, cycle: Cycle) -> SurfacingEdits:
        """With a cycle that is a patch, whatever else there is."""
        banned = _without(self.banned, cycle)
        # What came with the network is there by itself.
        there = self.given is not None and cycle.key in {c.key for c in self.given}
        added = self.added if there else (*_without(self.added, cycle), cycle)
        return replace(self, added=added, banned=banned)

    def with_method(self, method: str) -> SurfacingEdits:
        """With one method for all patches."""
        return replace(self, method=method, methods={})

    def with_method_of(self, cycle: Cycle, method: str) -> SurfacingEdits:
        """With a method for the patch of one cycle."""
        return replace(self, methods={**self.methods, cycle.key: method})

    def with_stroke(self, ink: InkedStroke, reach: float) -> SurfacingEdits:
        """With a stroke as curves of the network, which come at this stage.

        reach: as for :func:`patterndb_sketch.surfacing.inking.add_ink_curves`, which also says
        what is raised. Cycles that came with the network are cut where the stroke
        cuts them.
        """
        grown = add_ink_curves(self.drawing, ink, reach, self.stage)
        after = grown.drawing.network
        given = None
        if self.given is not None:
            given = tuple(
                part
                for cycle in _carried(after, self.given, grown.walks)
                for part in cut_cycle(after, cycle, grown.curves)
            )
        methods: dict[Key, str] = {}
        for key, method in self.methods.items():
            for cycle in _carried(after, [Cycle(key)], grown.walks):
                methods |= {p.key: method for p in cut_cycle(after, cycle, grown.curves)}
        return replace(
            self,
            drawing=grown.drawing,
            stage=self.stage + bool(self.drawing.stages),
            given=given,
            added=_carried(after, self.added, grown.walks),
            banned=_carried(after, self.banned, grown.walks),
            methods=methods,
            inks=tuple(other for other in self.inks if other is not ink),
        )


def choose_next_method(method: str, *, database: bool) -> str:
    """Name the method after this one; database: is there one for those that need it?"""
    choices = [one.name for one in METHODS.values() if database or not one.needs_database]
    return choices[(choices.index(method) + 1) % len(choices)] if method in choices else choices[0]


def cut_cycle(network: CurveNetwork, cycle: Cycle, curves: Sequence[int]) -> list[Cycle]:
    """Cut a cycle along curves from side to side: the cycles; it alone if none cuts it.

    Each curve cuts the part that has both its ends.
    """
    parts = [cycle]
    for curve in curves:
        first, last = network.curves[curve].nodes
        for i, part in enumerate(parts):
            nodes = network.walk(part)
            if first == last or first not in nodes or last not in nodes:
                continue
            begin, end = nodes.index(first), nodes.index(last)
            steps = (*part.steps[begin:], *part.steps[:begin])
            turn = (end - begin) % len(nodes)
            one = Cycle((*steps[:turn], (curve, True)))
            other = Cycle(((curve, False), *steps[turn:]))
            parts[i : i + 1] = [one, other]
            break
    return parts


def _carried(
    network: CurveNetwork, cycles: Sequence[Cycle], walks: Sequence[tuple[Step, ...]]
) -> tuple[Cycle, ...]:
    """The cycles along what their curves have become; those that have broken are left out."""
    kept: list[Cycle] = []
    for cycle in cycles:
        steps: list[Step] = []
        for curve, backward in cycle.steps:
            steps += turn_walk(walks[curve]) if backward else walks[curve]
        again = Cycle(tuple(steps))
        try:
            network.walk(again)
        except InvalidNetworkError:
            continue
        kept.append(again)
    return tuple(kept)


def _without(cycles: Sequence[Cycle], cycle: Cycle) -> tuple[Cycle, ...]:
    return tuple(other for other in cycles if other.key != cycle.key)
