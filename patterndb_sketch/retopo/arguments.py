"""Arguments of tools: what a call may say, and what it means.

A call is plain data, numbers, words and lists, so that a window, a script and a test say the
same thing in the same way. Every argument has a kind, which reads it or says what is wrong.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

import numpy as np
from msgspec.inspect import BoolType, FloatType, IntType

from patterndb.geometry.points import Points
from patterndb.system.requests import Request, list_options
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: Points of a stroke, at most: more is a mistake, and would be sampled down anyway.
MOST_POINTS = 100_000

#: The least of numbers that must be above 0.
LEAST_ABOVE_ZERO = 1e-12


class Kind(Protocol):
    """Reads a value; raises InvalidRetopoError with what is expected, beginning with ``name``."""

    def read(self, name: str, value: object) -> Any: ...

    @property
    def wanted(self) -> str: ...


@dataclass(frozen=True, slots=True)
class Number:
    """A number from ``low`` to ``high``; whole if so."""

    low: float = -math.inf
    high: float = math.inf
    whole: bool = False

    @property
    def wanted(self) -> str:
        what = "a whole number" if self.whole else "a number"
        if math.isinf(self.low) and math.isinf(self.high):
            return what
        if math.isinf(self.high):
            return f"{what} from {self.low:g} on"
        return f"{what} from {self.low:g} to {self.high:g}"

    def read(self, name: str, value: object) -> float | int:
        number = None if isinstance(value, bool) else _read_finite(value)
        if (
            number is not None
            and self.low <= number <= self.high
            and not (self.whole and number != int(number))
        ):
            return int(number) if self.whole else number
        raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")


@dataclass(frozen=True, slots=True)
class Word:
    """One of some words."""

    words: tuple[str, ...]

    @property
    def wanted(self) -> str:
        return "one of " + ", ".join(f'"{word}"' for word in self.words)

    def read(self, name: str, value: object) -> str:
        if value in self.words and isinstance(value, str):
            return value
        raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")


@dataclass(frozen=True, slots=True)
class WordOrNumber:
    """One of some words, or a number."""

    words: tuple[str, ...]
    number: Number

    @property
    def wanted(self) -> str:
        return ", ".join(f'"{word}"' for word in self.words) + f", or {self.number.wanted}"

    def read(self, name: str, value: object) -> str | float | int:
        if isinstance(value, str):
            if value in self.words:
                return value
        else:
            try:
                return self.number.read(name, value)
            except InvalidRetopoError:
                pass
        raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")


@dataclass(frozen=True, slots=True)
class Flag:
    """true or false."""

    wanted: str = "true or false"

    def read(self, name: str, value: object) -> bool:
        if isinstance(value, bool):
            return value
        raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")


@dataclass(frozen=True, slots=True)
class Vector:
    """Three numbers; a direction, of any length, if it may not be 0."""

    direction: bool = False

    @property
    def wanted(self) -> str:
        return "[x, y, z]" + (", not all 0" if self.direction else "")

    def read(self, name: str, value: object) -> Points:
        items = _read_items(value)
        if items is not None and len(items) == 3:
            row = [_read_finite(one) for one in items]
            if None not in row:
                found = np.array(row, np.float64)
                if not self.direction:
                    return found
                if found.any():
                    # By a power of two, exactly, so that no length overflows or vanishes.
                    return np.ldexp(found, -int(np.frexp(np.abs(found).max())[1]))
        raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")


@dataclass(frozen=True, slots=True)
class PointList:
    """At least ``fewest`` points."""

    fewest: int = 2

    @property
    def wanted(self) -> str:
        return f"{self.fewest} points [x, y, z] or more"

    def read(self, name: str, value: object) -> Points:
        rows = _read_items(value)
        if rows is None:
            raise InvalidRetopoError(f"{name} is {_shorten_repr(value)}; give {self.wanted}")
        if not self.fewest <= len(rows) <= MOST_POINTS:
            raise InvalidRetopoError(
                f"{name} has {len(rows)} points; give {self.wanted}, at most {MOST_POINTS}"
            )
        vector = Vector()
        return np.array([vector.read(f"{name}[{k}]", row) for k, row in enumerate(rows)])


@dataclass(frozen=True, slots=True)
class Argument:
    """What a tool may be told.

    kind: what it may be. help: what it means, for lists of tools. default: what it is where it is
    left out; REQUIRED if it may not be. option: may a window offer it as an option of its own? Not
    what a gesture or a key of the window says already.
    """

    kind: Kind
    help: str
    default: object = field(default_factory=lambda: REQUIRED)
    option: bool = True

    def describe(self) -> str:
        """What it means, what it may be, and what it is if it is left out, in a line."""
        wanted = self.kind.wanted.replace(f"from {LEAST_ABOVE_ZERO:g} on", "above 0")
        said = f"{self.help}: {wanted}"
        if self.default is REQUIRED:
            return f"{said}. Required"
        return said if self.default is None else f"{said}. Default: {json.dumps(self.default)}"


REQUIRED = object()

#: What most tools are told: a place, and a stroke.
AT = Argument(Vector(), "a point of the surface")
NEAR_CURVE = Argument(Vector(), "a point near the curve, or its corner")
POINTS = Argument(PointList(), "the stroke, on the surface")


def optional_length(what: str) -> Argument:
    """An argument that is a length, and may be left out; what: it is of, for its help."""
    return Argument(Number(LEAST_ABOVE_ZERO), f"{what}, in the surface's unit", None)


def list_arguments(request: type[Request]) -> dict[str, Argument]:
    """Return the options of a request as arguments of a tool."""
    found: dict[str, Argument] = {}
    for name, one in list_options(request).items():
        kind: Kind
        if isinstance(one.type, BoolType):
            kind = Flag()
        elif isinstance(one.type, IntType | FloatType):
            low, high = one.type.ge, one.type.le
            low = (LEAST_ABOVE_ZERO if one.type.gt == 0 else -math.inf) if low is None else low
            kind = Number(low, math.inf if high is None else high, isinstance(one.type, IntType))
            kind = WordOrNumber(one.choices, kind) if one.choices else kind
        else:
            kind = Word(one.choices)
        help = one.text.help
        found[name] = Argument(kind, help[0].lower() + help[1:].removesuffix("."), one.default)
    return found


def read_arguments(
    tool: str, known: Mapping[str, Argument], given: Mapping[str, object]
) -> dict[str, Any]:
    """The arguments of a call by name, those left out at their defaults.

    Raises InvalidRetopoError for a name that the tool does not know, one that is missing, and
    for values that are not what they must be.
    """
    for name in given:
        if name not in known:
            there = ", ".join(known) or "none"
            raise InvalidRetopoError(f"{tool} has no argument {name!r}; there are {there}")
    found: dict[str, Any] = {}
    for name, argument in known.items():
        if name in given:
            found[name] = argument.kind.read(f"{tool}: {name}", given[name])
        elif argument.default is REQUIRED:
            raise InvalidRetopoError(f"{tool} needs {name}: {argument.kind.wanted}")
        else:
            found[name] = argument.default
    return found


def _read_finite(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.floating | np.integer):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _read_items(value: object) -> Sequence[object] | None:
    """The items of a list; None if it is none."""
    if isinstance(value, np.ndarray):
        return cast("Sequence[object]", value) if value.ndim else None
    return cast("Sequence[object]", value) if isinstance(value, list | tuple) else None


def _shorten_repr(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
