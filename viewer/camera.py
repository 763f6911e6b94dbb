"""From where a viewer's thing is looked at, and how the wheel and keys change that."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb_sketch.recovery import WorkKeeper
from viewer.keymap import Spoken
from viewer.scene import HEIGHT

# From where a fill is looked at: a camera without perspective.

#: Radians that a drag of one point turns the view.
TURN = 0.008


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What lies where in the picture.

    axes:  (3, 3) float64, orthonormal rows: to the right, up, and towards the viewer.
    focus: (3,) float64, what is seen in the middle.
    scale: points of the picture to a unit of space.

    Places in the picture are in points from its middle, x to the right and y up.
    """

    axes: Points
    focus: Points
    scale: float

    def seen(self, points: Points) -> Points:
        """(..., 3) x, y and nearness to the viewer, in points of the picture."""
        return (points - self.focus) @ (self.axes.T * self.scale)

    def unseen(self, seen: Points) -> Points:
        """(..., 3) the points of space that :meth:`seen` takes to these."""
        return self.focus + seen @ self.axes / self.scale

    def under(self, x: float, y: float) -> Points:
        """(3,) a point of space that is seen at (x, y), as near as the focus."""
        return self.focus + (x * self.axes[0] + y * self.axes[1]) / self.scale

    def turned(self, dx: float, dy: float) -> View:
        """After a drag: the thing turns the way the pointer goes."""
        return replace(self, axes=_about(1, -dx * TURN) @ (_about(0, dy * TURN) @ self.axes))

    def orbited(self, dx: float, dy: float, up: Points) -> View:
        """After a drag on a turntable: about ``up`` (3,), which stays upright, and about the
        view's own horizontal."""
        # Upside down the near side still follows the pointer.
        angle = math.copysign(dx * TURN, float(self.axes[1] @ up))
        x, y, z = up / np.linalg.norm(up)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        about = np.eye(3) + math.sin(angle) * across + (1.0 - math.cos(angle)) * across @ across
        return replace(self, axes=_about(0, dy * TURN) @ (self.axes @ about))

    def rolled(self) -> View:
        """A quarter turn about the line of sight."""
        return replace(self, axes=_about(2, math.pi / 2.0) @ self.axes)

    def moved(self, dx: float, dy: float) -> View:
        """What was in the middle goes to (dx, dy)."""
        return replace(self, focus=self.under(-dx, -dy))

    def zoomed(self, factor: float, x: float = 0.0, y: float = 0.0) -> View:
        """Larger by a factor, what is at (x, y) staying there."""
        at = self.under(x, y)
        return replace(self, focus=at + (self.focus - at) / factor, scale=self.scale * factor)


