"""What the fill explorer shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from query import Boundary, Stroke
from query.engine import PatternSource
from query.placing import Surface
from query.stroke import TOLERANCE
from viewer.camera import View
from viewer.contour import Contour, PointerMode, PointerStroke
from viewer.finder import LIMIT, FillFinder
from viewer.ground import DrawingGround
from viewer.keymap import ALIASES, Effect, KeyMap
from viewer.nearness import SIDE_REACH

#: Radius of the picture's middle that a boundary is fitted into, in points.
RADIUS = 260.0


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
        self.helping = False
        self.hiding = False
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
        self.view = self._fitted()
        if self.contour is not None:
            self._change(self.contour)

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

    def roll(self) -> None:
        """A quarter turn about the line of sight."""
        self.view = self.view.rolled()

    def toggle(self, name: str) -> None:
        """Turn one of the switches helping and hiding (the fill)."""
        setattr(self, name, not getattr(self, name))

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
        self._change(contour)

    # The pointer, at places of the picture in points from its middle

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = (self.side_under(), self.corner_under())
        last, self.pointer = self.pointer, (x, y)
        if self._turning and last is not None:
            self.view = self.view.turned(x - last[0], y - last[1])
        elif self.pen.line:
            self.pen.extend(self.view, x, y)
        elif self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.look_ahead(self.view, x, y)
        else:
            return before != (self.side_under(), self.corner_under())
        return True

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.pointer = (x, y)
        if turn or self.mode is PointerMode.LOOK:
            self._turning = True
            return False
        self.message = ""
        if self.mode is PointerMode.CORNERS:
            self._click(x, y)
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
            return True
        return False

    def wheel(self, steps: float) -> bool:
        """The wheel turns: nearer, or farther off, about the pointer."""
        self.view = self.view.zoomed(1.15**steps, *(self.pointer or (0.0, 0.0)))
        return True

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        self.view = self.view.moved(dx, dy)
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
        self.finder.restart()

    def _change(self, contour: Contour) -> None:
        """Another boundary: strokes are drawn on it anew, and fills are asked for."""
        self.contour = contour
        self.finder.boundary = None
        try:
            self.finder.boundary = contour.boundary()
        except PatternDBError as error:
            self.message = str(error)
        else:
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
            return View.facing(points, toward, RADIUS)
        if self.surface is not None:
            toward = np.array([0.35, 0.25, 1.0])
            return View.facing(self.surface.vertices, toward, 1.25 * RADIUS)
        return View.facing(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), np.zeros(3), RADIUS)


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


# The fill explorer's keys: which there are, and what they do to its state.

#: (keys, what they do), as the help lists them; a lone head begins a group.
KEY_HELP = (
    ("← →", "previous, next fill"),
    ("↑ ↓", "variants of the fill: other fills of its pattern"),
    ("a", "all fills, or one of each pattern"),
    ("Home End", "first, last fill so far"),
    ("m", "look for twice as many"),
    ("o", "order of the fills"),
    ("r", "relaxed or strict corners"),
    ("b", "draw a boundary: click its corners;"),
    ("", "click the last again, or Enter, to close"),
    ("⌫", "take the last corner back"),
    ("- +", "edges of the side at the pointer"),
    ("[ ]", "edges of all sides"),
    ("c", "corner at the pointer: convex, reflex"),
    ("k", "fill the boundary's other side"),
    ("s   l", "draw a stroke; a loop (drag)"),
    ("x", "forget the last stroke"),
    (", .", "tolerance of strokes, in edges"),
    ("f", "strands follow strokes, or not"),
    ("n", "show the fill, or the boundary alone"),
    ("v   u", "view back to the middle; roll it"),
    ("w   p", "save the fill as OBJ; the picture"),
    ("h ?   q", "this list; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag: turn    right drag: turn, always    middle drag: shift    wheel: zoom"

#: By how much the keys [ and ] scale edge counts.
FINER = 1.25

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in ALIASES.items() if key in {*"[],.+-"} or key == "h"}
    | {
        "space": "Right",
        "Return": "Enter",
        "KP_Enter": "Enter",
        "Delete": "BackSpace",
        "Page_Down": "Next",
        "Page_Up": "Prior",
    }
    | {c.upper(): c for c in "amorbcksxlfnvuwphq"}
)

ACTIONS: dict[str, Callable[[ExplorerState], None]] = {
    "Left": lambda e: e.finder.step(-1),
    "Right": lambda e: e.finder.step(1),
    "Up": lambda e: e.finder.step_variant(-1),
    "Down": lambda e: e.finder.step_variant(1),
    "a": lambda e: e.finder.toggle_folded(),
    "Prior": lambda e: e.finder.step(-10),
    "Next": lambda e: e.finder.step(10),
    "Home": lambda e: e.finder.look_at(0),
    "End": lambda e: e.finder.look_at(-1),
    "m": lambda e: e.finder.more(),
    "o": lambda e: e.finder.change_order(),
    "r": lambda e: e.finder.toggle_strict(),
    "b": lambda e: _enter(e, PointerMode.CORNERS),
    "Enter": lambda e: e.close_boundary(),
    "BackSpace": lambda e: e.undo_corner(),
    "-": lambda e: e.change_length(-1),
    "+": lambda e: e.change_length(1),
    "[": lambda e: e.scale_lengths(1.0 / FINER),
    "]": lambda e: e.scale_lengths(FINER),
    "c": lambda e: e.toggle_corner(),
    "k": lambda e: e.reverse(),
    "s": lambda e: _enter(e, PointerMode.STROKE),
    "l": lambda e: _enter(e, PointerMode.LOOP),
    "x": lambda e: e.finder.drop_stroke(),
    ",": lambda e: e.finder.change_tolerance(-1),
    ".": lambda e: e.finder.change_tolerance(1),
    "f": lambda e: e.finder.toggle_following(),
    "n": lambda e: e.toggle("hiding"),
    "v": lambda e: e.fit(),
    "u": lambda e: e.roll(),
    "h": lambda e: e.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"w": Effect.OBJ, "p": Effect.PICTURE, "q": Effect.QUIT}


def _enter(state: ExplorerState, mode: PointerMode) -> None:
    """The key that entered a mode leaves it, too."""
    if state.mode is mode:
        state.leave()
    else:
        state.begin(mode)


def _leave(state: ExplorerState) -> bool:
    """Leave a mode or the help; False if there is none to leave."""
    left = state.mode is not PointerMode.LOOK or state.helping
    if left:
        state.helping = False
        state.leave()
    return left


KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, _leave)
