"""What the window of retopology shows and how that changes: no window in here."""

from __future__ import annotations

import numpy as np

from viewer.retopo.aiming import CLICK
from viewer.retopo.layout import find_mode_number, find_option_number
from viewer.retopo.pointing import RetopoCamera, pick_line
from viewer.retopo.using import Using


class RetopoState(Using):
    """A network on a ground, tools in use on it, and how it is looked at: what a mouse and a clock
    make of them."""

    def accept(self) -> None:
        """Do what a click at the pointer does."""
        if self.pointer is not None and self._held is None:
            self._click(self.foot)

    def leave(self) -> bool:
        """Escape: let go of what is drawn, leave the help, or drop what waits; False if there is
        nothing of these."""
        left = self.helping or self._held is not None or self.drop_waiting()
        self.helping = False
        self._held = None
        self._let_go()
        return left

    def next_seen(self) -> None:
        """Quads and curves are seen, curves alone, or quads alone."""
        if self.quads_shown and self.curves_shown:
            self.quads_shown = False
        elif self.curves_shown:
            self.quads_shown, self.curves_shown = True, False
        else:
            self.curves_shown = True

    def toggle(self, name: str) -> None:
        """Switch something that is seen or not."""
        setattr(self, name, not getattr(self, name))

    # The pointer, at places of the picture in points from its middle

    def press(self, x: float, y: float, *, turn: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view."""
        self._point(x, y)
        self._pressed, self._strayed = (x, y), False
        if turn:
            self._held, self._pressed = "view", None
            return False
        self.message = ""
        if x > self.room[0] / 2.0:
            return self._press_panel(x, y)
        gesture = self.mode.gesture
        if gesture == "plane":
            self._held = "plane"
        elif self._foot is None:
            self._held = "view"
        elif gesture in ("stroke", "scribble", "within"):
            self._held, self.line = "line", [self._foot.points[0]]
        elif gesture in ("drag", "corner"):
            self._held, self.line = "drag", [self._foot.points[0]]
        else:
            self._held = "click"
        return True

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        last, pressed = self.pointer, self._pressed
        if pressed is not None and np.hypot(x - pressed[0], y - pressed[1]) >= CLICK:
            self._strayed = True
        if self._held in ("view", "click") and last is not None:
            if pressed is not None:
                if not self._strayed:
                    return False
                # What began as a click turns, by all that it has moved.
                last, self._pressed, self._held = pressed, None, "view"
            self.aim(self.view.turned(x - last[0], y - last[1]))
            self.pointer = (x, y)
            return True
        self._point(x, y)
        if self._held == "line" and last is not None:
            self.line.extend(pick_line(self.view, self.ground, last, (x, y)))
        self._seek()
        return True

    def release(self, x: float, y: float) -> bool:
        """The button comes up: what was drawn is done, or it was a click."""
        held, pressed = self._held, self._pressed
        if pressed is not None:
            self.move(x, y)
            held = self._held
        self._point(x, y)
        # A line may end where it began.
        still = pressed is not None and not self._strayed
        line = self.line
        self._held = self._pressed = None
        self._let_go()
        if held == "plane" and pressed is not None:
            self._cut(pressed, (x, y))
        elif held == "drag":
            self._dragged(line[0], still)
        elif held == "line" and not still:
            self._drawn(line)
        elif held in ("line", "click") and still:
            self._click(self._foot)
        self._seek()
        return True

    def wheel(self, steps: float, *, shift: bool = False, modifier: bool = False) -> bool:
        """The wheel turns: nearer or farther off; with a modifier, or in the mode of counts on a
        curve, it changes the curve's edges, with shift those of its strip."""
        counts = modifier or shift or self.mode.gesture == "count"
        if counts and self.chain_under() is not None:
            self.message = ""
            self.count(1 if steps > 0.0 else -1, whole_strip=shift)
            return True
        if self.holding:
            return False
        RetopoCamera.wheel(self, steps)
        self._seek()
        return True

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        return not self.holding and RetopoCamera.drag_view(self, dx, dy)

    # The clock

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        new = self.take()
        if new:
            self._seek()
        new |= self.tick()
        before = self.preview
        self._take_preview()
        return new or self.preview is not before

    def settle(self) -> None:
        """Wait for all that was asked for."""
        self._work.wait()
        self.take()
        self._seek()
        self._work.lists.wait()
        self.take()
        self._latest.wait()
        self._take_preview()

    # How it is done

    def _press_panel(self, x: float, y: float) -> bool:
        self._held = None
        left, at = self.room[0], (x + self.room[0] / 2.0, y + self.room[1] / 2.0)
        row = find_mode_number(left, *at, len(self.modes))
        if row is not None:
            self._choose(self.modes[row])
        chosen = find_option_number(left, *at, len(self.modes), len(self.mode.options))
        if chosen is not None:
            self._turn(self.mode.options[chosen])
        return True
