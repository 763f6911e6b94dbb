"""The tool in use: what the pointer is on, how far the tool reaches, and what would come of it."""

from __future__ import annotations

from typing import Literal

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.strips import pair_edges, trace_strips_at
from patterndb.geometry.surface import SurfacePoints
from patterndb_sketch.retopo.editing import RetopoEditing
from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import RetopoMesh, find_strip
from patterndb_sketch.retopo.picking import NetworkPicker
from patterndb_sketch.retopo.previews import Preview
from patterndb_sketch.retopo.tool import SNAP
from patterndb_sketch.retopo.tools.loop import plane_of_line
from viewer.pointer import CHAIN_REACH, CLICK
from viewer.retopo.modes import ToolMode, ToolOption, list_modes
from viewer.retopo.pointing import RetopoCamera, pick_foot, pick_line

#: Brushes follow the view: nearer by, they reach less; so far, at most and at least.
ZOOMS = (0.05, 1.0)


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
        self.strips_shown = True
        self._strips = StripFinder()
        self._picker = NetworkPicker()

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
        """Have the preview made that the pointer asks for, and the list of fills of its patch."""
        patch = (
            self.patch_under() if self.mode.target == "patch" and not self.editing.waiting else None
        )
        if patch is not None:
            self.editing.want_list(patch)
        self.editing.want_preview(self._find_call())

    @property
    def preview(self) -> Preview | None:
        """What would come of it, None where that is not known or nothing would."""
        return self.editing.preview

    def _find_call(self) -> Call | None:
        """The call that letting go, or a click, would make here; None where no preview helps."""
        tool, held, foot = self.mode.tool, self.held, self.foot
        if held == "plane" and self.pressed is not None and self.camera.pointer is not None:
            try:
                places = self.tell_plane(self.pressed, self.camera.pointer)
            except RefusedError:
                return None
        elif foot is None:
            return None
        elif tool == "autocomplete" and held in (None, "click"):
            places = {"at": foot.points[0].tolist(), "choice": self.choice}
        elif tool == "insertloop" and held in (None, "click"):
            places = {"at": foot.points[0].tolist()}
        elif tool == "spine" and held == "line" and len(self.line) > 2:
            places = {self.mode.places[0]: np.stack(self.line).tolist()}
        elif self.mode.gesture == "drag" and held == "drag" and self.strayed:
            places = self.tell_ends(self.line[0], foot)
        else:
            return None
        return None if places is None else Call(tool, self.tell_arguments() | places)

    # How it is done

    def let_go(self) -> None:
        self.line = []
        self.pressed = None
        self.editing.want_preview(None)

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

    def tell_plane(
        self, begin: tuple[float, float], end: tuple[float, float]
    ) -> dict[str, object] | None:
        """The places that a line across the view gives: a point of its plane on the surface, the
        plane's normal, and the limit of the cut; None if the line passes no surface."""
        if np.hypot(end[0] - begin[0], end[1] - begin[1]) < CLICK:
            return None
        met = pick_line(self.camera.view, self.editing.surface, begin, end)
        if not len(met):
            return None
        view = self.camera.view
        normal, limit = plane_of_line(view.under(*begin), view.under(*end), view.axes[2])
        return {"at": met[len(met) // 2].tolist(), "normal": normal.tolist(), "limit": limit}
