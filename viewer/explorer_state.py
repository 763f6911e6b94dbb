"""What the fill explorer shows and how that changes: no window in here.

It computes nothing itself: fills come from :func:`query.fills`, their vertices from
:func:`query.placing.place`. A query and the placing of a fill each run in a thread; whoever
shows the state asks :meth:`ExplorerState.poll` now and then whether there is something new.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import NotFoundError, PatternDBError
from query import Boundary, Fill, Fills, Stroke, fills
from query.engine import PatternSource
from query.placing import Placement, Region, Surface, enclosed, place
from query.ranking import ORDERS, Order
from query.stroke import TOLERANCE
from viewer.contour import Contour
from viewer.ground import Ground
from viewer.net import Net
from viewer.streaming import OneAtATime, Search
from viewer.view import View

Points = NDArray[np.float64]

#: Fills asked for at first; the key m asks for twice as many each time.
LIMIT = 100

#: Most edges that a strand's ends may be off, by the key.
MAX_TOLERANCE = 3

#: Radius of the picture's middle that a boundary is fitted into, in points.
RADIUS = 260.0

#: A click this near to another, in points, is on the same place; a drag of less is a click.
NEAR = 7.0

#: How near to a side or a corner the pointer must be to mean it, in points.
REACH = 90.0

#: Points of a drawn stroke are at least so far apart, in points of the picture.
STROKE_STEP = 4.0


class Mode(Enum):
    """What the pointer does."""

    LOOK = "look"
    CORNERS = "draw a boundary"
    STROKE = "draw a stroke"
    LOOP = "draw a loop"


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A fill where it lies."""

    fill: Fill
    placement: Placement
    net: Net


