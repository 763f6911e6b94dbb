"""What the fill explorer shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import find_nearest_on
from patterndb.geometry.strips import trace_strips_at
from patterndb.system.documents import JsonValue
from patterndb.system.numbers import TOLERANCE
from patterndb_sketch.history import History
from patterndb_sketch.sessions import SessionFormat
from query import Boundary, Stroke
from query.contour import Contour
from query.drawingbase import DrawingBase
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.placing import Surface
from viewer.background import Placed
from viewer.camera import FILLED, Camera, View, ViewerState, fit_view
from viewer.finder import LIMIT, FillFinder
from viewer.nearness import SIDE_REACH
from viewer.pointerstroke import PointerMode, PointerStroke

#: Part of the picture's lesser size that a boundary is fitted into: its numbers need room.
FITTED = 0.76

#: What is upright on a turntable: most meshes stand along y.
UPWARD = (0.0, 1.0, 0.0)


@dataclass(frozen=True, slots=True)
class FinderChoices:
    """What of a finder undo brings back; fields as of :class:`viewer.finder.FillFinder`."""

    tolerance: int
    order: str | None
    strict: bool
    folded: bool
    following: bool
    max_irregular: int | None
    max_valence: int | None


@dataclass(frozen=True, slots=True, eq=False)
class ExplorerStep:
    """What is asked for: all that undo brings back, and that is kept in case of a crash."""

    contour: Contour | None
    strokes: tuple[Stroke, ...]
    choices: FinderChoices

    def is_like(self, other: ExplorerStep) -> bool:
        """Is the same asked for?"""
        return (
            self.contour is other.contour
            and [id(one) for one in self.strokes] == [id(one) for one in other.strokes]
            and self.choices == other.choices
        )


def _open_step(step: ExplorerStep, place: JsonValue) -> ExplorerStep:
    """Return a step that was read; raises InvalidQueryError for sides that are not polylines."""
    for i, side in enumerate(() if step.contour is None else step.contour.sides):
        if side.shape != (len(side), 3) or len(side) < 2:
            place.at("contour", "sides", i).fail("a side needs two points [x, y, z] or more")
    return step


EXPLORER_SESSION: SessionFormat[ExplorerStep, ExplorerStep] = SessionFormat(
    "explore", InvalidQueryError, ExplorerStep, lambda step: step, _open_step
)


class ExplorerCamera(Camera):
    """A camera around what an explorer looks at, which changes, from where that faces."""

    def __init__(self, state: ExplorerState) -> None:
        self._state = state
        super().__init__(np.zeros((0, 3)), (0.0, 0.0, 1.0), UPWARD)

    def fit_all(self) -> View:
        points, toward, share = self._state.list_looked_at()
        size = float(np.linalg.norm(toward))
        toward = toward / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        # Most meshes stand along y; looked at from above, their back is up.
        up = UPWARD if abs(toward[1]) < 0.9 else (0.0, 0.0, -toward[1])
        room = share * FITTED * min(self.room) / FILLED
        return fit_view(points, toward, up, room, room)


class ExplorerState(ViewerState[ExplorerCamera]):
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
        #: The side that is shown as chosen, whatever the pointer is on.
        self.meant_side: int | None = None
        self.strips_shown = True
        self.mode = PointerMode.LOOK
        self.contour: Contour | None = None
        self.base = DrawingBase(surface)
        self._turning = False
        if boundary is not None:
            self.contour = Contour.of(boundary)
            if surface is None:
                self.base = DrawingBase.of_boundary(boundary)
        self.pen = PointerStroke(self.base)
        #: The fill that was shown before the boundary was changed, until there is another.
        self.former: Placed | None = None
        #: Was a boundary or a stroke drawn here since a fill was saved?
        self.drawn_here = False
        super().__init__(ExplorerCamera(self), self.finder)
        if self.contour is not None:
            self._change(self.contour)
        #: What was asked for, step by step.
        self.steps = History(self._step())

    @property
    def surface(self) -> Surface | None:
        return self.base.surface

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

    # Steps back and forward

    def keep_step(self) -> None:
        """Keep what was asked for before, if it has changed; call it after whatever may have."""
        now = self._step()
        if not now.is_like(self.steps.now):
            self.steps.step(now)

    def undo(self) -> None:
        """Ask for what was asked before; while corners are clicked, take the last back."""
        if self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.undo_corner()
        else:
            self._turn(self.steps.undo(), "there is nothing to take back")

    def redo(self) -> None:
        """Ask again for what was taken back last."""
        self._turn(self.steps.redo(), "there is nothing to do again")

    def _turn(self, turned: bool, otherwise: str) -> None:
        if not turned:
            self.message = otherwise
            return
        self._show_step(self.steps.now)

    def _show_step(self, step: ExplorerStep) -> None:
        self.leave()
        for one in fields(step.choices):
            setattr(self.finder, one.name, getattr(step.choices, one.name))
        self.finder.strokes = list(step.strokes)
        self.contour = step.contour
        self._ask()

    def take_work(self, work: ExplorerStep) -> None:
        self._show_step(work)
        self.keep_step()
        self.drawn_here = True

    def _step(self) -> ExplorerStep:
        names = [one.name for one in fields(FinderChoices)]
        choices = FinderChoices(*(getattr(self.finder, name) for name in names))
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
        last, self.camera.pointer = self.camera.pointer, (x, y)
        if self._turning and last is not None:
            self.camera.turn(x - last[0], y - last[1])
        elif self.pen.line:
            self.pen.extend(self.camera.view, x, y)
        elif self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.look_ahead(self.camera.view, x, y)
        else:
            return before != self._things_under()
        return True

    def _things_under(self) -> tuple[int | None, int | None, int | None]:
        return self.side_under(), self.corner_under(), self.quad_under()

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.camera.pointer = (x, y)
        if turn or self.mode is PointerMode.LOOK:
            self._turning = True
            return False
        self.message = ""
        if self.mode is PointerMode.CORNERS:
            self._click(x, y)
            self.keep_step()
        else:
            self.pen.extend(self.camera.view, x, y)
            if not self.pen.line:
                self.message = "strokes are drawn on the surface"
        return True

    def release(self, x: float, y: float) -> bool:
        """The button goes up."""
        if self._turning:
            self._turning = False
            return False
        if self.pen.line:
            self.pen.extend(self.camera.view, x, y)
            self._end_stroke()
            self.keep_step()
            return True
        return False

    def side_under(self) -> int | None:
        """The side of the boundary that the pointer is nearest to, if it is near."""
        view, pointer = self.camera.view, self.camera.pointer
        if self.contour is None or pointer is None or self.mode is not PointerMode.LOOK:
            return None
        near = [find_nearest_on(view.seen(side)[:, :2], pointer)[0] for side in self.contour.sides]
        best = int(np.argmin(near))
        return best if near[best] < SIDE_REACH else None

    def corner_under(self) -> int | None:
        """Likewise the corner."""
        contour = self.contour
        if contour is None or self.camera.pointer is None or self.mode is not PointerMode.LOOK:
            return None
        if not contour.corners:
            return None
        at = self.camera.view.seen(np.stack([side[0] for side in contour.sides]))[:, :2]
        near = np.linalg.norm(at - self.camera.pointer, axis=1)
        best = int(near.argmin())
        return best if near[best] < SIDE_REACH else None

    def quad_under(self) -> int | None:
        """The quad of the fill that is seen under the pointer, where strands are shown."""
        placed, fill = self.finder.placed, self.finder.fill
        hidden = self.hiding or not self.strips_shown or self._turning
        if hidden or placed is None or fill is None or self.camera.pointer is None:
            return None
        if self.mode is not PointerMode.LOOK:
            return None
        seen = self.camera.view.seen(placed.placement.vertices[fill.quads])
        off = seen[..., :2] - np.array(self.camera.pointer)
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
        if self.pen.closes(self.camera.view, x, y):
            self.close_boundary()
        elif not self.pen.add_corner(self.camera.view, x, y):
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

    def list_looked_at(self) -> tuple[Points, Points, float]:
        """The points (n, 3) that the view is fitted to, the direction (3,) that they face, and
        how large they are seen, the boundary being 1."""
        if self.contour is not None:
            points = np.concatenate(self.contour.sides)
            return points, self.base.on(points)[1].sum(axis=0), 1.0
        if self.surface is not None:
            return self.surface.vertices, np.array([0.35, 0.25, 1.0]), 1.25
        return np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), np.array([0.0, 0.0, 1.0]), 1.0
