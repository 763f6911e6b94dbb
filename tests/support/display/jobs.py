"""What each of the six windows is for, done by a hand on a real display."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.support.display.hands import Shown


@dataclass(frozen=True, slots=True)
class Job:
    """What a window is for.

    do: does it, with a hand. done: what holds then. undo: how often it is taken back until
    ``done`` does not hold any more; 0 where there is nothing to take back. file: what is saved,
    "" for nothing. asks: does saving ask for a name?
    """

    do: Callable[[Shown], None]
    done: str
    undo: int = 1
    file: str = ""
    asks: bool = False


def page_through(shown: Shown) -> None:
    """Go three patterns on, and widen a polychord."""
    shown.keys("Right", "Right", "Right", "bracketright", "Up")


def draw_boundary(shown: Shown) -> None:
    """Click the corners of a boundary, and take the second of its fills."""
    shown.keys("b")
    for corner in ((-90.0, -80.0), (95.0, -70.0), (80.0, 85.0), (-85.0, 75.0)):
        shown.click(np.array(corner))
    shown.until("len(state.pen.clicked) == 4")
    shown.keys("Return")
    shown.until("window.table.bound['next-fill'].action.isEnabled()")
    shown.keys("Right")


def draw_square(shown: Shown) -> None:
    """Draw four curves, which become a patch of quads."""
    shown.keys("d")
    corners = np.array([(-100.0, -90.0), (100.0, -90.0), (100.0, 90.0), (-100.0, 90.0)])
    for number in range(4):
        line = np.linspace(corners[number - 1], corners[number], 12)
        shown.drag(line)
        shown.until("not state.editing.waiting")


def ink_surface(shown: Shown) -> None:
    """Draw on the surface."""
    shown.keys("d")
    shown.drag(np.array([[-30.0, 30.0], [-50.0, 40.0], [-70.0, 30.0]]))


def follow_ridge(shown: Shown) -> None:
    """Click along the ridge, and finish the curve, which snaps to it."""
    shown.keys("c")
    for number, x in enumerate((-0.7, 0.0, 0.7)):
        place = shown.tell(
            f"state.camera.view.seen(__import__('numpy').array([{x}, 0.02, -0.02]))[:2].tolist()"
        )
        shown.click(np.array(place))
        shown.until(f"len(state.editing.clicks) == {number + 1}")
    shown.keys("Return")


def find_rail(shown: Shown) -> np.ndarray:
    """Find where a curve of the car is seen."""
    return np.array(shown.until(
        "(lambda s: s[len(s) // 2, :2].tolist())(state.sight.lines[[line.name for line in "
        "state.skin.lines].index('roof_rail')])"
    ))  # fmt: skip


def pull_rail(shown: Shown) -> None:
    """Pull a curve of the car upward."""
    shown.drag(find_rail(shown) + np.array([[0.0, 0.0], [2.0, 10.0], [4.0, 30.0]]))


JOBS = {
    "browse": Job(page_through, "state.position == 3 and max(state.widths) == 2", 0),
    "explore": Job(
        draw_boundary,
        "state.finder.rank == 1 and state.finder.placed is not None",
        file="fill.obj",
        asks=True,
    ),
    "retopo": Job(
        draw_square, "len(state.shown.body.mesh.quads) > 3", file="sheet.retopo"
    ),
    "surface": Job(
        ink_surface, "len(state.surfaces.edits.inks) == 1", file="dome.obj", asks=True
    ),
    "features": Job(
        follow_ridge, "len(state.editing.edits.curves) == 1", file="roof.session"
    ),
    "shape-model": Job(
        pull_rail, "bool(state.shaping.choice.coefficients.any())", file="car.obj"
    ),
}  # fmt: skip
