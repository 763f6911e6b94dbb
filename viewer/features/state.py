"""What the viewer of feature curves shows and how that changes: no window in here."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from patterndb.geometry.surface import Surface
from patterndb_sketch.features.drag import Drag, begin_drag, move_drag
from patterndb_sketch.features.editing import FeatureEditing
from patterndb_sketch.features.edits import DrawnCurve, FeatureEdits
from patterndb_sketch.features.files.curvefiles import FeatureFiles
from patterndb_sketch.features.session import FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from viewer.camera import ModelCamera, ViewerState
from viewer.features.pointing import (
    CurveUnderPointer,
    find_surface_point,
    find_under_pointer,
    is_visible,
    make_matrix_camera,
    to_picture_place,
)
from viewer.features.sliders import SLIDERS, get_slider_value, replace_value
from viewer.pointer import PIN_REACH, ButtonPress

#: Seconds that each move of the pointer waits for what it changes: a pin follows it in any case.
LIVE = 0.02

#: What the pointer drags.
Held = Literal["view", "curve", "click"]


class FeatureState(ViewerState[ModelCamera]):
    """A model, the curves on it, and how it is looked at.

    session: what has been worked on before. settings: of the next curve. files: for keys that
    save.

    Raises InvalidFeatureError for a session whose settings are out of range.
    """

    def __init__(
        self,
        model: Surface,
        *,
        session: FeatureSession | None = None,
        settings: SnapSettings | None = None,
        files: FeatureFiles | None = None,
    ) -> None:
        #: The curves, and what is done to them.
        self.editing = FeatureEditing(
            model,
            FeatureSession() if session is None else session,
            SnapSettings() if settings is None else settings,
            files,
        )
        super().__init__(ModelCamera(model.vertices), self.editing)
        self._held: Held | None = None
        self._press = ButtonPress()
        self._drag: Drag | None = None
        self._before: FeatureEdits | None = None
        self._base: DrawnCurve | None = None

    @property
    def pulling(self) -> Drag | None:
        """The sample that the pointer pulls."""
        return self._drag

    @property
    def holding(self) -> bool:
        """Does the pointer hold a curve?"""
        return self._held == "curve"

    @property
    def closing(self) -> bool:
        """Is the pointer on the first of the clicks, so that one more closes the curve?"""
        editing, place = self.editing, self.camera.pointer
        if editing.clicks is None or not editing.may_close or place is None:
            return False
        first = editing.clicks[0]
        seen = self.camera.view.seen(first)[:2]
        near = bool(np.linalg.norm(seen - np.array(place)) <= PIN_REACH)
        return near and is_visible(self.camera.view, editing.model, self.camera.room, first)

    # What keys do, see viewer.features.keys

    def next_model_look(self) -> None:
        """The model solid, transparent or hidden; never hidden where there is no curve."""
        self.message = self.camera.next_model_look(may_hide=bool(self.editing.edits.curves))

    def unpin(self) -> None:
        """Take the pin under the pointer away."""
        under = self.under()
        curve = None if under is None else self.editing.edits.find(under.key)
        if under is None or curve is None or under.pin is None:
            self.message = "put the pointer on a pin"
            return
        self.editing.selected = curve.key
        self.editing.revise(curve.unpinned(under.pin))

    def slide(self, name: str, by: float) -> None:
        """Move a slider by a part of its length."""
        settings, slider = self.editing.shown_settings, SLIDERS[name]
        value = slider.moved(get_slider_value(settings, name), by)
        self.editing.change(replace_value(settings, name, value))

    # Sliders, which change the curve that is drawn or selected, and the next one

    def begin_sliding(self) -> None:
        """A slider is held: all until it is let go is one step."""
        self._begin_change(
            self.editing.curve if self.editing.clicks is None else self.editing.preview
        )

    def slide_to(self, name: str, value: float) -> None:
        """The slider of a setting is at a value."""
        settings = self.editing.shown_settings
        if value == get_slider_value(settings, name):
            return
        settings = replace_value(settings, name, value)
        base = self._base
        if self.editing.clicks is not None or base is None:
            self.editing.change(settings)
            return
        self.editing.settings = settings
        self._live(replace(base, settings=settings), base)

    def end_sliding(self) -> None:
        """It is let go."""
        self._base = None
        self._end_change()

    # The pointer, at places of the picture in points from its middle

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self.camera.pointer = (x, y)
        self._press.begin((x, y), drags=turn)
        self.message = ""
        self._held = "view"
        if turn:
            return False
        under = self.under() if self.editing.clicks is None else None
        curve = None if under is None else self.editing.edits.find(under.key)
        if under is not None and curve is not None:
            self._grab(curve, under)
        else:
            self._held = "click"
        return True

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        before = self.under(), self.closing
        last, self.camera.pointer = self.camera.pointer, (x, y)
        if self._held is None or last is None:
            return before != (self.under(), self.closing)
        begun = self._press.find_drag(last, (x, y))
        if begun is None:
            return False
        if self._held == "curve":
            self._pull(x, y)
        else:
            self.camera.turn(x - begun[0], y - begun[1])
        return True

    def release(self, x: float, y: float) -> bool:
        """The button comes up: what was dragged stays, or it was a click."""
        held, clicked = self._held, self._press.end()
        drag, base = self._drag, self._base
        self._held = self._drag = self._base = None
        self.camera.pointer = (x, y)
        if held == "curve" and base is not None and clicked:
            self.editing.select(base.key)
        elif held == "curve":
            self._end_change()
            if drag is not None and drag.missed:
                self.message = "the pointer left the model: the pin stays where it was last"
        elif held == "click" and clicked and self.closing:
            self.editing.close_curve()
        elif held == "click" and clicked:
            self.editing.click(
                find_surface_point(self.camera.view, self.editing.model, self.camera.room, x, y)
            )
        else:
            return held == "view" and not clicked
        return True

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        return self.editing.poll()

    def settle(self) -> None:
        """Wait for all that was asked for."""
        self.editing.settle()

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self.editing.close()

    def under(self) -> CurveUnderPointer | None:
        """The pin or the curve under the pointer; while a curve is pulled, that one."""
        if self._held == "curve" and self._base is not None:
            return CurveUnderPointer(
                self._base.key, None if self._drag is None else self._drag.sample
            )
        if self.camera.pointer is None or self.editing.clicks is not None:
            return None
        drawn = [(curve, self.editing.look(curve)) for curve in self.editing.edits.curves]
        lines = [(curve, look.line) for curve, look in drawn if look is not None]
        through = self.camera.model_look != "solid"
        return find_under_pointer(
            self.camera.view,
            self.editing.model,
            self.camera.room,
            lines,
            self.camera.pointer,
            through=through,
        )

    # How it is done

    def row_of_selected(self) -> int | None:
        """The place of the selected curve among all."""
        return next(
            (
                i
                for i, one in enumerate(self.editing.edits.curves)
                if one.key == self.editing.selected
            ),
            None,
        )

    def _begin_change(self, base: DrawnCurve | None) -> None:
        """What comes is one step, however often it changes: all is made of what is there now."""
        self._before, self._base = self.editing.edits, base

    def _end_change(self) -> None:
        before, self._before = self._before, None
        if before is not None and before is not self.editing.edits:
            self.editing.steps.keep(before)

    def _grab(self, curve: DrawnCurve, under: CurveUnderPointer) -> None:
        """The pointer pulls the sample that is seen nearest to it, or that of a pin."""
        look = self.editing.look(curve)
        assert look is not None and self.camera.pointer is not None
        seen = make_matrix_camera(self.camera.view, self.editing.model, self.camera.room)
        place = to_picture_place(self.camera.room, *self.camera.pointer)
        samples = look.samples
        if under.pin is not None:
            samples = samples[under.pin : under.pin + 1]
        drag = begin_drag(seen, self.editing.model, samples, place)
        if under.pin is not None:
            drag = replace(drag, sample=under.pin)
            # Where the pin was before is no matter, as if it were set for the first time.
            curve = curve.unpinned(under.pin)
        self._held, self._drag = "curve", drag
        self._begin_change(curve)
        self.editing.ask_snap(curve)

    def _pull(self, x: float, y: float) -> None:
        drag, base = self._drag, self._base
        assert drag is not None and base is not None
        self.editing.selected = base.key
        drag = move_drag(drag, self.editing.model, to_picture_place(self.camera.room, x, y))
        place = (
            drag.begun
            + to_picture_place(self.camera.room, x, y)
            - drag.pressed
            - np.array(self.camera.room) / 2.0
        )
        point = find_surface_point(
            self.camera.view, self.editing.model, self.camera.room, *place.tolist()
        )
        if point is not None:
            # The same point, but for gaps between patches.
            drag = replace(drag, point=point, missed=False)
        self._drag = drag
        self._live(base.pinned(*drag.constraint), base)

    def _live(self, curve: DrawnCurve, base: DrawnCurve) -> None:
        """Show a curve changed while the button is down."""
        self.editing.steps.settle(self.editing.edits.with_curve(curve))
        self.editing.make(curve, base, LIVE)
