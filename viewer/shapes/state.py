"""What the viewer of shape models shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.shapemodel.shaping import ShapeChoice, ShapeLine, Shaping
from viewer.camera import Camera, View, ViewerState, fit_view
from viewer.pointer import SHAPE_CURVE_REACH, ButtonPress
from viewer.shapes.sight import Grab, ShapeInView, find_displacement
from viewer.shapes.skin import ShapeSkin

#: From where shapes are looked at, and what is upright: at first, along x, y and z. Cars drive
#: towards smaller x; those of the templates are left halves, at smaller y.
VIEWS = (
    ((-0.62, -1.0, 0.42), (0.0, 0.0, 1.0)),
    ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
)


class ShapesCamera(Camera):
    """A camera around a model's mean shape, at first or along an axis.

    points: (n, 3) of the mean shape.
    """

    def __init__(self, points: Points) -> None:
        self._way = 0
        super().__init__(points, *VIEWS[0])

    def look(self, way: int) -> None:
        """The mean shape in the middle: as it was seen at first, or along x, y or z, 1 to 3."""
        self._way = way
        self.fit()

    def fit_all(self) -> View:
        first, view = (fit_view(self._points, *VIEWS[way], *self.room) for way in (0, self._way))
        # From the front no larger than at first: it is going to be turned.
        return replace(view, scale=min(view.scale, first.scale))


class ShapesState(ViewerState[ShapesCamera]):
    """A shape model, the shape that is shown, and how it is looked at.

    The arguments are those of :class:`patterndb_sketch.features.shapemodel.shaping.Shaping`. axis:
    0 to 2 where pulls go along x, y or z, None where they go in the plane of the screen. bending:
    is one vertex pulled rather than the whole curve? curves_shown, edges_shown: are the curves, the
    edges of faces shown? chosen: the mode that arrow keys change.
    """

    def __init__(
        self,
        shapes: ShapeModel,
        template: Template,
        coefficients: ArrayLike | None = None,
        held: Collection[str] = (),
    ) -> None:
        #: The shape that is being made.
        self.shaping = Shaping(shapes, template, coefficients, held)
        self.skin = ShapeSkin.of(shapes, template)
        super().__init__(ShapesCamera(shapes.mean), self.shaping)
        self.curves_shown = True
        self.edges_shown = False
        self.chosen = 0
        self.axis: int | None = None
        self.bending = False
        self._drag: Grab | None = None
        self._turning = False
        self._press = ButtonPress()
        self._sight: ShapeInView | None = None
        self._ghost_sight: ShapeInView | None = None

    @property
    def sight(self) -> ShapeInView:
        """The shape as it is seen now."""
        known = self._sight
        if known is None or not known.is_of(
            self.shaping.points, self.camera.view, self.camera.room
        ):
            known = self._sight = ShapeInView(
                self.skin, self.shaping.points, self.camera.view, self.camera.room
            )
        return known

    @property
    def ghost_sight(self) -> ShapeInView | None:
        """Likewise the ghost, None if none is shown."""
        coefficients = self.shaping.ghost_coefficients()
        if coefficients is None:
            return None
        points = self.shaping.shapes.shape(coefficients)
        known = self._ghost_sight
        if known is None or not known.is_of(points, self.camera.view, self.camera.room):
            known = self._ghost_sight = ShapeInView(
                self.skin, points, self.camera.view, self.camera.room
            )
        return known

    @property
    def dragging(self) -> bool:
        """Is a curve in hand?"""
        return self._drag is not None

    @property
    def grabbed(self) -> int | None:
        """The number of the curve that is being pulled."""
        pulled = self._drag is not None and not self._press.may_be_click
        return self._drag.line if self._drag is not None and pulled else None

    def under(self) -> ShapeLine | None:
        """The curve in hand, or else the one at the pointer."""
        number = self.line_under()
        return None if number is None else self.skin.lines[number]

    def line_under(self) -> int | None:
        """Its number."""
        if self._drag is not None:
            return self._drag.line
        if not self.curves_shown or self._turning or self.camera.pointer is None:
            return None
        near = self.sight.nearest(*self.camera.pointer, SHAPE_CURVE_REACH)
        return None if near is None else near.line

    def take_work(self, work: ShapeChoice) -> None:
        self.leave()
        self.shaping.take(work)

    # What keys do, see viewer.shapes.commands

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
            self.shaping.toggle_held(line.name)

    def leave(self) -> bool:
        """Let go of what is dragged, as if it had not been; False if there is nothing."""
        if self._drag is None:
            return False
        self._drag = None
        self._press.end()
        self.shaping.drop()
        return True

    # The pointer, at places of the picture in points from its middle

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.camera.pointer = (x, y)
        if self._drag is not None or self._turning:
            return False
        self._press.begin((x, y), drags=turn)
        near = None
        if self.curves_shown and not turn:
            near = self.sight.nearest(x, y, SHAPE_CURVE_REACH)
        if near is None:
            self._turning = True
            return False
        self.shaping.begin()
        self._drag = Grab(near.line, near.place, (x, y))
        return True

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = self.line_under()
        last, self.camera.pointer = self.camera.pointer, (x, y)
        if last is None or not (self.dragging or self._turning):
            return before != self.line_under()
        begun = self._press.find_drag(last, (x, y))
        if begun is None:
            return False
        if self._drag is not None:
            self._pull(self._drag)
        else:
            self.camera.turn(x - begun[0], y - begun[1])
        return True

    def release(self, x: float, y: float) -> bool:
        """The button goes up: a drag ends, or it was a click, which holds a curve."""
        self.camera.pointer = (x, y)
        drag, clicked = self._drag, self._press.end()
        self._drag, self._turning = None, False
        if drag is None:
            return False
        self.shaping.finish()
        if clicked:
            self.shaping.toggle_held(self.skin.lines[drag.line].name)
        return True

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        # A pull is measured in this view.
        return self._drag is None and super().wheel(steps)

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        return self._drag is None and super().drag_view(dx, dy)

    def poll(self) -> bool:
        """Nothing is made in the background: an edit takes a few milliseconds."""
        return False

    # How it is done

    def _again(self) -> None:
        """The pull that goes on, after what it depends on has changed."""
        if self._drag is not None and not self._press.may_be_click:
            self._pull(self._drag)

    def _pull(self, grab: Grab) -> None:
        assert self.camera.pointer is not None
        dx, dy = (self.camera.pointer[i] - grab.pressed[i] for i in (0, 1))
        offset = find_displacement(self.camera.view, dx, dy, self.axis)
        if offset is None:
            assert self.axis is not None
            self.message = f"{'xyz'[self.axis]} points at you: turn the view to pull along it"
            return
        self.shaping.pull(self.skin.lines[grab.line], offset, grab.place if self.bending else None)

    def choose_mode(self, by: int) -> None:
        """The next mode, or the one before, for the arrow keys."""
        self.chosen = (self.chosen + by) % self.shaping.shapes.n_modes
