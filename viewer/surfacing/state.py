"""What the viewer of surfaces shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.store import Database
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.edits import SurfacingEdits, choose_next_method
from patterndb_sketch.surfacing.inking import InkedStroke, find_snaps
from patterndb_sketch.surfacing.methods import DEFAULT_METHOD, METHODS, SurfaceOptions
from patterndb_sketch.surfacing.session import SurfacingWork
from viewer.buttonpress import ButtonPress
from viewer.camera import Camera, ViewerState
from viewer.nearness import RING_REACH, STROKE_END_REACH
from viewer.slider import Slider
from viewer.surfacing.body import SurfaceBody
from viewer.surfacing.ink import StrokePointer, cast_ray
from viewer.surfacing.maker import Find, find_network_cycles
from viewer.surfacing.surfaces import Surfaces

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
    on: what is seen. steps: of edits.
    """

    def __init__(
        self,
        source: Drawing | CurveNetwork,
        *,
        settings: SurfaceOptions | None = None,
        spacing: float | None = None,
        db: Database | None = None,
        afresh: bool = False,
        added: Sequence[Cycle] = (),
        banned: Sequence[Cycle] = (),
        find: Find = find_network_cycles,
        toward: ArrayLike = TOWARD,
        up: ArrayLike = UP,
    ) -> None:
        drawing = source if isinstance(source, Drawing) else Drawing(source)
        wanted = SurfaceOptions() if settings is None else settings
        given = None if afresh or not drawing.network.cycles else drawing.network.cycles
        first = SurfacingEdits(
            drawing, len(drawing.stages), given, tuple(added), tuple(banned), wanted.method
        )
        #: What is asked for, and what was made of it.
        self.surfaces = Surfaces(first, wanted, spacing, db, find)
        super().__init__(Camera(self.surfaces.all_points, toward, up), self.surfaces)
        self.steps = self.surfaces.steps
        self.drawing_mode = False
        self._quill = StrokePointer()
        self._drag: Drag | None = None
        self._press = ButtonPress()
        self.surface_shown = self.chords_shown = self.curves_shown = self.off_shown = True
        self.openings_shown = True
        self.edges_shown = METHODS[first.method].makes_quads
        self._saved: SurfacingEdits = first

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
        self.surfaces.settings = replace(self.surfaces.settings, alpha=work.alpha, fair=work.fair)
        self._edit(work.edits)
        self.edges_shown = METHODS[work.edits.method].makes_quads

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        return self.surfaces.poll() | self._lay_loose()

    def _lay_loose(self) -> bool:
        """Lay the strokes that were kept on their surface, once that is made; was it done?"""
        made = self.surfaces.made
        if self.surfaces.making or made is None or made.surfacing is None:
            return False
        inks = self.surfaces.edits.inks
        if all(ink.surfacing is not None for ink in inks):
            return False
        laid = [
            ink
            for one in inks
            if (ink := one.lay_on(made.surfacing) if one.surfacing is None else one) is not None
        ]
        self.steps.settle(replace(self.surfaces.edits, inks=tuple(laid)))
        return True

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
        cycle = self.surfaces.cycle_of(under.on, under.number)
        method = self.surfaces.edits.methods.get(cycle.key, self.surfaces.edits.method)
        self._edit(
            self.surfaces.edits.with_method_of(
                cycle, choose_next_method(method, database=self.surfaces.has_database)
            )
        )

    def toggle_patch(self) -> None:
        """Switch the patch under the pointer off, or on again."""
        under = self.under()
        if under is None:
            self.message = "put the pointer on a patch"
            return
        cycle = self.surfaces.cycle_of(under.on, under.number)
        self._edit(
            self.surfaces.edits.switched_off(cycle)
            if under.on
            else self.surfaces.edits.switched_on(cycle)
        )

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
        """Make the last stroke curves of the network; cycles are found anew, or cut."""
        made = self.surfaces.made
        if not self.surfaces.edits.inks or made is None or made.surfacing is None:
            self.message = "draw a stroke from curve to curve first"
            return
        ink = self.surfaces.edits.inks[-1]
        if made.surfacing is not ink.surfacing:
            self.message = "the surface has changed since the stroke was drawn; draw it anew"
            return
        try:
            after = self.surfaces.edits.with_stroke(ink, STROKE_END_REACH / self.camera.view.scale)
        except PatternDBError as error:
            self.message = str(error)
            return
        self.leave()
        self._edit(after)

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
            or self.surfaces.made.wish.drawing is not self.surfaces.edits.drawing
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

    def _hit(self, body: SurfaceBody | None) -> tuple[int, float] | None:
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
        if ink.missed:
            self.message = (
                f"the stroke left the surface: {ink.missed} of {ink.rays} places are beside it, "
                f"it is in {len(ink.parts)} part{'' if len(ink.parts) == 1 else 's'}"
            )
        edits = self.surfaces.edits
        self.steps.step(replace(edits, inks=(*edits.inks, ink)))

    def _far(self) -> float:
        """From the focus to where rays begin: before anything that can be seen."""
        return 2.0 * self.surfaces.extent + float(
            np.linalg.norm(self.camera.view.focus - self.surfaces.centre)
        )

    def change_alpha(self, alpha: float) -> None:
        """Another price of chords, 0 to 1; where no patch is cut so, all are from now."""
        alpha = round(min(max(alpha, 0.0), 1.0), 3)
        if alpha == self.surfaces.settings.alpha:
            return
        self.surfaces.settings = replace(self.surfaces.settings, alpha=alpha)
        edits = self.surfaces.edits
        if "chords" in (edits.method, *edits.methods.values()):
            self.surfaces.ask()
        else:
            self.choose_method("chords")
            self.message = "alpha is the price of chords: loops are cut along chords now"

    def toggle_fair(self) -> None:
        """Fair smooth patches across curves, or leave each by itself."""
        settings = self.surfaces.settings
        self.surfaces.settings = replace(settings, fair=not settings.fair)
        edits = self.surfaces.edits
        if settings.fair or DEFAULT_METHOD in (edits.method, *edits.methods.values()):
            self.surfaces.ask()
        else:
            self.choose_method(DEFAULT_METHOD)
            self.message = "fairing moves smooth patches: loops are filled by smooth grids now"

    def next_method(self) -> None:
        """The next method for all patches."""
        method = choose_next_method(self.surfaces.edits.method, database=self.surfaces.has_database)
        self.choose_method(method)

    def list_methods(self) -> list[str]:
        """List the methods that can be had here."""
        there = self.surfaces.has_database
        return [one.name for one in METHODS.values() if there or not one.needs_database]

    def choose_method(self, method: str) -> None:
        """A method, by its name, for all patches."""
        if method == self.surfaces.edits.method and not self.surfaces.edits.methods:
            return
        self._edit(self.surfaces.edits.with_method(method))
        self.edges_shown = METHODS[method].makes_quads

    def go_to_stage(self, stage: int) -> None:
        """Show the drawing as it was after so many stages, from the end if below 0.

        What was being drawn is forgotten.
        """
        self.leave()
        n = self.surfaces.n_stages
        if not n:
            self.message = "the drawing has no stages"
            return
        stage = min(max(stage if stage >= 0 else n + 1 + stage, 0), n)
        if stage != self.surfaces.edits.stage:
            self.steps.settle(replace(self.surfaces.edits, stage=stage, inks=()))
            self.surfaces.ask()

    def step(self, by: int) -> None:
        """Stages forward or back, stopping at the ends."""
        self.go_to_stage(max(self.surfaces.edits.stage + by, 0))

    def all_on(self) -> None:
        """Switch on whatever was switched off."""
        if self.surfaces.edits.banned:
            self._edit(replace(self.surfaces.edits, banned=()))

    @property
    def unsaved(self) -> bool:
        """Was anything edited since the surface was saved?"""
        return self.surfaces.edits is not self._saved

    def mark_saved(self) -> None:
        """The surface was saved as it is."""
        self._saved = self.surfaces.edits

    def undo(self) -> None:
        """Take back the last stroke, curve, click on a patch or change of method."""
        self._turn(self.steps.undo, "there is nothing to take back")

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._turn(self.steps.redo, "there is nothing to do again")

    def _turn(self, turn: Callable[[], bool], otherwise: str) -> None:
        before = self.surfaces.edits
        if not turn():
            self.message = otherwise
        elif not self.surfaces.edits.asks_like(before):
            self.edges_shown = METHODS[self.surfaces.edits.method].makes_quads
            self.surfaces.ask()

    def _edit(self, after: SurfacingEdits) -> None:
        """Another step that can be taken back."""
        self.steps.step(after)
        self.surfaces.ask()
