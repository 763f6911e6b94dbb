"""A curve while it is drawn with clicks, and a name while it is typed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.initial import SAME_CLICK, find_initial_curve
from patterndb_sketch.features.model import Model
from patterndb_sketch.features.sessionfile import FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from viewer.features.choices import Choices
from viewer.features.edits import DrawnCurve
from viewer.features.work import FeatureFiles


class Picking(Choices):
    """Points that are clicked, and the curve that would be made of them.

    The arguments are those of :class:`viewer.features.work.Work`.
    """

    def __init__(
        self,
        model: Model,
        session: FeatureSession,
        settings: SnapSettings,
        files: FeatureFiles | None,
    ) -> None:
        super().__init__(model, session, settings, files)
        self.helping = False
        #: The points clicked so far while a curve is drawn, None if none is.
        self.clicks: tuple[Points, ...] | None = None
        #: The name as far as it is typed, None if none is.
        self.typed: str | None = None
        self._preview: DrawnCurve | None = None

    @property
    def preview(self) -> DrawnCurve | None:
        """The curve that would be made of the clicks so far."""
        return self._preview

    @property
    def shown_settings(self) -> SnapSettings:
        """What the sliders show: the settings of the curve that is drawn or selected, else of
        the next one."""
        return self.settings if self.clicks is not None else super().shown_settings

    def sketched(self) -> Points | None:
        """(k, 3) the line through the clicks, laid on the model, while it has not snapped."""
        preview = self._preview
        if preview is None or self.look(preview) is not None:
            return None
        return find_initial_curve(self.model, preview.clicked).samples

    def begin_curve(self) -> None:
        """Draw a curve with clicks, or begin it anew."""
        self._drop()
        self.clicks = ()

    def finish_curve(self) -> None:
        """Make a curve of the clicks."""
        preview = self._preview
        if self.clicks is None:
            self.message = "press c to draw a curve, and click points on the model"
        elif preview is None:
            self.message = "click two points of the model at least"
        elif self.trouble(preview):
            self.message = self.trouble(preview)
        else:
            # The curve is the preview itself: what it snapped to is known, or will be.
            self._step(self.edits.with_curve(preview))
            self.clicks = self._preview = None
            self.select(preview.key)

    def take_back(self) -> None:
        """Take the last click back, or the last step if no curve is drawn."""
        if self.clicks is None:
            self.undo()
        elif not self.clicks:
            self.message = "there is no click to take back; Escape leaves"
        else:
            self._click(self.clicks[:-1])

    def redo(self) -> None:
        """Do again what was taken back last; a curve being drawn is not affected."""
        if self.clicks is None:
            super().redo()
        else:
            self.message = "finish the curve first: Enter, or Escape to drop it"

    def leave(self) -> bool:
        """Leave typing, the help, drawing or the selection; False if there is nothing to leave."""
        if self.typed is not None:
            self.typed = None
        elif self.helping:
            self.helping = False
        elif self.clicks is not None:
            self._drop()
        elif self.selected is not None:
            self.select(None)
        else:
            return False
        return True

    def change(self, settings: SnapSettings) -> None:
        """Other settings for the curve that is drawn or selected, and for the next one."""
        if self.clicks is None:
            super().change(settings)
            return
        self.settings = settings
        preview = self._preview
        if preview is not None and settings != preview.settings:
            self._show_preview(replace(preview, settings=settings))

    def delete(self) -> None:
        """Delete the selected curve, or drop the one that is drawn."""
        if self.clicks is None:
            super().delete()
        else:
            self._drop()

    def select(self, key: int | None) -> None:
        """Select a curve; none while one is drawn."""
        if self.clicks is None:
            super().select(key)

    def begin_name(self) -> None:
        """Type another name for the selected curve."""
        curve = self.curve
        if curve is None or self.clicks is not None:
            self.message = "select a curve first: click on it"
        else:
            self.typed = curve.name

    def end_name(self) -> None:
        """The name is as it was typed."""
        if self.typed is not None:
            name, self.typed = self.typed.strip(), None
            self.rename(name)

    def click(self, point: Points | None) -> None:
        """A point (3,) of the model was clicked, or a place beside it."""
        if self.clicks is None:
            self.select(None)
            return
        if point is None:
            self.message = "there is no model under the pointer"
            return
        near = SAME_CLICK * self.model.diagonal
        if self.clicks and np.linalg.norm(point - self.clicks[-1]) <= near:
            self.message = "that point has been clicked already"
            return
        self._click((*self.clicks, point))

    def _click(self, clicks: tuple[Points, ...]) -> None:
        """The curve is drawn through these points."""
        self.clicks = clicks
        if len(clicks) < 2:
            if self._preview is not None:
                self._maker.forget(self._preview.key)
                self._last.pop(self._preview.key, None)
            self._preview = None
            return
        if self._preview is None:
            key, self._next = self._next, self._next + 1
            curve = DrawnCurve(key, self.edits.free_name(), np.stack(clicks), self.settings)
        else:
            curve = replace(self._preview, clicked=np.stack(clicks))
        self._show_preview(curve)

    def _show_preview(self, curve: DrawnCurve) -> None:
        before, self._preview = self._preview, curve
        self._make(curve, before)

    def _drop(self) -> None:
        """Forget the curve that is drawn."""
        if self._preview is not None:
            self._maker.forget(self._preview.key)
        self.clicks = self._preview = None
