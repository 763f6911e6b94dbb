"""How a model is looked at: from where, which way up, and whether it hides what is behind."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from viewer.camera import Camera
from viewer.framing import framed
from viewer.view import View

#: From where a model is looked at: over its left front, if x points to its back and z up.
TOWARD = (-0.72, -1.0, 0.52)

#: What is upright, in the order of the key.
UPRIGHT = ("z", "y", "x")

#: How the model is shown, in the order of the key.
ModelLook = Literal["solid", "through", "hidden"]
MODEL_LOOKS: tuple[ModelLook, ...] = ("solid", "through", "hidden")


class Looking(Camera):
    """The view of a model.

    upright: the axis that is. model_look: how the model is shown.
    """

    def __init__(self, points: Points) -> None:
        Camera.__init__(self)
        self.model_look: ModelLook = "solid"
        self.upright = UPRIGHT[0]
        self._points = points
        self._toward = np.array(TOWARD)
        self.view = self._framed()

    def next_model_look(self) -> None:
        """The model solid, transparent or hidden."""
        at = MODEL_LOOKS.index(self.model_look)
        self.model_look = MODEL_LOOKS[(at + 1) % len(MODEL_LOOKS)]

    def next_upright(self) -> None:
        """Another axis of the model is upright."""
        self.upright = UPRIGHT[(UPRIGHT.index(self.upright) + 1) % len(UPRIGHT)]
        self._toward = self._turned(TOWARD)
        self.fit()

    def look_along(self, direction: ArrayLike) -> None:
        """Look against a direction (3,) of an upright model; the other way round if it is looked
        at from there already."""
        toward = self._turned(direction)
        if np.allclose(self.view.axes[2], toward):
            toward = -toward
        self._toward = toward
        self.fit()
        self._toward = self._turned(TOWARD)
        self._moved = True

    def _turned(self, direction: ArrayLike) -> Points:
        """A direction (3,) of a model that stands along z, for this one."""
        return np.roll(np.array(direction, np.float64), "zxy".index(self.upright))

    def _framed(self) -> View:
        up = self._turned((0.0, 0.0, 1.0))
        if abs(up @ self._toward) > 0.999 * np.linalg.norm(self._toward):
            up = self._turned((0.0, 1.0, 0.0))
        return framed(self._points, self._toward, up, *self.room)
