"""What the fill explorer shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import find_nearest_on
from patterndb.geometry.strips import trace_strips_at
from patterndb.system.numbers import TOLERANCE
from patterndb_sketch.exploration import Exploration, ExplorationStep
from patterndb_sketch.fillfinder import LIMIT
from query import Boundary, Fill, Stroke
from query.contour import Contour
from query.drawingbase import DrawingBase
from query.engine import PatternSource
from query.placing import Placement, Region, Surface
from viewer.camera import FILLED, Camera, View, ViewerState, fit_view
from viewer.net import Net
from viewer.pointer import SIDE_REACH
from viewer.pointerstroke import PointerMode, PointerStroke

#: Part of the picture's lesser size that a boundary is fitted into: its numbers need room.
FITTED = 0.76

#: What is upright on a turntable: most meshes stand along y.
UPWARD = (0.0, 1.0, 0.0)


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


def prepare_net(
    fill: Fill,
    placement: Placement,
    region: Region | None,
    boundary: Boundary,
    strokes: Sequence[Stroke],
    tolerance: int,
) -> Net:
    """Make what is drawn of a placed fill."""
    return Net.of(fill, placement, region, boundary.corner_counts, strokes, tolerance)


class ExplorerState(ViewerState[ExplorerCamera]):
    """A boundary on a surface, strokes, the fills that stream in, and how they are looked at.

    surface: what is drawn and placed on; None is the plane of the boundary. boundary: its
    vertices placed, or None to have one drawn. strokes: on it. tolerance, limit: as for
    :func:`query.fills`. folded: see :class:`patterndb_sketch.fillfinder.FillFinder`.
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
        self.exploration = Exploration(
            source,
            boundary,
            surface=surface,
            strokes=strokes,
            tolerance=tolerance,
            limit=limit,
            folded=folded,
            prepare=prepare_net,
        )
        self.finder = self.exploration.finder
        self.hiding = False
        #: The side that is shown as chosen, whatever the pointer is on.
        self.meant_side: int | None = None
        self.strips_shown = True
        self.mode = PointerMode.LOOK
        self.base = DrawingBase(surface)
        if boundary is not None and surface is None:
            self.base = DrawingBase.of_boundary(boundary)
        self._turning = False
        self.pen = PointerStroke(self.base)
        super().__init__(ExplorerCamera(self), self.finder)

    @property
    def contour(self) -> Contour | None:
        """The boundary with its sides, None while there is none."""
        return self.exploration.contour

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

    def undo(self) -> None:
        """Ask for what was asked before; while corners are clicked, take the last back."""
        if self.mode is PointerMode.CORNERS and self.pen.clicked:
            self.pen.undo_corner()
        elif self.exploration.undo():
            self.leave()

    def redo(self) -> None:
        """Ask again for what was taken back last."""
        if self.exploration.redo():
            self.leave()

    def take_work(self, work: ExplorationStep) -> None:
        self.leave()
        self.exploration.take_work(work)

    # The boundary

    def change_length(self, by: int) -> None:
        """One edge more or fewer on the side under the pointer."""
        side = self.side_under()
        if self.contour is None or side is None:
            self.message = "put the pointer on a side of the boundary"
            return
        self.exploration.change(self.contour.lengthened(side, by))

    def toggle_corner(self) -> None:
        """Make the corner under the pointer reflex, or convex."""
        corner = self.corner_under()
        if self.contour is None or corner is None:
            self.message = "put the pointer on a corner of the boundary"
            return
        self.exploration.change(self.contour.toggled(corner))

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
        self.exploration.begin(contour)

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
            self.exploration.keep_step()
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
            self.exploration.keep_step()
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
        self.exploration.add_stroke(stroke)

    def list_looked_at(self) -> tuple[Points, Points, float]:
        """The points (n, 3) that the view is fitted to, the direction (3,) that they face, and
        how large they are seen, the boundary being 1."""
        if self.contour is not None:
            points = np.concatenate(self.contour.sides)
            return points, self.base.on(points)[1].sum(axis=0), 1.0
        if self.surface is not None:
            return self.surface.vertices, np.array([0.35, 0.25, 1.0]), 1.25
        return np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), np.array([0.0, 0.0, 1.0]), 1.0
