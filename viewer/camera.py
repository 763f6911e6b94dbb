"""From where a viewer's thing is looked at, and how the wheel and keys change that."""

from __future__ import annotations

from abc import ABC, abstractmethod

from viewer.scene import HEIGHT
from viewer.view import View

#: How much larger one step of the wheel makes things.
STEP = 1.15


class Camera(ABC):
    """A view that is fitted to what is seen until the user moves it.

    view: where things are in the picture. room: width and height of the picture without the
    panel, in points. pointer: its place, in points from the middle of the picture.
    """

    view: View

    def __init__(self) -> None:
        self.pointer: tuple[float, float] | None = None
        self.room = (HEIGHT, HEIGHT)
        self._moved = False

    @abstractmethod
    def _framed(self) -> View:
        """The view in which all is seen, as at first."""

    def fill(self, width: float, height: float) -> None:
        """The picture has this size without the panel; a view not yet moved is fitted into it."""
        if self.room != (width, height):
            self.room = (width, height)
            if not self._moved:
                self.view = self._framed()

    def fit(self) -> None:
        """All into the middle, as it was seen at first."""
        self.view = self._framed()
        self._moved = False

    def roll(self) -> None:
        """A quarter turn about the line of sight."""
        self.aim(self.view.rolled())

    def aim(self, view: View) -> None:
        """Look from somewhere else."""
        self.view, self._moved = view, True

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        self.aim(self.view.zoomed(STEP**steps, *(self.pointer or (0.0, 0.0))))
        return True

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        self.aim(self.view.moved(dx, dy))
        return True
