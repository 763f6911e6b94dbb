"""What the viewer's keys choose, and the way back: all that needs no pointer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from patterndb_sketch.features.registration import DrawnNetwork
from patterndb_sketch.features.snap import SnapSettings
from viewer.features.layout import AXIS_OF, DEGREES, RAILS, get_slider_value
from viewer.features.work import FeatureFiles, Work


class Choices(Work):
    """Curves selected, named, deleted, changed, and saved.

    The arguments are those of :class:`viewer.features.work.Work`.
    """

    def toggle(self, name: str) -> None:
        """Turn one of the switches, such as ribs_shown."""
        setattr(self, name, not getattr(self, name))
        self.ask_snap(self.curve)

    def select(self, key: int | None) -> None:
        """Select a curve."""
        self.selected = key
        self.ask_snap(self.curve)

    def select_next(self, by: int) -> None:
        """The next curve, or the one before; from the last on to the first."""
        keys = [curve.key for curve in self.edits.curves]
        if not keys:
            self.message = "there is no curve yet"
            return
        if self.selected in keys:
            self.select(keys[(keys.index(self.selected) + by) % len(keys)])
        else:
            self.select(keys[0 if by > 0 else -1])

    def delete(self) -> None:
        """Delete the selected curve."""
        curve = self.curve
        if curve is None:
            self.message = "select a curve first: click on it"
            return
        self._step(self.edits.without(curve.key))
        self.selected = None

    def rename(self, name: str) -> None:
        """Give the selected curve another name."""
        curve = self.curve
        if curve is None or name == curve.name:
            return
        if not name:
            self.message = "a curve needs a name"
        elif any(one.name == name for one in self.edits.curves):
            self.message = f"there is another curve {name!r}"
        else:
            self._revise(replace(curve, name=name))

    def snap_again(self) -> None:
        """One more round: ribs about the selected curve as it is now."""
        curve = self.curve
        if curve is None:
            self.message = "select a curve first: click on it"
        else:
            self._revise(replace(curve, again=curve.again + 1))

    def change_degree(self, by: int) -> None:
        """A higher or a lower degree of the spline."""
        settings = self.shown_settings
        degree = min(max(settings.degree + by, DEGREES[0]), DEGREES[1])
        if degree == settings.degree:
            self.message = f"the degree is from {DEGREES[0]} to {DEGREES[1]}"
        else:
            self.change(replace(settings, degree=degree))

    def choose_axis(self, name: str) -> None:
        """The axis, by its name, that normals are measured from."""
        settings = self.shown_settings
        if settings.alpha == 1.0:
            self.message = "alpha is 1, so that angles do not count; make it less"
        self.change(replace(settings, axis=AXIS_OF[name]))

    def slide(self, name: str, by: float) -> None:
        """Move a slider by a part of its length."""
        slider = RAILS[name].slider
        self.change(replace_value(self.shown_settings, name, slider.moved(
            get_slider_value(self.shown_settings, name), by
        )))  # fmt: skip

    def change(self, settings: SnapSettings) -> None:
        """Other settings for the selected curve, and for the next one."""
        self.settings = settings
        curve = self.curve
        if curve is not None and settings != curve.settings:
            self._revise(replace(curve, settings=settings))

    def undo(self) -> None:
        """Take the last step back."""
        self._turn(self._past, self._future, "there is nothing to take back")

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._turn(self._future, self._past, "there is nothing to do again")

    def save_session(self) -> None:
        """Save all curves, once they are what was asked for."""
        if self._saved_by(lambda files: files.save_session(self.session())):
            self._saved = self.edits

    def save_network(self) -> None:
        """Save the curves as a network, which templates are laid on."""
        self._saved_by(
            lambda files: files.save_network(
                DrawnNetwork({name: look.spline for name, look in self.made().items()})
            )
        )

    def save_lines(self) -> None:
        """Save the curves as lines, for other programs."""
        self._saved_by(
            lambda files: files.save_lines({name: one.line for name, one in self.made().items()})
        )

    def _saved_by(self, save: Callable[[FeatureFiles], str]) -> bool:
        self.settle()
        if self._files is None:
            self.message = "nothing can be saved here: no way to write files was given"
            return False
        try:
            self.message = save(self._files)
        except OSError as error:
            self.message = f"not saved: {error}"
            return False
        made = self.made()
        lost = [curve.name for curve in self.edits.curves if curve.name not in made]
        if lost:
            self.message += f", without what could not be made: {', '.join(lost)}"
        return True


def replace_value(settings: SnapSettings, name: str, value: float) -> SnapSettings:
    """Settings after a slider was moved to a value."""
    if name == "angle":
        return replace(settings, beta=float(np.deg2rad(value)))
    if name == "alpha":
        return replace(settings, alpha=value)
    return replace(settings, stiffness=value)