class ExplorerState:
    """A boundary on a surface, strokes, and the fills that stream in.

    surface: what is drawn and placed on; None is the plane of the boundary. boundary: its
    vertices placed, or None to have one drawn. strokes: on it.

    tolerance, order, strict, limit: as for :func:`query.fills`.
    """

    def __init__(
        self,
        source: PatternSource,
        boundary: Boundary | None = None,
        *,
        surface: Surface | None = None,
        strokes: Sequence[Stroke] = (),
        tolerance: int = TOLERANCE,
        order: Order | None = None,
        strict: bool = False,
        limit: int = LIMIT,
    ) -> None:
        self._source = OneAtATime(source)
        self.tolerance = tolerance
        self.order: Order | None = order
        self.strict = strict
        self.limit = limit
        self.following = True
        self.helping = False
        self.hiding = False
        self.mode = Mode.LOOK
        self.message = ""
        self.strokes: list[Stroke] = list(strokes)
        self.contour: Contour | None = None
        self.boundary: Boundary | None = None
        self.ground = Ground(surface)
        # What is being drawn.
        self.clicked: list[Points] = []
        self.paths: list[Points] = []
        self.preview: Points | None = None
        self.line: list[Points] = []
        self.pointer: tuple[float, float] | None = None
        self._dragged_from: tuple[float, float] | None = None
        # What is found.
        self.rank = 0
        self._search: Search | None = None
        self._ended: list[Search] = []
        self._seen: tuple[object, ...] = ()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="placing")
        self._placed: dict[tuple[int, bool], Future[Placed]] = {}
        self._region: tuple[Boundary, Region] | None = None
        if boundary is not None:
            self.contour = Contour.of(boundary)
            if surface is None:
                self.ground = _plane_of(boundary)
        self.view = self._fitted()
        if self.contour is not None:
            self._change(self.contour)

    # What is shown

    @property
    def surface(self) -> Surface | None:
        return self.ground.surface

    @property
    def fills(self) -> list[Fill]:
        """The fills found so far, best first."""
        return [] if self._search is None else self._search.fills

    @property
    def searching(self) -> bool:
        """May there be more fills to come?"""
        return self._search is not None and not self._search.done

    @property
    def truncated(self) -> bool:
        """Has the list been cut off, so that the key m finds more?"""
        return self._search is not None and self._search.truncated

    @property
    def default_order(self) -> Order:
        """The order of the fills where none is chosen; see :func:`query.fills`."""
        return "flow" if any(s.points is not None for s in self.strokes) else "artist"

    @property
    def fill(self) -> Fill | None:
        """The fill that is looked at; None while there is none."""
        found = self.fills
        return found[self.rank] if self.rank < len(found) else None

    @property
    def placed(self) -> Placed | None:
        """The fill that is looked at, where it lies; None while that is not known yet."""
        future = self._placing()
        if future is None or not future.done():
            return None
        if future.exception() is not None:
            return None
        return future.result()

    @property
    def trouble(self) -> str | None:
        """Why nothing is shown, if something is wrong."""
        search = self._search
        if search is not None and search.done and not search.fills:
            return search.error or search.reason
        future = self._placing()
        if future is not None and future.done():
            error = future.exception()
            if error is not None:
                return f"this fill cannot be placed: {error}"
        return search.error if search is not None else None

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        now = (len(self.fills), self.searching, self.placed, self.trouble)
        changed = now != self._seen
        self._seen = now
        return changed

    def settle(self, rank: int | None = None) -> None:
        """Wait for the fill of a rank (from 0; None: for all), look at it, wait for its place.

        Raises NotFoundError if there is no such fill.
        """
        if self._search is None:
            raise NotFoundError(self.message or "there is no boundary to fill; draw one")
        wanted = None if rank is None else rank + 1
        self._search.wait(wanted)
        if rank is not None:
            if rank >= len(self.fills):
                raise NotFoundError(
                    f"no fill: {self.trouble}"
                    if not self.fills
                    else f"there is no fill {rank + 1}, only {len(self.fills)}"
                )
            self.rank = rank
        future = self._placing()
        if future is not None:
            error = future.exception()
            if error is not None:
                raise error

    def close(self) -> None:
        """End what is going on, and wait until the source is not in use any more."""
        if self._search is not None:
            self._search.cancel()
            self._ended.append(self._search)
        for search in self._ended:
            search.join()
        self._worker.shutdown(wait=True, cancel_futures=True)

    # Looking, see viewer.explorer_keys

    def step(self, by: int) -> None:
        """Another fill, stopping at the ends of what has been found."""
        self.rank = max(0, min(self.rank + by, len(self.fills) - 1))

    def look_at(self, rank: int) -> None:
        """The fill of a rank from 0; from the end, if below 0."""
        self.rank = max(0, min(rank if rank >= 0 else len(self.fills) + rank, len(self.fills) - 1))

    def fit(self) -> None:
        """The boundary, or the surface, back into the middle."""
        self.view = self._fitted()

    def roll(self) -> None:
        """A quarter turn about the line of sight."""
        self.view = self.view.rolled()

    def toggle(self, name: str) -> None:
        """Turn one of the switches helping, hiding, following."""
        setattr(self, name, not getattr(self, name))

    # What changes the query

    def change_tolerance(self, by: int) -> None:
        """How far strands may miss the strokes' ends, in edges."""
        self.tolerance = max(0, min(self.tolerance + by, MAX_TOLERANCE))
        self._restart()

    def change_order(self) -> None:
        """The next order that makes sense here, after the last the default."""
        choices: list[Order | None] = [None]
        choices += [o for o in ORDERS if o != "flow" or self.default_order == "flow"]
        at = choices.index(self.order) if self.order in choices else 0
        self.order = choices[(at + 1) % len(choices)]
        self._restart()

    def toggle_strict(self) -> None:
        """Fills with the boundary's own corners only, or others too."""
        self.strict = not self.strict
        self._restart()

    def more(self) -> None:
        """Ask for twice as many fills."""
        if not self.truncated:
            self.message = "these are all the fills there are" if self.fills else ""
            return
        self.limit *= 2
        self._restart(keep_rank=True)

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

    def drop_stroke(self) -> None:
        """Forget the last stroke."""
        if self.strokes:
            self.strokes.pop()
            self._restart()

    # Drawing

    def begin(self, mode: Mode) -> None:
        """Enter a mode; what was begun in another is forgotten."""
        if mode in (Mode.STROKE, Mode.LOOP) and self.boundary is None:
            self.message = "there is no boundary yet to draw strokes on"
            return
        self.leave()
        self.mode = mode

    def leave(self) -> None:
        """Back to looking; what was not finished is forgotten."""
        self.mode = Mode.LOOK
        self.clicked, self.paths, self.line, self.preview = [], [], [], None

    def undo_corner(self) -> None:
        """Take the last clicked corner back."""
        if self.clicked:
            self.clicked.pop()
            self.preview = None
        if self.paths:
            self.paths.pop()

    def close_boundary(self) -> None:
        """Join the last clicked corner to the first, and ask for fills."""
        if self.mode is not Mode.CORNERS:
            return
        if len(self.clicked) < 3:
            self.message = "a boundary needs three corners; click them one after another"
            return
        sides = [*self.paths, self.ground.path(self.clicked[-1], self.clicked[0])]
        _, normals = self.ground.on(np.stack(self.clicked))
        try:
            contour = Contour.drawn(sides, normals)
        except PatternDBError as error:
            self.message = str(error)
            return
        self.leave()
        self.strokes = []
        self._change(contour)

    # The pointer, at places of the picture in points from its middle

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = (self.side_under(), self.corner_under())
        last, self.pointer = self.pointer, (x, y)
        if self._dragged_from is not None and last is not None:
            self.view = self.view.turned(x - last[0], y - last[1])
            return True
        if self.line:
            self._extend_line(x, y)
            return True
        if self.mode is Mode.CORNERS and self.clicked:
            at = self.ground.hit(self.view, x, y)
            self.preview = None if at is None else self.ground.path(self.clicked[-1], at)
            return True
        return before != (self.side_under(), self.corner_under())

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.pointer = (x, y)
        if turn or self.mode is Mode.LOOK:
            self._dragged_from = (x, y)
            return False
        self.message = ""
        if self.mode is Mode.CORNERS:
            self._click(x, y)
        else:
            self._extend_line(x, y)
            if not self.line:
                self.message = "strokes are drawn on the surface"
        return True

    def release(self, x: float, y: float) -> bool:
        """The button goes up."""
        if self._dragged_from is not None:
            self._dragged_from = None
            return False
        if self.line:
            self._extend_line(x, y)
            line, self.line = self.line, []
            self._add_stroke(line)
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
        if self.contour is None or self.pointer is None or self.mode is not Mode.LOOK:
            return None
        near = [_distance(self.view.seen(side), self.pointer) for side in self.contour.sides]
        best = int(np.argmin(near))
        return best if near[best] < REACH else None

    def corner_under(self) -> int | None:
        """Likewise the corner."""
        contour = self.contour
        if contour is None or self.pointer is None or self.mode is not Mode.LOOK:
            return None
        if not contour.corners:
            return None
        at = self.view.seen(np.stack([side[0] for side in contour.sides]))[:, :2]
        near = np.linalg.norm(at - self.pointer, axis=1)
        best = int(near.argmin())
        return best if near[best] < REACH else None

    # How it is done

    def _click(self, x: float, y: float) -> None:
        for i in {0, len(self.clicked) - 1} if self.clicked else ():
            at = self.view.seen(self.clicked[i])[:2]
            if np.hypot(*(at - (x, y))) < NEAR:
                # A double click, or a click on the first corner.
                self.close_boundary()
                return
        at = self.ground.hit(self.view, x, y)
        if at is None:
            self.message = "corners are put on the surface"
            return
        if self.clicked:
            self.paths.append(self.ground.path(self.clicked[-1], at))
        self.clicked.append(at)
        self.preview = None

    def _extend_line(self, x: float, y: float) -> None:
        at = self.ground.hit(self.view, x, y)
        if at is None:
            return
        if self.line:
            step = self.view.seen(np.stack([self.line[-1], at]))[:, :2]
            if np.hypot(*(step[1] - step[0])) < STROKE_STEP:
                return
        self.line.append(at)

    def _add_stroke(self, line: Sequence[Points]) -> None:
        boundary = self.boundary
        if boundary is None or boundary.points is None:
            return
        try:
            if self.mode is Mode.LOOP:
                stroke = Stroke.loop(np.stack(line))
            else:
                stroke = _snapped(boundary, Stroke.drawn(boundary, np.stack(line)))
        except PatternDBError as error:
            self.message = str(error)
            return
        self.strokes.append(stroke)
        self.mode = Mode.LOOK
        self._restart()

    def _change(self, contour: Contour) -> None:
        """Another boundary: strokes are drawn on it anew, and fills are asked for."""
        self.contour = contour
        self.boundary = None
        try:
            self.boundary = contour.boundary()
        except PatternDBError as error:
            self.message = str(error)
        else:
            self._redraw_strokes(self.boundary)
        self._restart()

    def _redraw_strokes(self, boundary: Boundary) -> None:
        kept: list[Stroke] = []
        for stroke in self.strokes:
            try:
                if stroke.points is not None and not stroke.is_loop:
                    stroke = Stroke.drawn(boundary, stroke.points)
                stroke.refuse_unless_on(boundary)
            except PatternDBError as error:
                self.message = f"a stroke was dropped: {error}"
            else:
                kept.append(stroke)
        self.strokes = kept

    def _restart(self, *, keep_rank: bool = False) -> None:
        """End the query that runs, and ask anew."""
        if self._search is not None:
            self._search.cancel()
            self._ended = [s for s in self._ended if not s.done] + [self._search]
        for future in self._placed.values():
            future.cancel()
        self._placed = {}
        if not keep_rank:
            self.rank = 0
        self._search = None if self.boundary is None else Search(self._question(self.boundary))

    def _question(self, boundary: Boundary) -> Callable[[], Fills]:
        strokes, tolerance, limit = tuple(self.strokes), self.tolerance, self.limit
        order, strict, source = self.order, self.strict, self._source
        if order == "flow" and self.default_order != "flow":
            order = None

        def ask() -> Fills:
            return fills(
                source,
                boundary,
                strokes=strokes,
                tolerance=tolerance,
                limit=limit,
                order=order,
                strict=strict,
            )

        return ask

    def _placing(self) -> Future[Placed] | None:
        """The work of placing the fill that is looked at; begun if it was not."""
        fill, boundary = self.fill, self.boundary
        if fill is None or boundary is None:
            return None
        key = (self.rank, self.following)
        if key not in self._placed:
            for future in self._placed.values():
                future.cancel()
            self._placed = {k: f for k, f in self._placed.items() if not f.cancelled()}
            self._placed[key] = self._worker.submit(
                self._place, fill, boundary, tuple(self.strokes), self.tolerance, self.following
            )
        return self._placed[key]

    def _place(
        self,
        fill: Fill,
        boundary: Boundary,
        strokes: tuple[Stroke, ...],
        tolerance: int,
        following: bool,
    ) -> Placed:
        assert boundary.points is not None
        region = None
        if self.surface is not None:
            # This is the one thread that places: nobody else writes this.
            if self._region is None or self._region[0] is not boundary:
                self._region = boundary, enclosed(self.surface, boundary.points)
            region = self._region[1]
        pulling = strokes if following else ()
        placement = place(fill, boundary.points, region, pulling, tolerance=tolerance)
        net = Net.of(fill, placement, region, boundary.corner_counts, strokes, tolerance)
        return Placed(fill, placement, net)

    def _fitted(self) -> View:
        if self.contour is not None:
            points = np.concatenate(self.contour.sides)
            toward = self.ground.on(points)[1].sum(axis=0)
            return View.facing(points, toward, RADIUS)
        if self.surface is not None:
            toward = np.array([0.35, 0.25, 1.0])
            return View.facing(self.surface.vertices, toward, 1.25 * RADIUS)
        return View.facing(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), np.zeros(3), RADIUS)


