"""A small network for the viewer's tests: a hemisphere of four patches, drawn in stages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.naming import named_cycle
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.methods import SurfaceRequest
from tests.support.viewer.sayings import read_sheet
from viewer.facts import FactSheet
from viewer.keymap import Effect
from viewer.surfacing.commands import KEYS
from viewer.surfacing.picture import compose_surface, describe_surface
from viewer.surfacing.state import SurfacingState

#: The patches of the dome: a quarter of the rim and two meridians each.
CYCLES = tuple(Cycle(((i, False), (4 + (i + 1) % 4, False), (4 + i, True))) for i in range(4))


#: How high the waves of the rim are: alpha then has several answers.
WAVES = 0.2


def dome(cycles: Sequence[Cycle] = CYCLES) -> CurveNetwork:
    """Curves 0 to 3 are the wavy rim from node to node, 4 to 7 lead from there to the top."""
    turn = np.linspace(0.0, np.pi / 2.0, 17)
    nodes = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]], np.float64)

    def arc(a: int, b: int) -> Curve:
        points = np.cos(turn)[:, None] * nodes[a] + np.sin(turn)[:, None] * nodes[b]
        if b != 4:
            points[:, 2] += WAVES * np.sin(4.0 * turn) ** 2
        points[[0, -1]] = nodes[[a, b]]
        return Curve(points, (a, b), f"{a}-{b}", f"{a}-{b}")

    curves = [arc(i, (i + 1) % 4) for i in range(4)] + [arc(i, 4) for i in range(4)]
    return CurveNetwork(tuple(curves), nodes, tuple(cycles))


def growing_dome() -> Drawing:
    """The dome without cycles: the rim first, then meridians 6 and 4, then 5 and 7."""
    return Drawing(dome(()), ((0, 1, 2, 3), (6, 4), (7, 5)))


class Finder:
    """Finds those of the dome's cycles that have all their curves, by their names."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(
        self, network: CurveNetwork, added: Sequence[Cycle], banned: Sequence[Cycle]
    ) -> tuple[Sequence[Cycle], Sequence[str]]:
        self.calls += 1
        names = {curve.id for curve in network.curves}
        whole = dome(())
        refused = {cycle.key for cycle in banned}
        found = list(added)
        for cycle in CYCLES:
            around = whole.names(cycle)
            if names.issuperset(around):
                here = named_cycle(network, around)
                if here.key not in refused | {c.key for c in found}:
                    found.append(here)
        return found, ["found by the tests"]


#: From where the tests look.
FROM_ABOVE: dict[str, Any] = {"toward": (0.0, 0.0, 1.0), "up": (0.0, 1.0, 0.0)}


def opened(source: object = None, **options: object) -> SurfacingState:
    """Open a drawing, cut along chords: there is more to try than with the default method."""
    wanted = FROM_ABOVE | {"settings": SurfaceRequest(method="chords")} | options
    state = SurfacingState(dome() if source is None else source, **wanted)  # type: ignore[arg-type]
    compose_surface(state, 1040.0, 860.0)
    state.settle()
    return state


def said(state: SurfacingState) -> list[str]:
    """What the window says beside the picture."""
    sheet = FactSheet()
    describe_surface(sheet, state)
    return [*read_sheet(sheet), state.message]


def keys(state: SurfacingState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW
        state.settle()


def at(state: SurfacingState, *point: float) -> tuple[float, float]:
    """Where a point of space is seen."""
    x, y, _ = state.camera.view.seen(np.array(point))
    return float(x), float(y)


def click(state: SurfacingState, *point: float) -> None:
    x, y = at(state, *point)
    state.move(x, y)
    state.press(x, y)
    state.release(x, y)
    state.settle()


def drag(state: SurfacingState, *places: tuple[float, float]) -> None:
    state.press(*places[0])
    for place in places[1:]:
        state.move(*place)
    state.release(*places[-1])


def pieces(state: SurfacingState) -> int:
    return sum(len(patch.faces) for patch in state.surfaces.patches)


def on_keys(state: SurfacingState) -> set[object]:
    return {state.surfaces.cycle_of(True, i).key for i in range(len(state.surfaces.patches))}
