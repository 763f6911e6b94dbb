"""Simulated events: a mouse and keys over a window, as VTK tells of them; and pictures of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from viewer import DisplayError, opengl
from viewer.panel import PANEL
from viewer.scene import HEIGHT
from viewer.window import Shell

Place = tuple[float, float]


def can_draw() -> bool:
    """Can windows be drawn here, off screen? If not, the error must say what to install."""
    try:
        opengl.prepare_opengl(off_screen=True)
    except DisplayError as error:
        assert "libegl1" in str(error)
        return False
    return True


class Events:
    """Sends events to a window.

    size: pixels of the window. settle: waits for what the window has asked for. Places are points
    from the middle of the view.
    """

    def __init__(
        self, window: Shell, size: tuple[int, int], settle: Callable[[], object] = lambda: None
    ) -> None:
        from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

        self.interactor: Any = vtkGenericRenderWindowInteractor()
        window.listen(self.interactor)
        self.room = HEIGHT * size[0] / size[1] - PANEL
        self._unit = size[1] / HEIGHT
        self._settle = settle

    def send(
        self, event: str, at: Place | None = None, key: str = "", held: tuple[int, int] = (0, 0)
    ) -> None:
        """An event with the pointer at a place, or of a key; held: Control and Shift."""
        if at is not None:
            x, y = (at[0] + self.room / 2.0) * self._unit, (at[1] + HEIGHT / 2.0) * self._unit
            self.interactor.SetEventInformation(round(x), round(y), *held, "\0", 0, "")
        elif key:
            code = key if len(key) == 1 else "\0"
            self.interactor.SetEventInformation(0, 0, 0, 0, code, 0, key)
        self.interactor.InvokeEvent(event)
        self._settle()
        self.interactor.InvokeEvent("TimerEvent")

    def keys(self, *keys: str) -> None:
        """Press keys, by what they write or their X names."""
        for key in keys:
            self.send("KeyPressEvent", key=key)

    def drag(self, *places: Place, button: str = "Left") -> None:
        """Move to the first place, press, move through the others, and let go at the last."""
        self.send("MouseMoveEvent", places[0])
        self.send(f"{button}ButtonPressEvent", places[0])
        for place in places[1:]:
            self.send("MouseMoveEvent", place)
        self.send(f"{button}ButtonReleaseEvent", places[-1])


def read(path: Path) -> np.ndarray:
    """(h, w, 3) the colours of a PNG."""
    from matplotlib.image import imread

    return np.asarray(imread(path))[..., :3]


def alike(one: Path, other: Path) -> bool:
    """Do two pictures show the same? Text and edges may be smoothed differently."""
    a, b = read(one), read(other)
    return a.shape == b.shape and float(np.abs(a - b).mean()) < 0.02


def check_looking(events: Events, seer: Any) -> None:
    """A drag with the right button turns the view, the wheel zooms, the middle one shifts.

    seer: what has the view, a camera or the fill explorer's state.
    """
    axes, scale, focus = seer.view.axes, seer.view.scale, seer.view.focus
    events.drag((0.0, 0.0), (40.0, 30.0), button="Right")
    assert not np.allclose(seer.view.axes, axes)
    events.send("MouseWheelForwardEvent")
    assert seer.view.scale > scale
    events.drag((0.0, 0.0), (20.0, 10.0), button="Middle")
    moved = seer.view.focus - focus
    # The wheel zooms about the pointer, and pixels are whole.
    assert np.linalg.norm(moved) > 0.0
