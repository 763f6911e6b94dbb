"""What the viewer of surfaces shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.editing import Find, SurfacingEditing, find_network_cycles
from patterndb_sketch.surfacing.edits import SurfacingEdits
from patterndb_sketch.surfacing.inking import InkedStroke, find_snaps
from patterndb_sketch.surfacing.methods import METHODS, SurfaceRequest
from patterndb_sketch.surfacing.patch import Surfacing
from patterndb_sketch.surfacing.patchsurface import PatchSurface
from patterndb_sketch.surfacing.session import SurfacingWork
from query.engine import PatternSource
from viewer.camera import Camera, View, ViewerState
from viewer.pointer import RING_REACH, STROKE_END_REACH, ButtonPress
from viewer.slider import Slider

#: The price of chords; where it is small, little of it does much: places go by its square root.
ALPHA = Slider("alpha", 0.0, 1.0, 0.001, ends=("more chords", "fewer"), power=2.0)

#: From where a network is looked at: a little from the right and from above.
TOWARD, UP = (0.55, 0.42, 1.0), (0.0, 1.0, 0.0)

#: What is upright in pictures, by name: the turn (3, 3) that brings y there. Most drawing programs
#: take y, many that build take z.
UPRIGHT: dict[str, ArrayLike] = {
    "y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "x": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
    "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    "-z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "-x": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
}


def look_from(upright: str) -> tuple[Points, Points]:
    """From where (3,), and with what upright (3,), a network is looked at; upright: of UPRIGHT."""
    turn = np.array(UPRIGHT[upright], np.float64)
    return turn @ np.array(TOWARD), turn @ np.array(UP)


#: What the pointer drags.
Drag = Literal["view", "stroke"]


#: A stroke is looked up on the surface every so many points of the picture, however fast the
#: pointer moves.
STEP = 3.0


class StrokePointer:
    """Draws on a body: rays so far, through places of the picture."""

    def __init__(self) -> None:
        self.lift()

    def lift(self) -> None:
        """Forget what was not finished."""
        self._origins: list[Points] = []
        self._directions: list[Points] = []
        self._last: tuple[float, float] | None = None

    @property
    def down(self) -> bool:
        """Has a stroke been begun?"""
        return self._last is not None

    def extend(self, view: View, x: float, y: float, reach: float) -> None:
        """The stroke goes on to here; reach: how far from the focus a ray begins."""
        places = np.array([[x, y]])
        if self._last is not None:
            way = np.hypot(x - self._last[0], y - self._last[1])
            if way < STEP:
                return
            share = np.linspace(0.0, 1.0, 1 + int(np.ceil(way / STEP)))[1:, None]
            places = np.array(self._last) * (1.0 - share) + places * share
        for place in places.tolist():
            origin, direction = cast_ray(view, place[0], place[1], reach)
            self._origins.append(origin)
            self._directions.append(direction)
        self._last = (x, y)

    def ink(self, surfacing: Surfacing, body: PatchSurface) -> InkedStroke:
        """What has been drawn so far, on a surface; body: that of the surface."""
        origins, directions = np.stack(self._origins), np.stack(self._directions)
        hits = body.surface.cast_rays(origins, directions)
        runs = hits.list_runs()
        parts = tuple(hits.points[run] for run in runs)
        owners = tuple(body.owners[hits.triangles[run]] for run in runs)
        return InkedStroke(surfacing, parts, owners, int((~hits.found).sum()), len(origins))


def cast_ray(view: View, x: float, y: float, reach: float) -> tuple[Points, Points]:
    """Cast a ray: origin (3,) and direction (3,) of what is seen at a place of the picture."""
    toward = view.axes[2]
    return view.under(x, y) + reach * toward, -toward


class PatchUnderPointer(NamedTuple):
    """What the pointer is on: a patch that is on or off, and which of these."""

    on: bool
    number: int


class SurfacingState(ViewerState[Camera]):
    """A network, the surface that is made of it, and how it is looked at.

    source: a drawing or a network. settings: the method and alpha to begin with. spacing: about
    how far vertices are apart; by default that of
    :func:`patterndb_sketch.surfacing.surfaces.surface` for the whole drawing, in every stage.
    db: where quads come from; without it there are none. afresh: find cycles even if the
    network has some. added, banned: cycles that shall, or shall not, be patches. find: how
    cycles are found.
    toward, up: (3,) from where it is looked at, and what is upright. surface_shown and so
    on: what is seen.
    """

    def __init__(
        self,
        source: Drawing | CurveNetwork,
        *,
        settings: SurfaceRequest | None = None,
        spacing: float | None = None,
        db: PatternSource | None = None,
        afresh: bool = False,
        added: Sequence[Cycle] = (),
        banned: Sequence[Cycle] = (),
        find: Find = find_network_cycles,
        toward: ArrayLike = TOWARD,
        up: ArrayLike = UP,
    ) -> None:
        drawing = source if isinstance(source, Drawing) else Drawing(source)
        wanted = SurfaceRequest() if settings is None else settings
        given = None if afresh or not drawing.network.cycles else drawing.network.cycles
        first = SurfacingEdits(
            drawing, len(drawing.stages), given, tuple(added), tuple(banned), wanted.method
        )
        #: What is asked for, and what was made of it.
        self.surfaces = SurfacingEditing(first, wanted, spacing, db, find)
        super().__init__(Camera(self.surfaces.all_points, toward, up), self.surfaces)
        self.drawing_mode = False
        self._quill = StrokePointer()
        self._drag: Drag | None = None
        self._press = ButtonPress()
        self.surface_shown = self.chords_shown = self.curves_shown = self.off_shown = True
        self.openings_shown = True
        self._edges_chosen: tuple[str, bool] | None = None

    @property
    def edges_shown(self) -> bool:
        """Are the edges of faces seen? With a method that makes quads, until they are switched."""
        method, chosen = self.surfaces.edits.method, self._edges_chosen
        if chosen is not None and chosen[0] == method:
            return chosen[1]
        return METHODS[method].makes_quads

    @edges_shown.setter
    def edges_shown(self, shown: bool) -> None:
        self._edges_chosen = self.surfaces.edits.method, shown

    @property
    def ink(self) -> InkedStroke | None:
        """The stroke that is being drawn, as it lies so far."""
        made = self.surfaces.made
        if not self._quill.down or made is None or made.surfacing is None or made.body is None:
            return None
        return self._quill.ink(made.surfacing, made.body)

    def find_snaps(self) -> list[Points]:
        """Where the ends of the stroke that is drawn, or was drawn last, would be moved to."""
        ink = self.ink or next(reversed(self.surfaces.edits.inks), None)
        return [] if ink is None else find_snaps(ink, STROKE_END_REACH / self.camera.view.scale)

    def take_work(self, work: SurfacingWork) -> None:
        self.leave()
        self.surfaces.take_work(work)

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        return self.surfaces.poll()

    def settle(self) -> None:
        """Wait for the surface that was asked for; raises what making it raised."""
        self.surfaces.settle()

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self.surfaces.close()

    # What keys do

    def next_method_here(self) -> None:
        """The next method for the patch under the pointer."""
        under = self.under()
        if under is None or not under.on:
            self.message = "put the pointer on a patch"
            return
        self.surfaces.choose_next_method_of(under.number)

    def toggle_patch(self) -> None:
        """Switch the patch under the pointer off, or on again."""
        under = self.under()
        if under is None:
            self.message = "put the pointer on a patch"
            return
        self.surfaces.toggle_patch(under.on, under.number)

    def begin_drawing(self) -> None:
        """Draw strokes with the pointer, or end that."""
        if not self.drawing_mode and not self.surfaces.patches:
            self.message = "there is no surface to draw on"
            return
        self._quill.lift()
        self.drawing_mode = not self.drawing_mode

    def leave(self) -> None:
        """Back to looking; what was not finished is forgotten."""
        self.drawing_mode = False
        self._quill.lift()

    def add_curves(self) -> None:
        """Make the last stroke curves of the network."""
        if self.surfaces.add_curves(STROKE_END_REACH / self.camera.view.scale):
            self.leave()

    def go_to_stage(self, stage: int) -> None:
        """Show the drawing as it was after so many stages; what was being drawn is forgotten."""
        self.leave()
        self.surfaces.go_to_stage(stage)

    # The pointer, at places of the picture in points from its middle

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = self.under()
        last, self.camera.pointer = self.camera.pointer, (x, y)
        if self._drag == "stroke":
            self._quill.extend(self.camera.view, x, y, self._far())
        elif self._drag == "view" and last is not None:
            begun = self._press.find_drag(last, (x, y))
            if begun is None:
                return False
            self.camera.turn(x - begun[0], y - begun[1])
        else:
            return before != self.under()
        return True

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.camera.pointer = (x, y)
        self.message = ""
        drawn = self.drawing_mode and not turn
        self._press.begin((x, y), drags=turn or drawn)
        self._drag = "stroke" if drawn else "view"
        if drawn:
            self._quill.extend(self.camera.view, x, y, self._far())
        return drawn

    def release(self, x: float, y: float) -> bool:
        """The button goes up: a drag ends, or it was a click."""
        drag, self._drag, clicked = self._drag, None, self._press.end()
        if drag == "stroke":
            self._quill.extend(self.camera.view, x, y, self._far())
            self._end_stroke()
            return True
        if drag == "view" and clicked:
            if self.under() is None:
                return False
            self.toggle_patch()
            return True
        return False

    def under(self) -> PatchUnderPointer | None:
        """What the pointer is on, the patch that is seen there; rings and outlines before."""
        if self.camera.pointer is None:
            return None
        if (
            self.surfaces.made is None
            or self.surfaces.made.task.drawing is not self.surfaces.edits.drawing
        ):
            # Until its surface is there, patches go by the curves of the drawing before.
            return None
        hit = self._hit(self.surfaces.body) if self.surface_shown else None
        if not self.off_shown or self.surfaces.off_body is None:
            return None if hit is None else PatchUnderPointer(True, hit[0])
        nearness = -np.inf if hit is None else hit[1]
        for number, middle in enumerate(self.surfaces.rings()):
            seen = self.camera.view.seen(middle)
            if (
                np.hypot(*(seen[:2] - self.camera.pointer)) <= RING_REACH
                and seen[2] >= nearness - RING_REACH
            ):
                return PatchUnderPointer(False, number)
        if hit is not None:
            return PatchUnderPointer(True, hit[0])
        off = self._hit(self.surfaces.off_body)
        return None if off is None else PatchUnderPointer(False, off[0])

    # How it is done

    def _hit(self, body: PatchSurface | None) -> tuple[int, float] | None:
        """The patch of a body under the pointer, and how near to the viewer it is there."""
        if body is None or self.camera.pointer is None:
            return None
        origin, direction = cast_ray(self.camera.view, *self.camera.pointer, self._far())
        hit = body.surface.cast_rays(origin[None], direction[None])
        if not hit.found[0]:
            return None
        return int(body.owners[hit.triangles[0]]), float(self.camera.view.seen(hit.points[0])[2])

    def _end_stroke(self) -> None:
        ink = self.ink
        self._quill.lift()
        if ink is None:
            return
        if not ink.parts:
            self.message = "the stroke is beside the surface"
            return
        self.surfaces.add_ink(ink)

    def _far(self) -> float:
        """From the focus to where rays begin: before anything that can be seen."""
        return 2.0 * self.surfaces.extent + float(
            np.linalg.norm(self.camera.view.focus - self.surfaces.centre)
        )
