"""What the viewer of shape models shows and how that changes: no window in here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.shapemodel import ShapeModel
from viewer.camera import Camera
from viewer.framing import framed
from viewer.shapes.layout import Knob, rails
from viewer.shapes.pull import Grab, displaced
from viewer.shapes.sight import Sight
from viewer.shapes.skin import Line
from viewer.shapes.switches import Switches
from viewer.slider import Rail, rail_at
from viewer.view import View

#: A press and a release this near to each other, in points, are a click.
CLICK = 4.0

#: How near to a curve the pointer must be, in points.
REACH = 11.0

#: From where shapes are looked at, and what is upright: at first, along x, y and z. Cars drive
#: towards smaller x; those of the templates are left halves, at smaller y.
VIEWS = (
    ((-0.62, -1.0, 0.42), (0.0, 0.0, 1.0)),
    ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
)


class ShapesState(Switches, Camera):
    """A shape model, the shape that is shown, and how it is looked at.

    The arguments are those of :class:`viewer.shapes.shaping.Shaping`. axis: 0 to 2 where pulls go
    along x, y or z, None where they go in the plane of the screen. bending: is one vertex pulled
    rather than the whole curve?
    """

    def __init__(
        self, shapes: ShapeModel, template: Template, coefficients: ArrayLike | None = None
    ) -> None:
        Switches.__init__(self, shapes, template, coefficients)
        Camera.__init__(self)
        self.axis: int | None = None
        self.bending = False
        self._facing = 0
        self._drag: Grab | Knob | None = None
        self._turning = False
        self._pressed: tuple[float, float] | None = None
        self._sight: Sight | None = None
        self._ghost_sight: Sight | None = None
        self.view = self._framed()

    @property
    def sight(self) -> Sight:
        """The shape as it is seen now."""
        known = self._sight
        if known is None or not known.is_of(self.points, self.view, self.room):
            known = self._sight = Sight(self.skin, self.points, self.view, self.room)
        return known

    @property
    def ghost_sight(self) -> Sight | None:
        """Likewise the ghost, None if none is shown."""
        coefficients = self.ghost_coefficients()
        if coefficients is None:
            return None
        points = self.shapes.shape(coefficients)
        known = self._ghost_sight
        if known is None or not known.is_of(points, self.view, self.room):
            known = self._ghost_sight = Sight(self.skin, points, self.view, self.room)
        return known

    @property
    def rails(self) -> dict[Knob, Rail]:
        """The sliders that are shown, in points from the picture's lower left."""
        return rails(self.shapes.n_modes, self.page, self.room[0])

    @property
    def value(self) -> dict[Knob, float]:
        """What the sliders are at."""
        modes: dict[Knob, float] = dict(enumerate(self.sigmas.tolist()))
        return modes | {"hold": self.choice.hold, "stiffness": self.choice.stiffness}

    @property
    def dragging(self) -> bool:
        """Is a curve or a slider in hand?"""
        return self._drag is not None

    @property
    def grabbed(self) -> int | None:
        """The number of the curve that is being pulled."""
        return self._drag.line if isinstance(self._drag, Grab) and self._pressed is None else None

    def under(self) -> Line | None:
        """The curve in hand, or else the one at the pointer."""
        number = self.line_under()
        return None if number is None else self.skin.lines[number]

    def line_under(self) -> int | None:
        """Its number."""
        if isinstance(self._drag, Grab):
            return self._drag.line
        if not self.curves_shown or self._drag is not None or self._turning:
            return None
        if self.pointer is None or abs(self.pointer[0]) > self.room[0] / 2.0:
            return None
        near = self.sight.nearest(*self.pointer, REACH)
        return None if near is None else near.line

    def knob_under(self) -> Knob | None:
        """The slider in hand, or else the one at the pointer."""
        if isinstance(self._drag, int | str):
            return self._drag
        if self.pointer is None or self._drag is not None or self._turning:
            return None
        return rail_at(self.rails, *self._on_page(*self.pointer))

    # What keys do, see viewer.shapes.keys

    def toggle_bending(self) -> None:
        """Pull one vertex with those around it, or the whole curve."""
        self.bending = not self.bending
        self._again()

    def choose_axis(self, axis: int) -> None:
        """Pull along an axis, or in the plane of the screen if it was that one."""
        self.axis = None if self.axis == axis else axis
        self._again()

    def hold_here(self) -> None:
        """Hold the curve at the pointer, or let it go."""
        line = self.under()
        if line is None:
            self.message = "put the pointer on a curve"
        else:
            self.toggle_held(line.name)

    def look(self, way: int) -> None:
        """The mean shape in the middle: as it was seen at first, or along x, y or z, 1 to 3."""
        self._facing, self._moved = way, False
        self.view = self._framed()

    def leave(self) -> bool:
        """Let go of what is dragged, as if it had not been, or close the help; False if there
        is neither."""
        if self._drag is not None:
            self._drag = self._pressed = None
            self.drop()
            return True
        helping, self.helping = self.helping, False
        return helping

    # The pointer, at places of the picture in points from its middle

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.pointer = (x, y)
        if self._drag is not None or self._turning:
            return False
        if turn:
            self._turning, self._pressed = True, None
            return False
        knob = rail_at(self.rails, *self._on_page(x, y))
        if knob is not None:
            self.begin()
            self._drag = knob
            if isinstance(knob, int):
                self.chosen = knob
            self._slide(x, y)
            return True
        if abs(x) > self.room[0] / 2.0:
            return False
        near = self.sight.nearest(x, y, REACH) if self.curves_shown else None
        self._pressed = (x, y)
        if near is None:
            self._turning = True
            return False
        self.begin()
        self._drag = Grab(near.line, near.place, (x, y))
        return True

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = self.line_under(), self.knob_under()
        last, self.pointer = self.pointer, (x, y)
        if self._pressed is not None:
            if np.hypot(x - self._pressed[0], y - self._pressed[1]) < CLICK:
                return False
            # What began as a click turns or pulls by all that it has moved.
            last, self._pressed = self._pressed, None
        if isinstance(self._drag, Grab):
            self._pull(self._drag)
        elif self._drag is not None:
            self._slide(x, y)
        elif self._turning and last is not None:
            self.aim(self.view.turned(x - last[0], y - last[1]))
        else:
            return before != (self.line_under(), self.knob_under())
        return True

    def release(self, x: float, y: float) -> bool:
        """The button goes up: a drag ends, or it was a click, which holds a curve."""
        self.pointer = (x, y)
        drag, clicked = self._drag, self._pressed is not None
        self._drag = self._pressed = None
        self._turning = False
        if drag is None:
            return False
        self.finish()
        if isinstance(drag, Grab) and clicked:
            self.toggle_held(self.skin.lines[drag.line].name)
        return True

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        # A pull is measured in this view.
        return not isinstance(self._drag, Grab) and Camera.wheel(self, steps)

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        return not isinstance(self._drag, Grab) and Camera.drag_view(self, dx, dy)

    def poll(self) -> bool:
        """Nothing is made in the background: an edit takes a few milliseconds."""
        return False

    # How it is done

    def _slide(self, x: float, y: float) -> None:
        knob = self._drag
        assert isinstance(knob, int | str)
        value = self.rails[knob].value_at(self._on_page(x, y)[0])
        if isinstance(knob, int):
            self.set_mode(knob, value)
        else:
            self.set_number(knob, value)

    def _again(self) -> None:
        """The pull that goes on, after what it depends on has changed."""
        if isinstance(self._drag, Grab) and self._pressed is None:
            self._pull(self._drag)

    def _pull(self, grab: Grab) -> None:
        assert self.pointer is not None
        dx, dy = (self.pointer[i] - grab.pressed[i] for i in (0, 1))
        offset = displaced(self.view, dx, dy, self.axis)
        if offset is None:
            assert self.axis is not None
            self.message = f"{'xyz'[self.axis]} points at you: turn the view to pull along it"
            return
        self.pull(self.skin.lines[grab.line], offset, grab.place if self.bending else None)

    def _on_page(self, x: float, y: float) -> tuple[float, float]:
        """From the middle of the view to the picture's lower left."""
        return x + self.room[0] / 2.0, y + self.room[1] / 2.0

    def _framed(self) -> View:
        first, view = (
            framed(self.shapes.mean, *VIEWS[way], *self.room) for way in (0, self._facing)
        )
        # From the front no larger than at first: it is going to be turned.
        return replace(view, scale=min(view.scale, first.scale))
