"""A slider as part of a picture: a number between two ends, chosen with the pointer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.nearness import SLIDER_GRIP
from viewer.scene import Scene

Name = TypeVar("Name")

#: Half the height of the line, and radius of the knob, in points.
HALF_LINE, KNOB = 2.0, 8.0

#: Heights of the texts from the line, in points: label and value, and what the ends mean.
LABEL_UP, ENDS_DOWN = 18.0, 23.0

#: Height that a slider with its texts takes, in points.
ROOM = 64.0

TRACK = "#d3d9e1"
FILLED = "#5d7ea6"
HALO = "#dfe8f3"

#: What lies about the knob, from outside in: how much wider, how far down, and its colour.
SHADOW = ((2.4, -1.2, "#f1f3f6"), (1.5, -0.9, "#e2e6eb"), (0.7, -0.5, "#ccd2da"))


@dataclass(frozen=True, slots=True)
class Slider:
    """A number that is chosen between two ends.

    label:  written above the line. low, high: the ends, low below high.
    step:   the value is rounded to multiples of it.
    digits: on a logarithmic scale, where equal ways multiply by equal factors and low is above
            0, it is rounded to so many digits that count instead; 0 for a linear scale.
    power:  on a linear scale, places of the line go by this root of the value's share.
    unit:   written after the value. ends: what the ends mean, written below them.

    Raises ValueError for ends that are none.
    """

    label: str
    low: float
    high: float
    step: float = 0.01
    digits: int = 0
    unit: str = ""
    ends: tuple[str, str] = ("", "")
    power: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"{self.label}: from {self.low} to {self.high} is no range")
        if self.digits > 0 and self.low <= 0.0:
            raise ValueError(f"{self.label}: a logarithmic range begins above 0, not {self.low}")
        if self.digits < 0 or self.step <= 0.0:
            raise ValueError(f"{self.label}: give a step above 0, and no negative digits")

    @property
    def decimals(self) -> int:
        """Digits behind the point that tell all values apart; on a logarithmic scale, at its
        lower end."""
        if self.digits:
            return max(0, self.digits - 1 - math.floor(math.log10(self.low)))
        return max(0, -math.floor(math.log10(self.step) + 1e-9))

    def share(self, value: float) -> float:
        """Where a value is on the line, 0 to 1 from left to right."""
        value = min(max(value, self.low), self.high)
        if self.digits:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return float(((value - self.low) / (self.high - self.low)) ** (1.0 / self.power))

    def value(self, share: float) -> float:
        """The value at a place of the line, rounded; the ends beyond it."""
        share = min(max(share, 0.0), 1.0)
        if self.digits:
            raw = self.low * (self.high / self.low) ** share
            raw = float(f"{raw:.{self.digits}g}")
        else:
            raw = self.low + share**self.power * (self.high - self.low)
            # Divided rather than multiplied, 0.3 in steps of 0.1 is written 0.3.
            raw = round(raw / self.step) / (1.0 / self.step)
        return min(max(raw, self.low), self.high)

    def moved(self, value: float, by: float) -> float:
        """The value after the knob went on by a part of the line; it does not stick at a step."""
        after = self.value(self.share(value) + by)
        if after != value or by == 0.0:
            return after
        if self.digits:
            step = 10.0 ** (math.floor(math.log10(value)) + 1 - self.digits)
        else:
            step = self.step
        return min(max(value + math.copysign(step, by), self.low), self.high)

    def text(self, value: float) -> str:
        """The value as it is written."""
        if self.digits:
            return f"{value:.{self.digits}g}{self.unit}"
        return f"{value:.{self.decimals}f}{self.unit}".replace("-", "\N{MINUS SIGN}")


@dataclass(frozen=True, slots=True)
class Rail:
    """A slider's place in a picture: its line from left to right at height y, in points from
    the picture's lower left."""

    slider: Slider
    left: float
    right: float
    y: float

    def shifted(self, dx: float, dy: float) -> Rail:
        """The same elsewhere."""
        return Rail(self.slider, self.left + dx, self.right + dx, self.y + dy)

    def holds(self, x: float, y: float) -> bool:
        """Is a place of the picture on the slider?"""
        return (
            self.left - SLIDER_GRIP <= x <= self.right + SLIDER_GRIP
            and abs(y - self.y) <= SLIDER_GRIP
        )

    def knob(self, value: float) -> float:
        """The x of the knob."""
        return self.left + (self.right - self.left) * self.slider.share(value)

    def value_at(self, x: float) -> float:
        """The value that a pointer at x means."""
        return self.slider.value((x - self.left) / (self.right - self.left))

    def paint(
        self,
        scene: Scene,
        value: float,
        *,
        hot: bool = False,
        enabled: bool = True,
        mark: float | None = None,
    ) -> None:
        """Paint it with its texts.

        hot: the pointer is on it, or holds it. enabled: else it is grey, and says nothing of
        its value. mark: a value that is marked on the line, such as what it is by default.
        """
        slider, grey = self.slider, style.FAINT_TEXT
        strong = style.TEXT if enabled else grey
        up = self.y + LABEL_UP
        scene.text(self.left - 6.0, up, slider.label, 13.0, colour=strong, bold=True, align="left")
        if enabled:
            text = slider.text(value)
            scene.text(self.right + 6.0, up, text, 13.0, colour=strong, align="right")
        for text, x, align in (
            (slider.ends[0], self.left - 6.0, "left"),
            (slider.ends[1], self.right + 6.0, "right"),
        ):
            if text:
                scene.text(x, self.y - ENDS_DOWN, text, 10.5, colour=grey, align=align)
        at = self.knob(value)
        scene.polygons(_bar(self.left, self.right, self.y, HALF_LINE), face=TRACK)
        if not enabled:
            return
        # The part up to the knob counts from the mark, if there is one.
        start = self.left if mark is None else self.knob(mark)
        low, high = min(start, at), max(start, at)
        if high - low > 2.0 * HALF_LINE:
            scene.polygons(_bar(low, high, self.y, HALF_LINE), face=FILLED)
        if mark is not None:
            scene.polygons(_bar(start, start, self.y, 1.7 * HALF_LINE), face=FILLED)
        if hot:
            scene.polygons(_disc(at, self.y, KNOB + 5.5), face=HALO)
        for wider, down, colour in SHADOW:
            scene.polygons(_disc(at, self.y + down, KNOB + wider), face=colour)
        scene.polygons(_disc(at, self.y, KNOB), face=FILLED if hot else style.BOUNDARY)
        scene.polygons(_disc(at, self.y, 0.42 * KNOB), face=style.PAPER)


def find_rail(rails: Mapping[Name, Rail], x: float, y: float) -> Name | None:
    """Find the name of the slider at a place of the picture, the nearest of several; None
    without."""
    near = [(abs(y - rail.y), i) for i, rail in enumerate(rails.values()) if rail.holds(x, y)]
    return list(rails)[min(near)[1]] if near else None


def _disc(x: float, y: float, radius: float) -> Points:
    return (style.make_circle() * radius + (x, y))[None]


def _bar(left: float, right: float, y: float, half: float) -> Points:
    """(1, c, 2) a line with round ends, which may be a dot."""
    rim = style.make_circle() * half
    ends = np.where(rim[:, :1] > 0.0, right, left)
    return (rim + np.concatenate([ends, np.full((len(rim), 1), y)], axis=1))[None]