def _about(axis: int, angle: float) -> Points:
    """The rotation of space about one of the view's own axes."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, s, -s, c
    return turn


def turn_view(view: View, dx: float, dy: float, up: Points | None) -> View:
    """Turn a view by a drag: about ``up`` (3,) as on a turntable, or any way without."""
    return view.turned(dx, dy) if up is None else view.orbited(dx, dy, up)


#: How faces may be shaded: by lights from both sides, as clay, or each by itself.
SHADINGS = ("studio", "matcap", "flat")


@dataclass(frozen=True, slots=True)
class StageLook:
    """How faces are shown, and through what camera.

    shading: one of SHADINGS. wire: only the edges of triangles. x_ray: can faces be seen through?
    perspective: else far things are as large as near ones. clip: a point (3,) and a direction (3,);
    what lies beyond the point in that direction is cut away.
    """

    shading: str = "studio"
    wire: bool = False
    x_ray: bool = False
    perspective: bool = False
    clip: tuple[Points, Points] | None = None

    def __post_init__(self) -> None:
        if self.shading not in SHADINGS:
            raise ValueError(f"no shading {self.shading!r}; there are {', '.join(SHADINGS)}")


#: The way that they are shown at first.
PLAIN = StageLook()

#: How much larger one step of the wheel makes things.
STEP = 1.15


class Camera:
    """A view that is fitted to what is seen until the user moves it.

    points: (n, 3) of what is seen. toward: (3,) from where, up: (3,) what is upright, at first.
    view: where things are in the picture. room: width and height of the picture without the
    panel, in points. pointer: its place, in points from the middle of the picture. turntable: does
    a drag turn about what is upright, rather than any way? face_look: how faces are shown.
    """

    def __init__(self, points: Points, toward: ArrayLike, up: ArrayLike) -> None:
        self.pointer: tuple[float, float] | None = None
        self.turntable = False
        self.face_look = PLAIN
        self.room = (HEIGHT, HEIGHT)
        self._points = points
        self._toward = np.array(toward, np.float64)
        self._up = np.array(up, np.float64)
        self._moved = False
        self._fitted: tuple[tuple[float, ...], View] | None = None
        self.view = self.fit_all()

    def fit_all(self) -> View:
        """The view in which all is seen, as at first."""
        return self._fit(self._up)

    def _fit(self, up: Points) -> View:
        # Asked for with every picture, of points that do not change.
        key = (*self.room, *self._toward.tolist(), *up.tolist())
        if self._fitted is None or self._fitted[0] != key:
            self._fitted = key, fit_view(self._points, self._toward, up, *self.room)
        return self._fitted[1]

    def fill(self, width: float, height: float) -> None:
        """The picture has this size without the panel; a view not yet moved is fitted into it."""
        if self.room != (width, height):
            self.room = (width, height)
            if not self._moved:
                self.view = self.fit_all()

    def fit(self) -> None:
        """All into the middle, as it was seen at first."""
        self.view = self.fit_all()
        self._moved = False

    def roll(self) -> None:
        """A quarter turn about the line of sight."""
        self.aim(self.view.rolled())

    def turn(self, dx: float, dy: float) -> None:
        """A drag: the thing turns the way the pointer goes."""
        self.aim(turn_view(self.view, dx, dy, self.upward if self.turntable else None))

    @property
    def upward(self) -> Points:
        """(3,) what is upright."""
        return self._up

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


# How a model is looked at: from where, which way up, and whether it hides what is behind.

#: From where a model is looked at: over its left front, if x points to its back and z up.
TOWARD = (-0.72, -1.0, 0.52)

#: What is upright, in the order of the key.
UPRIGHT = ("z", "y", "x")

#: How the model is shown, in the order of the key.
ModelLook = Literal["solid", "through", "hidden"]
MODEL_LOOKS: tuple[ModelLook, ...] = ("solid", "through", "hidden")


class ModelCamera(Camera):
    """A camera around a model, from over its left front.

    upright: the axis that is. model_look: how the model is shown.
    """

    def __init__(self, points: Points, toward: ArrayLike = TOWARD, upright: str = "z") -> None:
        self.model_look: ModelLook = "solid"
        self.upright = upright
        super().__init__(points, toward, (0.0, 0.0, 1.0))

    def next_model_look(self, *, may_hide: bool = True) -> str:
        """The model solid, transparent or hidden; says which it is now.

        may_hide: is there anything else to see?
        """
        looks = MODEL_LOOKS if may_hide else MODEL_LOOKS[:-1]
        at = looks.index(self.model_look) if self.model_look in looks else -1
        self.model_look = looks[(at + 1) % len(looks)]
        said = {"solid": "solid", "through": "see-through", "hidden": "hidden"}
        return f"the model is {said[self.model_look]}"

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

    @property
    def upward(self) -> Points:
        return self._turned((0.0, 0.0, 1.0))

    def fit_all(self) -> View:
        up = self.upward
        if abs(up @ self._toward) > 0.999 * np.linalg.norm(self._toward):
            up = self._turned((0.0, 1.0, 0.0))
        return self._fit(up)


# Where a thing is looked at from at first.

#: Part of the picture's width and height that a thing is fitted into.
FILLED = 0.86


def fit_view(points: Points, toward: ArrayLike, up: ArrayLike, width: float, height: float) -> View:
    """Look against ``toward`` (3,), ``up`` (3,) upright, with points (n, 3) in the middle of
    a picture of this size, in points."""
    z = np.asarray(toward, np.float64)
    z = z / np.linalg.norm(z)
    x = np.cross(np.asarray(up, np.float64), z)
    size = float(np.linalg.norm(x))
    # Looking along the upright direction, any other will do.
    x = x / size if size > 1e-9 else np.linalg.svd(z[None])[2][1]
    axes = np.stack([x, np.cross(z, x), z])
    if not len(points):
        return View(axes, np.zeros(3), 100.0)
    flat = points @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    across = np.maximum(high - low, 1e-300)
    scale = FILLED * min(width / across[0], height / across[1])
    if scale > 1e200:
        scale = 1.0
    return View(axes, axes.T @ ((low + high) / 2.0), float(scale))


Kind = TypeVar("Kind", bound=Camera)


class ViewerState(Generic[Kind]):
    """What the states of all viewers have whose things are looked at with a camera.

    speaker: keeps what there is to say of the last thing done. files: what the work is kept in in
    case of a crash, where it has no sessions.
    """

    def __init__(self, camera: Kind, speaker: Spoken) -> None:
        self.camera = camera
        self._speaker = speaker
        self.files: WorkKeeper[Any] | None = None

    @property
    def message(self) -> str:
        """What went wrong last, or should be known."""
        return self._speaker.message

    @message.setter
    def message(self, text: str) -> None:
        self._speaker.message = text

    def recover(self) -> None:
        """Take what a crash left in place of what is here, as one step."""
        lost = None if self.files is None else self.files.lost
        if self.files is None or lost is None:
            self.message = "there is nothing that a crash left"
        else:
            self.take_work(lost)
            self.files.lost = None
            self.message = "this is what the crash left; its file goes once it is saved"

    def take_work(self, work: Any) -> None:
        """Take work that was kept, as one step; for states with ``files``."""
        raise NotImplementedError

    def next_shading(self) -> None:
        """Shade faces in the next way."""
        look = self.camera.face_look
        shading = SHADINGS[(SHADINGS.index(look.shading) + 1) % len(SHADINGS)]
        self.camera.face_look = replace(look, shading=shading)
        self.message = f"shading: {shading}"

    def toggle_look(self, name: str) -> None:
        """Turn one of the switches of how faces are shown, by its name."""
        look = self.camera.face_look
        self.camera.face_look = replace(look, **{name: not getattr(look, name)})

    def toggle(self, name: str) -> None:
        """Turn one of the switches, by its name."""
        setattr(self, name, not getattr(self, name))

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        return self.camera.wheel(steps)

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        return self.camera.drag_view(dx, dy)
