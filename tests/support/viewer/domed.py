from pathlib import Path

import numpy as np

from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from query.placing import Surface
from tests.support.viewer.disks import ALL, pattern
from tests.support.viewer.sayings import read_sheet
from viewer.explore import ExplorerSaver
from viewer.explorer_commands import KEYS
from viewer.explorer_state import ExplorerState
from viewer.facts import FactSheet
from viewer.keymap import Effect


class Source:
    """A few patterns in memory."""

    def __init__(self) -> None:
        self.classes: dict[int, list[Pattern]] = {}
        for i, quads in enumerate(q for name, q in ALL.items() if name != "ring"):
            p = pattern(quads, frequency=200 - i)
            self.classes.setdefault(p.n_sides, []).append(p)

    def pattern_class(self, n_sides: int) -> PatternClass:
        return PatternClass.from_patterns(n_sides, self.classes.get(n_sides, []))


SOURCE = Source()


def dome(n: int = 24, bulge: float = 0.8) -> Surface:
    """A shallow dome over the square from -2 to 2, seen from above counter-clockwise."""
    line = np.linspace(-2.0, 2.0, n + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x, y, bulge - 0.25 * bulge * (x**2 + y**2)], axis=2).reshape(-1, 3)
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return Surface.from_arrays(points, triangles.reshape(-1, 3))


DOME = dome()


def opened(*arguments: object, **options: object) -> ExplorerState:
    return ExplorerState(SOURCE, *arguments, **options)  # type: ignore[arg-type]


def keys(state: ExplorerState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW


def click(state: ExplorerState, *places: tuple[float, float]) -> None:
    for x, y in places:
        state.move(x, y)
        state.press(x, y)
        state.release(x, y)


def drag(state: ExplorerState, *places: tuple[float, float]) -> None:
    state.press(*places[0])
    for place in places[1:]:
        state.move(*place)
    state.release(*places[-1])


def said(state: ExplorerState) -> list[str]:
    """What the window says beside the picture."""
    sheet = FactSheet()
    ExplorerSaver(state, Path(), None, (480, 300)).describe(sheet)
    return [*read_sheet(sheet), state.message]
