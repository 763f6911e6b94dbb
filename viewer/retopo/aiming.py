"""Aiming: the tool in use, what the pointer is on, and what would come of it."""

from __future__ import annotations

from typing import Literal

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.editor import Editor
from patterndb_sketch.retopo.filling import find_strip
from patterndb_sketch.retopo.ground import GroundPoints
from patterndb_sketch.retopo.tool import SNAP
from patterndb_sketch.retopo.tools.loop import plane_of_line
from viewer.retopo.acting import Acting, RetopoFiles
from viewer.retopo.modes import ToolMode, ToolOption, list_modes
from viewer.retopo.pointing import (
    REACH,
    NetworkPicker,
    RetopoCamera,
    find_upright,
    pick_foot,
    pick_line,
)
from viewer.retopo.previews import (
    Latest,
    Preview,
)
from viewer.retopo.work import ListPlace
from viewer.skin import Skin

#: A button that never goes farther than this while it is down, in points, clicks.
CLICK = 4.0

#: Brushes follow the view: nearer by, they reach less; so far, at most and at least.
ZOOMS = (0.05, 1.0)

#: What the pointer drags.
Held = Literal["view", "line", "plane", "drag", "click"]


class Aiming(Acting, RetopoCamera):
    """A network on a ground as it is looked at, and a pointer over it.

    mode: what the left button does. choice: which completion is shown, 0 for the largest.
    options: of tools, as they were set. quads_shown, curves_shown, helping: what is seen. line:
    what is being drawn, on the ground. preview: what would come of it.
    """

    def __init__(
        self, editor: Editor, *, title: str = "", files: RetopoFiles | None = None
    ) -> None:
        Acting.__init__(self, editor, files)
        RetopoCamera.__init__(self, editor.ground.vertices, find_upright(editor.ground))
        self.title = title
        self.modes = list_modes()
        self.mode = self.modes[0]
        self.choice = 0
        self.options: dict[tuple[str, str], object] = {}
        self.quads_shown = self.curves_shown = True
        self.helping = False
        self.line: list[Points] = []
        self.preview: Preview | None = None
        corners = editor.ground.vertices[editor.ground.triangles]
        self.skin = Skin.of(corners, editor.ground.triangles)
        self.finder = NetworkPicker()
        self._factors: dict[str, float] = {}
        self._latest = Latest()
        self._held: Held | None = None
        self._pressed: tuple[float, float] | None = None
        self._strayed = False
        self._foot: GroundPoints | None = None

    def close(self) -> None:
        self._latest.close()
        Acting.close(self)

    # What is under the pointer

    @property
    def holding(self) -> bool:
        """Is something being drawn?"""
        return self._held in ("line", "plane", "drag")

    @property
    def foot(self) -> GroundPoints | None:
        """The point of the ground under the pointer."""
        return self._foot

    def chain_under(self) -> tuple[int, Points] | None:
        """The curve under the pointer, and its point (3,) nearest to it."""
        if self._foot is None:
            return None
        return self.finder.chain(self.network, self._foot, REACH / self.view.scale)

    def chains_meant(self) -> tuple[int, ...]:
        """The curves that a click, or the wheel, would act on."""
        if self.mode.target != "chain" or self._held == "view":
            return ()
        found = self.chain_under()
        if found is None:
            return ()
        whole = self.mode.gesture == "count" and self._told_options().get("strip") is True
        return find_strip(self.network, found[0]) if whole else (found[0],)

    def patch_under(self) -> int | None:
        """The patch under the pointer, if it has quads."""
        if self._foot is None:
            return None
        found = self.shown.body.patch_at(self._foot.points[0])
        return None if found in self.shown.stale() else found

    def empty(self) -> tuple[int, ...]:
        """The patches that have no quads, none of them while quads are made."""
        shown = self.shown
        if not shown.fresh:
            return ()
        return tuple(sorted(shown.state.network.patches.keys() - shown.filled.placed.keys()))

    def place_in_list(self, patch: int) -> ListPlace | None:
        """Which of its fills a patch has; None while that is not known."""
        return self._work.lists.place(self.network, self.network.patches[patch])

    def snaps(self) -> list[Points]:
        """(3,) where the ends of what is drawn, or would be, snap to."""
        mode, foot = self.mode, self._foot
        if self._held == "view" or foot is None:
            return []
        if mode.target == "corner":
            node = self.finder.node(self.network, foot, self.reach)
            chain = self.finder.chain(self.network, foot, self.reach)
            at = node if node is not None else None if chain is None else chain[1]
            return [] if at is None else [at]
        if mode.target != "ends":
            return []
        feet = [foot]
        if self._held == "line" and self.line:
            feet.append(self.ground.nearest(self.line[0][None]))
        found = [self.finder.end(self.network, one, self.reach) for one in feet]
        return [at for at in found if at is not None]

    @property
    def plane_line(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """The straight line that is being dragged, in points of the picture; what a brush drags is
        seen below it."""
        if (
            self._held not in ("plane", "drag")
            or self.mode.given_as
            or self._pressed is None
            or self.pointer is None
        ):
            return None
        return self._pressed, self.pointer

    @property
    def brush_at(self) -> Points | None:
        """(3,) the middle of the tool's brush: where the pointer is, or a drag began."""
        if self._held == "drag":
            return self.line[0]
        return None if self._foot is None else self._foot.points[0]

    @property
    def brush(self) -> float:
        """Radius of the tool's brush, in the surface's unit; 0 for none."""
        mode = self.mode
        if not mode.brush or mode.brush == "edge":
            return 0.0
        if mode.brush == "snap" and not mode.given_as:
            return self.reach
        size = float(getattr(self.sizes, mode.brush))
        return size * self._nearness * self._factors.get(mode.brush, 1.0) if mode.given_as else size

    @property
    def reach(self) -> float:
        """Radius within which the tool finds what is near, in the surface's unit: that of the
        sizes, and less nearer by where the tool can be told."""
        return self.sizes.snap * (self._nearness if self.mode.snaps else 1.0)

    @property
    def _nearness(self) -> float:
        """How much less brushes reach in this view than in that of the whole surface."""
        return float(np.clip(self._framed().scale / self.view.scale, *ZOOMS))

    def option(self, mode: ToolMode, option: ToolOption) -> object:
        """The value of an option."""
        return self.options.get((mode.tool, option.name), option.values[0])

    # How it is done

    def _let_go(self) -> None:
        self.line = []
        self._pressed = None
        self.preview = None
        self._latest.drop()

    def _point(self, x: float, y: float) -> None:
        self.pointer = (x, y)
        inside = x <= self.room[0] / 2.0
        self._foot = pick_foot(self.view, self.ground, x, y) if inside else None

    def _told_options(self, mode: ToolMode | None = None) -> dict[str, object]:
        """The arguments that options stand for; those at their defaults say nothing."""
        mode = self.mode if mode is None else mode
        values = {option: self.option(mode, option) for option in mode.options}
        return {o.name: value for o, value in values.items() if value != o.values[0]}

    def _given(self) -> dict[str, object]:
        """What every call of the mode's tool is told beside its places."""
        given = dict(self.mode.fixed) | self._told_options()
        if self.mode.given_as:
            width = 2.0 if self.mode.given_as == "width" else 1.0
            given[self.mode.given_as] = width * self.brush
        if self.mode.snaps and self.reach < self.sizes.snap:
            given[SNAP] = self.reach
        return given

    def _ends(self, begun: Points, foot: GroundPoints) -> dict[str, object]:
        """The places that a drag gives: where it began, and a foot."""
        first, second = self.mode.places
        return {first: begun.tolist(), second: foot.points[0].tolist()}

    def _plane(
        self, begin: tuple[float, float], end: tuple[float, float]
    ) -> tuple[Points, Points, float] | None:
        """The plane through a line across the view: a point (3,) of it on the ground, its normal,
        and the limit of its cut; None if the line passes no ground."""
        if np.hypot(end[0] - begin[0], end[1] - begin[1]) < CLICK:
            return None
        met = pick_line(self.view, self.ground, begin, end)
        if not len(met):
            return None
        normal, limit = plane_of_line(
            self.view.under(*begin), self.view.under(*end), self.view.axes[2]
        )
        return met[len(met) // 2], normal, limit
