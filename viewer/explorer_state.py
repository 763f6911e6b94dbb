"""What the fill explorer shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.strips import trace_strips_at
from query import Boundary, Stroke
from query.engine import PatternSource
from query.placing import Surface
from query.stroke import TOLERANCE
from viewer.background import Placed
from viewer.camera import View, turn_view
from viewer.contour import Contour, PointerMode, PointerStroke
from viewer.finder import LIMIT, FillFinder
from viewer.ground import DrawingGround
from viewer.nearness import SIDE_REACH

#: Radius of the picture's middle that a boundary is fitted into, in points; in a window, as a
#: part of its lesser size.
RADIUS, FITTED = 260.0, 0.38

#: What is upright on a turntable: most meshes stand along y.
UPWARD = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class ExplorerStep:
    """What is asked for: all that undo brings back."""

    contour: Contour | None
    strokes: tuple[Stroke, ...]
    choices: tuple[object, ...]

    def is_like(self, other: ExplorerStep) -> bool:
        """Is the same asked for?"""
        return (
            self.contour is other.contour
            and [id(one) for one in self.strokes] == [id(one) for one in other.strokes]
            and self.choices == other.choices
        )


#: What of a finder a step holds.
CHOICES = ("tolerance", "order", "strict", "folded", "following", "max_irregular", "max_valence")


class ExplorerState:
    """A boundary on a surface, strokes, the fills that stream in, and how they are looked at.

    surface: what is drawn and placed on; None is the plane of the boundary. boundary: its
    vertices placed, or None to have one drawn. strokes: on it. tolerance, limit: as for
    :func:`query.fills`. folded: see :class:`viewer.finder.FillFinder`.
    """

    def __init__(
        self,
        source: PatternSource,
        boundary: Boundary | None = None,
        *,
        surface: Surface | None = None,
        strokes: Sequence[Stroke] = (),
        tolerance: int = TOLERANCE,
        limit: int = LIMIT,
        folded: bool = True,
    ) -> None:
        #: What is asked, and the fills that were found.
        self.finder = FillFinder(source, surface, strokes, tolerance, limit, folded)
        self.hiding = False
        self.strips_shown = True
        self.mode = PointerMode.LOOK
        self.contour: Contour | None = None
        self.ground = DrawingGround(surface)
        self.pointer: tuple[float, float] | None = None
        self._turning = False
        if boundary is not None:
            self.contour = Contour.of(boundary)
            if surface is None:
                self.ground = _plane_of(boundary)
        self.pen = PointerStroke(self.ground)
        self.turntable = False
        self._radius, self._moved = RADIUS, False
        #: The fill that was shown before the boundary was changed, until there is another.
        self.former: Placed | None = None
        #: Was a boundary or a stroke drawn here since a fill was saved?
        self.drawn_here = False
        self._past: list[ExplorerStep] = []
        self._future: list[ExplorerStep] = []
        self.view = self._fitted()
        if self.contour is not None:
            self._change(self.contour)
        self._now = self._step()

    @property
    def surface(self) -> Surface | None:
        return self.ground.surface

    @property
    def message(self) -> str:
        """What went wrong last."""
        return self.finder.message

    @message.setter
    def message(self, text: str) -> None:
        self.finder.message = text

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        return self.finder.poll()

    def settle(self, rank: int | None = None) -> None:
        """Wait for the fill of a rank (from 0; None: for all), look at it, wait for its place.

        Raises NotFoundError if there is no such fill, and what the query or the placing raised.
        """
        self.finder.settle(rank)

    def close(self) -> None:
        """End what is going on, and wait until the source is not in use any more."""
        self.finder.close()

    # Looking

    def fit(self) -> None:
        """The boundary, or the surface, back into the middle."""
        self.view = self._fitted()
        self._moved = False

    def fill_room(self, width: float, height: float) -> None:
        """A window has this size, in points; a view not yet moved is fitted into it."""
        radius = FITTED * min(width, height)
        if radius != self._radius:
            self._radius = radius
            if not self._moved:
                self.view = self._fitted()

    def aim(self, view: View) -> None:
        """Look from somewhere else."""
        self.view, self._moved = view, True

    def roll(self) -> None:
        """A quarter turn about the line of sight."""
        self.aim(self.view.rolled())

    def toggle(self, name: str) -> None:
        """Turn one of the switches hiding (the fill) and strips_shown."""
        setattr(self, name, not getattr(self, name))

    # Steps back and forward

    @property
    def undoable(self) -> int:
        """Steps that can be taken back."""
        return len(self._past)

    @property
    def redoable(self) -> int:
        """Steps that can be done again."""
        return len(self._future)

    def keep_step(self) -> None:
        """Keep what was asked for before, if it has changed; call it after whatever may have."""
        now = self._step()
        if not now.is_like(self._now):
            self._past.append(self._now)
            self._future.clear()
            self._now = now

    def undo(self) -> None:
        """Ask for what was asked before; while corners are clicked, take the last back."""
        if self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.undo_corner()
        else:
            self._turn(self._past, self._future, "there is nothing to take back")

    def redo(self) -> None:
        """Ask again for what was taken back last."""
        self._turn(self._future, self._past, "there is nothing to do again")

    def _turn(self, source: list[ExplorerStep], target: list[ExplorerStep], otherwise: str) -> None:
        if not source:
            self.message = otherwise
            return
        target.append(self._now)
        step = self._now = source.pop()
        self.leave()
        for name, value in zip(CHOICES, step.choices, strict=True):
            setattr(self.finder, name, value)
        self.finder.strokes = list(step.strokes)
        self.contour = step.contour
        self._ask()

    def _step(self) -> ExplorerStep:
        choices = tuple(getattr(self.finder, name) for name in CHOICES)
        return ExplorerStep(self.contour, tuple(self.finder.strokes), choices)

    # The boundary

    def change_length(self, by: int) -> None:
        """One edge more or fewer on the side under the pointer."""
        side = self.side_under()
        if self.contour is None or side is None:
            self.message = "put the pointer on a side of the boundary"
            return
        self._change(self.contour.lengthened(side, by))

    def scale_lengths(self, factor: float) -> None:
        """More or fewer edges on all sides."""
        if self.contour is None:
            return
        try:
            self._change(self.contour.scaled(factor))
        except PatternDBError as error:
            self.message = str(error)

    def list_even_lengths(self) -> list[tuple[int, int]]:
        """List sides and the numbers of edges, one more or fewer, that would make the perimeter
        even; none if it is even."""
        return [] if self.contour is None else self.contour.list_even_lengths()

    def choose_length(self, side: int, length: int) -> None:
        """Give a side another number of edges."""
        if self.contour is not None:
            self._change(self.contour.lengthened(side, length - self.contour.lengths[side]))

    def toggle_corner(self) -> None:
        """Make the corner under the pointer reflex, or convex."""
        corner = self.corner_under()
        if self.contour is None or corner is None:
            self.message = "put the pointer on a corner of the boundary"
            return
        self._change(self.contour.toggled(corner))

    def reverse(self) -> None:
        """Fill what is on the other side of the boundary."""
        if self.contour is not None:
            self._change(self.contour.reversed())

    # Drawing

    def begin(self, mode: PointerMode) -> None:
        """Enter a mode; what was begun in another is forgotten."""
        if mode in (PointerMode.STROKE, PointerMode.LOOP) and self.finder.boundary is None:
            self.message = "there is no boundary yet to draw strokes on"
            return
        self.leave()
        self.mode = mode

    def leave(self) -> None:
        """Back to looking; what was not finished is forgotten."""
        self.mode = PointerMode.LOOK
        self.pen.lift()

    def undo_corner(self) -> None:
        """Take the last clicked corner back."""
        self.pen.undo_corner()

    def close_boundary(self) -> None:
        """Join the last clicked corner to the first, and ask for fills."""
        if self.mode is not PointerMode.CORNERS:
            return
        if len(self.pen.clicked) < 3:
            self.message = "a boundary needs three corners; click them one after another"
            return
        try:
            contour = self.pen.contour()
        except PatternDBError as error:
            self.message = str(error)
            return
        self.leave()
        self.finder.strokes = []
        self.drawn_here = True
        self._change(contour)
        # That of another boundary altogether is of no use.
        self.former = None

    # The pointer, at places of the picture in points from its middle

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = self._things_under()
        last, self.pointer = self.pointer, (x, y)
        if self._turning and last is not None:
            upward = UPWARD if self.turntable else None
            self.aim(turn_view(self.view, x - last[0], y - last[1], upward))
        elif self.pen.line:
            self.pen.extend(self.view, x, y)
        elif self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.look_ahead(self.view, x, y)
        else:
            return before != self._things_under()
        return True

    def _things_under(self) -> tuple[int | None, int | None, int | None]:
        return self.side_under(), self.corner_under(), self.quad_under()

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.pointer = (x, y)
        if turn or self.mode is PointerMode.LOOK:
            self._turning = True
            return False
        self.message = ""
        if self.mode is PointerMode.CORNERS:
            self._click(x, y)
            self.keep_step()
        else:
            self.pen.extend(self.view, x, y)
            if not self.pen.line:
                self.message = "strokes are drawn on the surface"
        return True

    def release(self, x: float, y: float) -> bool:
        """The button goes up."""
        if self._turning:
            self._turning = False
            return False
        if self.pen.line:
            self.pen.extend(self.view, x, y)
            self._end_stroke()
            self.keep_step()
            return True
        return False

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        self.aim(self.view.zoomed(1.15**steps, *(self.pointer or (0.0, 0.0))))
        return True

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        self.aim(self.view.moved(dx, dy))
        return True

    def side_under(self) -> int | None:
        """The side of the boundary that the pointer is nearest to, if it is near."""
        if self.contour is None or self.pointer is None or self.mode is not PointerMode.LOOK:
            return None
        near = [_distance(self.view.seen(side), self.pointer) for side in self.contour.sides]
        best = int(np.argmin(near))
        return best if near[best] < SIDE_REACH else None

    def corner_under(self) -> int | None:
        """Likewise the corner."""
        contour = self.contour
        if contour is None or self.pointer is None or self.mode is not PointerMode.LOOK:
            return None
        if not contour.corners:
            return None
        at = self.view.seen(np.stack([side[0] for side in contour.sides]))[:, :2]
        near = np.linalg.norm(at - self.pointer, axis=1)
        best = int(near.argmin())
        return best if near[best] < SIDE_REACH else None

    def quad_under(self) -> int | None:
        """The quad of the fill that is seen under the pointer, where strands are shown."""
        placed, fill = self.finder.placed, self.finder.fill
        hidden = self.hiding or not self.strips_shown or self._turning
        if hidden or placed is None or fill is None or self.pointer is None:
            return None
        if self.mode is not PointerMode.LOOK:
            return None
        seen = self.view.seen(placed.placement.vertices[fill.quads])
        off = seen[..., :2] - np.array(self.pointer)
        ahead = np.roll(off, -1, axis=1)
        # On the left of all four sides: seen from outside, and under the pointer.
        left = off[..., 0] * ahead[..., 1] - off[..., 1] * ahead[..., 0]
        within = np.flatnonzero((left > 0.0).all(axis=1))
        if not len(within):
            return None
        return int(within[seen[within, :, 2].mean(axis=1).argmax()])

    def strips_under(self) -> list[Points]:
        """The lines (n, 3) along the strands of quads that cross under the pointer."""
        quad, placed, fill = self.quad_under(), self.finder.placed, self.finder.fill
        if quad is None or placed is None or fill is None:
            return []
        return trace_strips_at(placed.placement.vertices, fill.quads, quad)

    # How it is done

    def _click(self, x: float, y: float) -> None:
        if self.pen.closes(self.view, x, y):
            self.close_boundary()
        elif not self.pen.add_corner(self.view, x, y):
            self.message = "corners are put on the surface"

    def _end_stroke(self) -> None:
        if self.finder.boundary is None:
            self.pen.lift()
            return
        try:
            stroke = self.pen.stroke(self.finder.boundary, loop=self.mode is PointerMode.LOOP)
        except PatternDBError as error:
            self.message = str(error)
            self.pen.lift()
            return
        self.leave()
        self.finder.strokes.append(stroke)
        self.drawn_here = True
        self.finder.restart()

    def _change(self, contour: Contour) -> None:
        """Another boundary: strokes are drawn on it anew, and fills are asked for."""
        self.contour = contour
        self._ask(redraw=True)

    def _ask(self, *, redraw: bool = False) -> None:
        """Ask for fills of the boundary as it is now; redraw: strokes were drawn on another."""
        self.former = self.finder.placed or self.former
        self.finder.boundary = None
        if self.contour is not None:
            try:
                self.finder.boundary = self.contour.boundary()
            except PatternDBError as error:
                self.message = str(error)
        if redraw and self.finder.boundary is not None:
            self._redraw_strokes(self.finder.boundary)
        self.finder.restart()

    def _redraw_strokes(self, boundary: Boundary) -> None:
        kept: list[Stroke] = []
        for stroke in self.finder.strokes:
            try:
                if stroke.points is not None and not stroke.is_loop:
                    stroke = Stroke.drawn(boundary, stroke.points)
                stroke.refuse_unless_on(boundary)
            except PatternDBError as error:
                self.message = f"a stroke was dropped: {error}"
            else:
                kept.append(stroke)
        self.finder.strokes = kept

    def _fitted(self) -> View:
        if self.contour is not None:
            points = np.concatenate(self.contour.sides)
            toward = self.ground.on(points)[1].sum(axis=0)
            return View.facing(points, toward, self._radius)
        if self.surface is not None:
            toward = np.array([0.35, 0.25, 1.0])
            return View.facing(self.surface.vertices, toward, 1.25 * self._radius)
        return View.facing(
            np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), np.zeros(3), self._radius
        )


def _plane_of(boundary: Boundary) -> DrawingGround:
    """The plane through a boundary's middle, across its mean normal."""
    assert boundary.points is not None
    middle = boundary.points.mean(axis=0)
    spokes = boundary.points - middle
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    return DrawingGround(None, middle, area / size if size > 0.0 else None)


def _distance(line: Points, pointer: tuple[float, float]) -> float:
    """From a polyline (k, 3) as it is seen to the pointer, in points."""
    a, b = line[:-1, :2], line[1:, :2]
    along = b - a
    square = (along**2).sum(axis=1)
    t = ((pointer - a) * along).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    foot = a + np.clip(t, 0.0, 1.0)[:, None] * along
    return float(np.linalg.norm(foot - pointer, axis=1).min())
