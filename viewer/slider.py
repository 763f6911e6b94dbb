"""A number that is chosen between two ends, and where it is on a line."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Slider:
    """A number that is chosen between two ends.

    label:  its name. low, high: the ends, low below high.
    step:   the value is rounded to multiples of it.
    digits: on a logarithmic scale, where equal ways multiply by equal factors and low is above
            0, it is rounded to so many digits that count instead; 0 for a linear scale.
    power:  on a linear scale, places of the line go by this root of the value's share.
    unit:   of the value. ends: what the ends mean.

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
