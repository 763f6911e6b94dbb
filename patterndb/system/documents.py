"""Strict reading of JSON: every value knows its place, and what is wrong is said with it.

    document = parse_json(data, InvalidNetworkError, "a network")
    entries = document.entries(("curves", "tolerance"))
    for curve in entries["curves"].items():
        curve.polyline()            # InvalidNetworkError: curves[2][0][1]: "x" is not a number

Refused: entries that are there twice, NaN and Infinity, and nesting beyond what Python reads.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, cast

from patterndb.errors import PatternDBError

#: The most characters of a value that a message repeats.
SHOWN = 40


@dataclass(frozen=True, slots=True)
class JsonValue:
    """A value in a JSON document, and where it stands.

    value: as the json module gives it: None, bool, int, float, str, list or dict.
    where: its place, such as "curves[2].points"; empty for the whole document.
    error: what is raised about it.
    """

    value: object
    where: str
    error: type[PatternDBError]

    @property
    def is_object(self) -> bool:
        """Is it an object, with entries?"""
        return isinstance(self.value, dict)

    @property
    def is_list(self) -> bool:
        """Is it a list?"""
        return isinstance(self.value, list)

    def entries(
        self, known: Iterable[str] | None = None, wanted: str = "an object"
    ) -> dict[str, JsonValue]:
        """The entries of an object; raises ``error`` for any but the known ones, None: all."""
        if not self.is_object:
            self.refuse(wanted)
        found = cast("dict[str, object]", self.value)
        prefix = f"{self.where}." if self.where else ""
        keys = None if known is None else tuple(known)
        for key in found:
            if keys is not None and key not in keys:
                raise self.error(
                    f"{prefix}{_shown(key)[1:-1]}: there is no such entry; entries are "
                    f"{', '.join(keys)}"
                )
        return {key: JsonValue(value, prefix + key, self.error) for key, value in found.items()}

    def items(self, wanted: str = "a list") -> list[JsonValue]:
        """The items of a list."""
        if not self.is_list:
            self.refuse(wanted)
        found = cast("list[object]", self.value)
        return [JsonValue(item, f"{self.where}[{i}]", self.error) for i, item in enumerate(found)]

    def number(self) -> float:
        """A finite number."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse("a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.refuse("a finite number")
        return number

    def whole(self, wanted: str = "a whole number") -> int:
        """A whole number, also one that is written 3.0."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float) or value % 1:
            self.refuse(wanted)
        return int(value)

    def truth(self) -> bool:
        """True or false."""
        if not isinstance(self.value, bool):
            self.refuse("true or false")
        return self.value

    def text(self, wanted: str = "a text") -> str:
        """A text."""
        if not isinstance(self.value, str):
            self.refuse(wanted)
        return self.value

    def name(self, wanted: str = "a name: a whole number or a text") -> int | str:
        """A whole number or a text, as names are."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | str):
            self.refuse(wanted)
        return self.value

    def point(self) -> list[float]:
        """A point [x, y, z]; z is 0 where it is left out."""
        numbers = self.items("a point [x, y, z]")
        if len(numbers) not in (2, 3):
            self.refuse("a point [x, y, z]")
        place = [x.number() for x in numbers]
        return [*place, 0.0] if len(place) == 2 else place

    def points(self) -> list[list[float]]:
        """A list of points, maybe empty, as :meth:`point` has them."""
        return [point.point() for point in self.items()]

    def polyline(self) -> list[list[float]]:
        """Two points or more, as :meth:`point` has them."""
        points = self.points()
        if len(points) < 2:
            self.fail("a polyline needs two points or more")
        return points

    def refuse(self, wanted: str) -> NoReturn:
        """Raise ``error``: the value is not what is wanted."""
        self.fail(f"{_shown(self.value)} is not {wanted}")

    def fail(self, message: str) -> NoReturn:
        """Raise ``error`` with the place before the message."""
        raise self.error(f"{self.where}: {message}" if self.where else message)


def parse_json(data: bytes | str, error: type[PatternDBError], what: str) -> JsonValue:
    """The document in JSON text or its bytes.

    what: what it should hold, such as "a boundary", for messages. Raises ``error`` with line
    and column for text that is no JSON, and for what strict reading refuses.
    """

    def entries(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for i, key in enumerate(keys) if key in keys[:i])
            raise error(f"the entry {_shown(twice)} is there twice")
        return found

    def constant(name: str) -> NoReturn:
        raise error(f"{name} is no number that JSON has; every number must be finite")

    try:
        value = json.loads(data, object_pairs_hook=entries, parse_constant=constant)
    except json.JSONDecodeError as reason:
        raise error(
            f"line {reason.lineno}, column {reason.colno}: this is no JSON: {reason.msg}"
        ) from None
    except UnicodeDecodeError as reason:
        raise error(f"byte {reason.start}: this is no JSON: the text is not UTF-8") from None
    except RecursionError:
        raise error(f"this is nested deeper than {what} is") from None
    except PatternDBError:
        raise
    except ValueError as reason:
        # A whole number of more digits than Python reads.
        raise error(f"this is no JSON that can be read: {reason}") from None
    return JsonValue(value, "", error)


def read_limited(path: Path, max_bytes: int, error: type[PatternDBError], mending: str) -> bytes:
    """The content of a file; raises ``error`` if it has more bytes, OSError as reading does.

    mending: what would make it smaller, for the message, such as "give fewer points".
    """
    with path.open("rb") as file:
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise error(f"the file is larger than {max_bytes:,} bytes; {mending}")
    return data


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = json.dumps(value)
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"
