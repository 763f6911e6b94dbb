"""The tool in use: what the pointer is on, how far the tool reaches, and what would come of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.strips import pair_edges, trace_strips_at
from patterndb.geometry.surface import SurfacePoints
from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import RetopoMesh, find_strip
from patterndb_sketch.retopo.tool import SNAP, ToolWork
from patterndb_sketch.retopo.tools.loop import plane_of_line
from viewer.nearness import CHAIN_REACH, CLICK
from viewer.retopo.editing import RetopoEditing
from viewer.retopo.modes import ToolMode, ToolOption, list_modes
from viewer.retopo.pointing import (
    NetworkPicker,
    RetopoCamera,
    pick_foot,
    pick_line,
)
from viewer.retopo.previews import (
    Latest,
    Preview,
    preview_call,
    preview_completion,
    preview_cut,
    preview_inserted_loop,
    preview_pull,
    preview_spine_outline,
)

#: Brushes follow the view: nearer by, they reach less; so far, at most and at least.
ZOOMS = (0.05, 1.0)

#: Seconds that a move of the pointer waits for its preview.
LIVE = 0.03


class StripFinder:
    """Finds the strips of quads through a quad; what was found last is kept, and how a mesh's edges
    are paired."""

    def __init__(self) -> None:
        self._mesh: RetopoMesh | None = None
        self._twin = np.zeros(0, np.int32)
        self._quad = -1
        self._lines: list[Points] = []

    def find(self, mesh: RetopoMesh, quad: int) -> list[Points]:
        """The lines (n, 3) along the strips that pass a quad of a mesh."""
        if mesh is not self._mesh:
            self._mesh, self._twin, self._quad = mesh, pair_edges(mesh.quads), -1
        if quad != self._quad:
            self._quad = quad
            self._lines = trace_strips_at(mesh.vertices, mesh.quads, quad, self._twin)
        return self._lines


#: What the pointer drags.
Held = Literal["view", "line", "plane", "drag", "click"]


class ToolPointer:
    """A tool in use over a network on a surface.

    mode: what the left button does. choice: which completion is shown, 0 for the largest.
    options: of tools, as they were set. held: what the pointer drags, from where it was pressed,
    and whether it has strayed from there. foot: the point of the surface under the pointer. line:
    what is being drawn, on the surface. preview: what would come of it. strips_shown: are the
    strips of quads shown that pass the pointer?
    """

    def __init__(self, editing: RetopoEditing, camera: RetopoCamera) -> None:
        self.editing = editing
        self.camera = camera
        self.modes = list_modes()
        self.mode = self.modes[0]
        self.choice = 0
        self.options: dict[tuple[str, str], object] = {}
        self.factors: dict[str, float] = {}
        self.held: Held | None = None
        self.pressed: tuple[float, float] | None = None
        self.strayed = False
        self.foot: SurfacePoints | None = None
        self.line: list[Points] = []
        self.preview: Preview | None = None
        self.strips_shown = True
        self._strips = StripFinder()
        self._picker = NetworkPicker()
        self._latest = Latest()

    def close(self) -> None:
        """Wait until no preview is being made any more."""
        self._latest.close()

    # What is under the pointer

    @property
    def holding(self) -> bool:
        """Is something being drawn?"""
        return self.held in ("line", "plane", "drag")

    def chain_under(self) -> tuple[int, Points] | None:
        """The curve under the pointer, and its point (3,) nearest to it."""
        if self.foot is None:
            return None
        return self._picker.chain(
            self.editing.network, self.foot, CHAIN_REACH / self.camera.view.scale
        )

    def chains_meant(self) -> tuple[int, ...]:
        """The curves that a click, or the wheel, would act on."""
        if self.mode.target != "chain" or self.held == "view":
            return ()
        found = self.chain_under()
        if found is None:
            return ()
        whole = self.mode.gesture == "count" and self.tell_options().get("strip") is True
        return find_strip(self.editing.network, found[0]) if whole else (found[0],)

    def patch_under(self) -> int | None:
        """The patch under the pointer, if it has quads."""
        if self.foot is None:
            return None
        found = self.editing.shown.body.patch_at(self.foot.points[0])
        return None if found in self.editing.shown.stale() else found

    def mirror(self, points: Points) -> Points | None:
        """The image (..., 3) of points (..., 3) beyond the plane of symmetry; None where it is
        off."""
        plane = self.editing.shown.state.plane
        return None if plane is None else plane.mirror(points.reshape(-1, 3)).reshape(points.shape)

    def strips_under(self) -> list[Points]:
        """The lines (n, 3) along the strips of quads through the quad under the pointer; none where
        they are not asked for, or something is drawn or turned."""
        if not self.strips_shown or self.foot is None or self.held is not None:
            return []
        shown = self.editing.shown
        quad = shown.body.quad_at(self.foot.points[0])
        if quad is None or shown.body.mesh.patch[quad] in shown.stale():
            return []
        return self._strips.find(shown.body.mesh, quad)

    def snaps(self) -> list[Points]:
        """(3,) where the ends of what is drawn, or would be, snap to."""
        mode, foot = self.mode, self.foot
        if self.held == "view" or foot is None:
            return []
        if mode.target == "corner":
            node = self._picker.node(self.editing.network, foot, self.reach)
            chain = self._picker.chain(self.editing.network, foot, self.reach)
            at = node if node is not None else None if chain is None else chain[1]
            return [] if at is None else [at]
        if mode.target != "ends":
            return []
        feet = [foot]
        if self.held == "line" and self.line:
            feet.append(self.editing.surface.nearest(self.line[0][None]))
        found = [self._picker.end(self.editing.network, one, self.reach) for one in feet]
        return [at for at in found if at is not None]

    @property
    def plane_line(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """The straight line that is being dragged, in points of the picture; what a brush drags is
        seen below it."""
        if (
            self.held not in ("plane", "drag")
            or self.mode.given_as
            or self.pressed is None
            or self.camera.pointer is None
        ):
            return None
        return self.pressed, self.camera.pointer

    @property
    def brush_at(self) -> Points | None:
        """(3,) the middle of the tool's brush: where the pointer is, or a drag began."""
        if self.held == "drag":
            return self.line[0]
        return None if self.foot is None else self.foot.points[0]

    @property
    def brush(self) -> float:
        """Radius of the tool's brush, in the surface's unit; 0 for none."""
        mode = self.mode
        if not mode.brush or mode.brush == "edge":
            return 0.0
        if mode.brush == "snap" and not mode.given_as:
            return self.reach
        size = float(getattr(self.editing.sizes, mode.brush))
        return size * self._nearness * self.factors.get(mode.brush, 1.0) if mode.given_as else size

    @property
    def reach(self) -> float:
        """Radius within which the tool finds what is near, in the surface's unit: that of the
        sizes, and less nearer by where the tool can be told."""
        return self.editing.sizes.snap * (self._nearness if self.mode.snaps else 1.0)

    @property
    def _nearness(self) -> float:
        """How much less brushes reach in this view than in that of the whole surface."""
        return float(np.clip(self.camera.fit_all().scale / self.camera.view.scale, *ZOOMS))

    def option(self, mode: ToolMode, option: ToolOption) -> object:
        """The value of an option."""
        return self.options.get((mode.tool, option.name), option.values[0])

    # What would come of it

    def seek(self) -> None:
        """Have the preview made that the pointer asks for, and show it if it is there soon; have
        the list found of the patch that it is on."""
        patch = (
            self.patch_under() if self.mode.target == "patch" and not self.editing.waiting else None
        )
        if patch is not None and patch in self.editing.network.patches:
            self.editing.work.lists.want(
                self.editing.network,
                self.editing.network.patches[patch],
                self.editing.shown.work.source,
            )
        wanted = self._wanted()
        if wanted is None:
            self._latest.drop()
            self.preview = None
            return
        self._latest.want(*wanted)
        self._latest.wait(LIVE)
        self.take_preview()

    def _wanted(self) -> tuple[object, Callable[[], Preview]] | None:
        """What preview there is to be made, and a key that tells it from others."""
        shown, foot = self.editing.shown.work, self.foot
        # Tools reach as far as they will be told to.
        sizes = replace(shown.state.sizes, snap=self.reach)
        work = replace(shown, state=replace(shown.state, sizes=sizes))
        tool, held = self.mode.tool, self.held
        if tool == "autocomplete" and held in (None, "click") and foot is not None:
            radius, number = self.brush, self.choice
            key = (tool, shown, self.reach, foot.points.tobytes(), radius, number)
            return key, lambda: preview_completion(work, foot, radius, number)
        if tool == "spine" and held == "line" and len(self.line) > 2:
            line, width = np.stack(self.line), 2.0 * self.brush
            key = (tool, shown, self.reach, len(line), line[-1].tobytes(), width)
            return key, lambda: preview_spine_outline(work, line, width)
        if tool == "pull" and held == "drag" and self.strayed and foot is not None:
            begun, point = self.line[0], foot.points[0]
            key = (tool, shown, self.reach, begun.tobytes(), point.tobytes())
            return key, lambda: preview_pull(work, begun, point)
        if held == "plane" and self.pressed is not None and self.camera.pointer is not None:
            try:
                found = self.find_plane(self.pressed, self.camera.pointer)
            except RefusedError:
                return None
            if found is not None:
                at, normal, limit = found
                key = (tool, shown, self.reach, at.tobytes(), normal.tobytes())
                return key, lambda: preview_cut(work, at, normal, limit)
        return self._wanted_quads(work)

    def _wanted_quads(self, work: ToolWork) -> tuple[object, Callable[[], Preview]] | None:
        """The same of tools that change quads."""
        shown, foot = self.editing.shown, self.foot
        # While fills are made there is nothing to be seen anew, and the database is at work.
        if foot is None or not shown.fresh:
            return None
        mesh, tool, point = shown.body.mesh, self.mode.tool, foot.points[0]
        if tool == "insertloop" and self.held in (None, "click"):
            return (tool, shown, self.reach, point.tobytes()), lambda: preview_inserted_loop(
                work, mesh, foot
            )
        if self.mode.gesture == "drag" and self.held == "drag" and self.strayed:
            given = self.tell_arguments() | self.tell_ends(self.line[0], foot)
            return (tool, shown, str(given)), lambda: preview_call(
                work, mesh, Call(tool, given), point
            )
        return None

    def take_preview(self) -> None:
        """Show the preview that was found; one of another network is never shown."""
        found = self._latest.found()
        if found is not None:
            self.preview = found
        if self.preview is not None and self.preview.network is not self.editing.network:
            self.preview = None

    # How it is done

    def settle(self) -> None:
        """Wait for the preview that was asked for."""
        self._latest.wait()
        self.take_preview()

    def let_go(self) -> None:
        self.line = []
        self.pressed = None
        self.preview = None
        self._latest.drop()

    def point_at(self, x: float, y: float) -> None:
        self.camera.pointer = (x, y)
        self.foot = pick_foot(self.camera.view, self.editing.surface, x, y)

    def tell_options(self, mode: ToolMode | None = None) -> dict[str, object]:
        """The arguments that options stand for; those at their defaults say nothing."""
        mode = self.mode if mode is None else mode
        values = {option: self.option(mode, option) for option in mode.options}
        return {o.name: value for o, value in values.items() if value != o.values[0]}

    def tell_arguments(self) -> dict[str, object]:
        """What every call of the mode's tool is told beside its places."""
        given = dict(self.mode.fixed) | self.tell_options()
        if self.mode.given_as:
            width = 2.0 if self.mode.given_as == "width" else 1.0
            given[self.mode.given_as] = width * self.brush
        if self.mode.snaps and self.reach < self.editing.sizes.snap:
            given[SNAP] = self.reach
        return given

    def tell_ends(self, begun: Points, foot: SurfacePoints) -> dict[str, object]:
        """The places that a drag gives: where it began, and a foot."""
        first, second = self.mode.places
        return {first: begun.tolist(), second: foot.points[0].tolist()}

    def find_plane(
        self, begin: tuple[float, float], end: tuple[float, float]
    ) -> tuple[Points, Points, float] | None:
        """The plane through a line across the view: a point (3,) of it on the surface, its normal,
        and the limit of its cut; None if the line passes no surface."""
        if np.hypot(end[0] - begin[0], end[1] - begin[1]) < CLICK:
            return None
        met = pick_line(self.camera.view, self.editing.surface, begin, end)
        if not len(met):
            return None
        normal, limit = plane_of_line(
            self.camera.view.under(*begin), self.camera.view.under(*end), self.camera.view.axes[2]
        )
        return met[len(met) // 2], normal, limit
