"""The frame of a picture: how large it is, where the view is in it, and what it is put into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewer import style
from viewer.camera import Camera
from viewer.drawn import Drawn
from viewer.panel import PANEL
from viewer.ribbons import NOTHING, Triangles
from viewer.scene import HEIGHT, Scene
from viewer.solid import Solid


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """scene: what is flat. room: width of the picture without the panel. middle: of the view."""

    scene: Scene
    room: float
    middle: tuple[float, float]

    @classmethod
    def of(
        cls,
        camera: Camera,
        aspect: float,
        *,
        bare: bool,
        height: float = HEIGHT,
        below: float = 0.0,
    ) -> Frame:
        """For a window of this width to height, into which the camera's view is fitted.

        bare: without the panel. height: of a bare picture, in points; one with the panel has
        always the same. below: points that the view leaves free at the bottom.
        """
        height = height if bare else HEIGHT
        scene = Scene(height * aspect, height)
        room = scene.width if bare else max(scene.width - PANEL, 1.0)
        camera.fill(room, height - below)
        return cls(scene, room, (room / 2.0, (height + below) / 2.0))

    def solid(self, parts: Sequence[Triangles], placed: Triangles = NOTHING) -> Solid:
        """Triangles as seen from the middle of the view; placed: those in the picture already."""
        corners = np.concatenate([NOTHING[0], *(part[0] for part in parts)])
        corners = np.concatenate([placed[0], corners + np.array([*self.middle, 0.0])])
        return Solid(corners, np.concatenate([placed[1], *(part[1] for part in parts)]), 0.0)

    def drawn(self, solid: Solid) -> Drawn:
        """The picture, all put into its scene."""
        if not self.scene.patches:
            # A page always has something to lay text and triangles on.
            self.scene.box(0.0, 0.0, 0.0, 0.0, style.PAPER, style.PAPER)
        return Drawn(self.scene, solid, self.middle)
