"""A sheet, a tube, and hands that draw on them, for the window of retopology."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Retopology
from query.engine import PatternSource
from tests.support.viewer.sayings import read_sheet
from viewer.facts import FactSheet
from viewer.keymap import Effect
from viewer.retopo import RetopoState
from viewer.retopo.facts import describe_network, tell_hint
from viewer.retopo.keys import KEYS
from viewer.retopo.picture import RetopoPainter

#: A square on the sheet, counter-clockwise.
SQUARE = ((-1.5, -1.5), (1.5, -1.5), (1.5, 1.5), (-1.5, 1.5))


#: Size of the picture.
ROOM = (1040.0, 860.0)


@cache
def sheet() -> Surface:
    """z = 0 from -5 to 5 both ways."""
    n = 60
    x, y = np.meshgrid(np.linspace(-5.0, 5.0, n + 1), np.linspace(-5.0, 5.0, n + 1))
    return Surface.from_arrays(
        np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1), cells(n, n)
    ).orient()


@cache
def tube() -> Surface:
    """x^2 + y^2 = 1, open at z = -3 and z = 3."""
    n, m = 48, 24
    angle = 2.0 * np.pi * np.arange(n) / n
    z = np.linspace(-3.0, 3.0, m + 1)
    points = np.stack(
        [
            np.tile(np.cos(angle), m + 1),
            np.tile(np.sin(angle), m + 1),
            np.repeat(z, n),
        ],
        axis=1,
    )
    a = (np.arange(m)[:, None] * n + np.arange(n)).ravel()
    b = (np.arange(m)[:, None] * n + (np.arange(n) + 1) % n).ravel()
    quads = np.stack([a, b, b + n, a + n], axis=1)
    return Surface.from_arrays(
        points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ).orient()


def cells(n: int, m: int) -> np.ndarray:
    """(2 n m, 3) triangles of a grid of n x m cells."""
    a = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([a, a + 1, a + n + 2, a + n + 1], axis=1)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def opened(source: PatternSource, surface: Surface | None = None) -> RetopoState:
    """A state on the sheet, seen from above, or on another surface."""
    state = RetopoState(Retopology(sheet() if surface is None else surface, source))
    texts(state)
    if surface is None:
        keys(state, "3")
    return state


def texts(state: RetopoState) -> list[str]:
    """The texts of the picture and beside it."""
    sheet = FactSheet()
    describe_network(sheet, state)
    drawn = RetopoPainter().compose(state, *ROOM)
    seen = [text.text for text in drawn.scene.texts]
    return [*seen, *read_sheet(sheet), tell_hint(state), state.message]


def keys(state: RetopoState, text: str) -> None:
    """Press keys, with spaces between, each once all is done."""
    for key in text.split():
        state.settle()
        assert KEYS.press(state, key) is Effect.REDRAW, key
    state.settle()


def at(state: RetopoState, point: Sequence[float]) -> tuple[float, float]:
    """Where a point (2,) of the sheet, or (3,) of space, is seen."""
    x, y, _ = state.camera.view.seen(np.array([*point, 0.0][:3])).tolist()
    return x, y


def hover(state: RetopoState, point: Sequence[float]) -> None:
    """Put the pointer somewhere."""
    state.move(*at(state, point))
    state.settle()


def press(state: RetopoState, *points: Sequence[float], steps: int = 8) -> None:
    """Press the left button and drag it from point to point, without letting go."""
    places = [np.array(at(state, point)) for point in points]
    state.move(*places[0].tolist())
    state.press(*places[0].tolist())
    for a, b in pairwise(places):
        for share in np.linspace(0.0, 1.0, steps + 1)[1:].tolist():
            state.move(*(a + share * (b - a)).tolist())


def drag(state: RetopoState, *points: Sequence[float]) -> None:
    """Draw from point to point."""
    press(state, *points)
    state.release(*at(state, points[-1]))
    state.settle()


def click(state: RetopoState, point: Sequence[float]) -> None:
    """Click on a point."""
    drag(state, point)


def square(state: RetopoState, corners: Sequence[Sequence[float]] = SQUARE) -> None:
    """Draw a loop of as many curves as there are corners."""
    keys(state, "d")
    for k in range(len(corners)):
        drag(state, corners[k - 1], corners[k])


def curves(state: RetopoState) -> list[int]:
    """The chains that were drawn."""
    return [chain.id for chain in state.network.chains.values() if not chain.marked]


def quads_of(state: RetopoState) -> int:
    return len(state.shown.body.mesh.quads)
