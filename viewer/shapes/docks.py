"""The window of the viewer of shape models: the shell of all windows, with a slider a mode."""

from __future__ import annotations

from patterndb_sketch.features.shapemodel.shaping import HOLD, SIGMAS, STIFF
from viewer.shapes.state import ShapesState
from viewer.shell.docks import Dock, SliderPanel, SliderRow
from viewer.shell.window import ShellWindow
from viewer.slider import Slider

HOLDING = Slider("weight of held curves", *HOLD, digits=2)
STIFFENING = Slider("keep the present shape", *STIFF, digits=2)

#: What is said of a mode that is at a limit of pulls, or beyond.
LIMITS = {0: "", 1: " (at its limit)", 2: " (beyond the training shapes)"}


class ShapesWindow(ShellWindow):
    """Shows a shape, with what it is made of."""

    state: ShapesState

    def make_docks(self) -> list[Dock]:
        """Make the docks of modes, and of what pulls keep."""
        modes = Dock("Modes", self)
        count = self.state.shaping.shapes.n_modes
        self.modes = SliderPanel([self._mode_row(mode) for mode in range(count)], self.show_change)
        modes.show_scrolled(self.modes)
        pulls = Dock("Pulls", self)
        shaping = self.state.shaping
        self.pulls = SliderPanel(
            [
                SliderRow(
                    HOLDING, lambda: shaping.choice.hold, shaping.set_hold,
                    shaping.begin, shaping.finish, lambda: bool(shaping.choice.held),
                    "What held curves weigh in the next pulls",
                ),
                SliderRow(
                    STIFFENING, lambda: shaping.choice.stiffness, shaping.set_stiffness,
                    shaping.begin, shaping.finish,
                    tip="What it costs the next pulls to leave the present shape",
                ),
            ],
            self.show_change,
        )  # fmt: skip
        pulls.show_scrolled(self.pulls)
        return [modes, pulls]

    def _mode_row(self, mode: int) -> SliderRow:
        shaping = self.state.shaping
        share = f"{100.0 * shaping.shapes.shares[mode]:.3g} %"
        low, high = (float(end[mode]) for end in shaping.box)
        return SliderRow(
            Slider(f"mode {mode + 1}: {share}", -SIGMAS, SIGMAS, step=0.01, unit=" σ"),
            lambda: round(float(shaping.sigmas[mode]), 2),
            lambda value: self._set_mode(mode, value),
            shaping.begin,
            shaping.finish,
            tip=f"Mode {mode + 1}, in standard deviations; it has {share} of the variance. "
            f"Pulls keep it from {low:.2f} to {high:.2f}, as the training shapes do",
            note=lambda: LIMITS[abs(int(shaping.limits[mode]))],
            chosen=lambda: self.state.chosen == mode,
        )

    def _set_mode(self, mode: int, value: float) -> None:
        self.state.chosen = mode
        self.state.shaping.set_mode(mode, value)

    def refresh_docks(self) -> None:
        """Show the modes and what pulls keep as they are now."""
        self.modes.refresh()
        self.pulls.refresh()