def _plane_of(boundary: Boundary) -> Ground:
    """The plane through a boundary's middle, across its mean normal."""
    assert boundary.points is not None
    middle = boundary.points.mean(axis=0)
    spokes = boundary.points - middle
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    return Ground(None, middle, area / size if size > 0.0 else None)


def _snapped(boundary: Boundary, stroke: Stroke) -> Stroke:
    """A stroke made to begin and end in the middle of its boundary edges."""
    assert boundary.points is not None and stroke.points is not None
    ends: list[Points] = []
    for end in (stroke.start, stroke.end):
        assert end is not None
        at = boundary.side_starts[end[0]] + end[1]
        ends.append((boundary.points[at] + boundary.points[(at + 1) % boundary.perimeter]) / 2.0)
    line = np.concatenate([ends[:1], stroke.points, ends[1:]])
    apart = [True, *(bool((a != b).any()) for a, b in pairwise(line))]
    return Stroke(stroke.start, stroke.end, line[apart])


def _distance(line: Points, pointer: tuple[float, float]) -> float:
    """From a polyline (k, 3) as it is seen to the pointer, in points."""
    a, b = line[:-1, :2], line[1:, :2]
    along = b - a
    square = (along**2).sum(axis=1)
    t = ((pointer - a) * along).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    foot = a + np.clip(t, 0.0, 1.0)[:, None] * along
    return float(np.linalg.norm(foot - pointer, axis=1).min())
