"""The one reader of JSON: a document is declared as types, and what is wrong in it names its place.

    class Drawing(JsonModel):
        curves: Annotated[list[Polyline], Meta(extra={"missing": "a list of polylines"})]
        tolerance: Number | UnsetType = UNSET

    drawing = parse_json(data, InvalidNetworkError, "a network").read(Drawing)
    # InvalidNetworkError: curves[2][0][1]: "x" is not a number

msgspec reads what is right. What is not, it says in words of its own, with "..." for the names of
an object's entries, and it takes entries that are there twice: :func:`_mend` walks wrong values
again for their places, and the text itself is read by the json module.

Refused: entries that are there twice, NaN and Infinity, and nesting beyond what Python reads.
Entries that no type declares are refused, too. Whole numbers may be written 3.0.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NoReturn, TypeVar, cast, get_args, get_origin, overload

import numpy as np
from msgspec import Meta, Struct, ValidationError, convert, inspect, to_builtins
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb.system.files import explain_compression, open_regular

T = TypeVar("T")

#: The most characters of a value that a message repeats.
SHOWN = 40

#: The most numbers of an array that a packed document has as a list.
LONGEST_LIST = 64


class JsonModel(Struct, forbid_unknown_fields=True):
    """An object with the entries that a subclass declares; those with a default may be left out.

    Meta(description=...) of a type: what a value is not, for messages. Of an entry,
    Meta(extra={"missing": ...}): what it should have been; of a list,
    Meta(extra={"length": ...}): what it lacks where it is too short or too long.
    """


#: Types to declare entries by, beside bool, int, str, lists of them and subclasses of JsonModel.
Number = Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
Name = Annotated[int | str, Meta(description="a name: a whole number or a text")]
Point = Annotated[
    list[Number], Meta(min_length=2, max_length=3, description="a point [x, y, z]")
]  #: z is 0 where it is left out: see :func:`complete_points`.
Pair = Annotated[list[int], Meta(min_length=2, max_length=2, description="a pair of whole numbers")]
Polyline = Annotated[
    list[Point], Meta(min_length=2, extra={"length": "a polyline needs two points or more"})
]


def complete_points(points: Iterable[list[float]]) -> list[list[float]]:
    """Points (n, 3) with a z of 0 where it was left out."""
    return [point if len(point) == 3 else [*point, 0.0] for point in points]


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

    @overload
    def read(self, kind: type[T], wanted: str = "") -> T: ...
    @overload
    def read(self, kind: Any, wanted: str = "") -> Any: ...
    def read(self, kind: Any, wanted: str = "") -> Any:
        """Return the value as a declared type; raises ``error`` that names the place in it.

        wanted: what the value itself should be, for the message.
        """
        try:
            return convert(self.value, kind, dec_hook=_read_array)
        except ValidationError:
            return self._convert(_mend(self, inspect.type_info(kind), wanted), kind)
        except RecursionError:
            self.fail("this is nested too deep")

    def _convert(self, mended: object, kind: Any) -> Any:
        try:
            return convert(mended, kind, dec_hook=_read_array)
        except ValidationError as reason:
            message, _, path = str(reason).partition(" - at `$")
            where = (self.where + path.rstrip("`")).removeprefix(".")
            JsonValue(None, where, self.error).fail(message)

    def at(self, *steps: str | int) -> JsonValue:
        """Return what stands at a place within: names of entries and numbers of items."""
        value, where = self.value, self.where
        for step in steps:
            value = cast("Any", value)[step]
            where += f"[{step}]" if isinstance(step, int) else f".{step}" if where else step
        return JsonValue(value, where, self.error)

    def entries(
        self, known: Iterable[str] | None = None, wanted: str = "an object"
    ) -> dict[str, JsonValue]:
        """Return the entries of an object; raises ``error`` for any but the known, None: all."""
        if not self.is_object:
            self.refuse(wanted)
        found = cast("dict[str, object]", self.value)
        keys = tuple(found if known is None else known)
        for key in found if known is not None else ():
            if key not in keys:
                prefix = f"{self.where}." if self.where else ""
                raise self.error(
                    f"{prefix}{_shown(key)[1:-1]}: there is no such entry; entries are "
                    f"{', '.join(keys)}"
                )
        return {key: self.at(key) for key in found}

    def items(self, wanted: str = "a list") -> list[JsonValue]:
        """Return the items of a list."""
        if not self.is_list:
            self.refuse(wanted)
        found = cast("list[object]", self.value)
        return [JsonValue(one, f"{self.where}[{i}]", self.error) for i, one in enumerate(found)]

    def number(self) -> float:
        """Return a finite number."""
        return self.read(Number)

    def whole(self, wanted: str = "") -> int:
        """Return a whole number, also one that is written 3.0."""
        return self.read(int, wanted)

    def truth(self) -> bool:
        """Return true or false."""
        return self.read(bool)

    def text(self, wanted: str = "") -> str:
        """Return a text."""
        return self.read(str, wanted)

    def point(self) -> list[float]:
        """Return a point [x, y, z]; z is 0 where it is left out."""
        return complete_points([self.read(Point)])[0]

    def points(self) -> list[list[float]]:
        """Return a list of points, maybe empty, as :meth:`point` has them."""
        return complete_points(self.read(list[Point]))

    @contextmanager
    def named(self) -> Generator[None]:
        """Name the place before what goes wrong inside, where that does not name it already."""
        try:
            yield
        except PatternDBError as reason:
            message, where = str(reason), self.where
            named = message.startswith((f"{where}:", f"{where}.", f"{where}["))
            if named and isinstance(reason, self.error):
                raise
            raise self.error(f"{where}: {message}" if where else message) from None

    def refuse(self, wanted: str) -> NoReturn:
        """Raise ``error``: the value is not what is wanted."""
        self.fail(f"{_shown(self.value)} is not {wanted}")

    def fail(self, message: str) -> NoReturn:
        """Raise ``error`` with the place before the message."""
        raise self.error(f"{self.where}: {message}" if self.where else message)


def parse_json(data: bytes | str, error: type[PatternDBError], what: str) -> JsonValue:
    """Parse JSON text or its bytes; the document is returned.

    what: what it should hold, such as "a boundary", for messages. Raises ``error`` with line
    and column for text that is not JSON, and for what strict reading refuses.
    """

    def entries(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            seen: set[str] = set()
            for key, _ in pairs:
                if key in seen:
                    raise error(f"the entry {_shown(key)} is there twice")
                seen.add(key)
        return found

    def constant(name: str) -> NoReturn:
        raise error(f"{name} is no number that JSON has; every number must be finite")

    packed = explain_compression(data) if isinstance(data, bytes) else None
    if packed is not None:
        raise error(packed)
    if not data.strip():
        raise error(f"this is empty; it should hold {what}")
    try:
        value = json.loads(data, object_pairs_hook=entries, parse_constant=constant)
    except json.JSONDecodeError as reason:
        raise error(
            f"line {reason.lineno}, column {reason.colno}: this is not JSON: {reason.msg}"
        ) from None
    except UnicodeDecodeError as reason:
        raise error(f"byte {reason.start}: this is not JSON: the text is not UTF-8") from None
    except RecursionError:
        raise error(f"this is nested deeper than {what} is") from None
    except PatternDBError:
        raise
    except ValueError as reason:
        # A whole number of more digits than Python reads.
        raise error(f"this is not JSON that can be read: {reason}") from None
    half = _find_half_character(data)
    if half is not None:
        raise error(
            f"{half} is half a character: in \\u escapes one of \\ud800 to \\udbff and one of "
            "\\udc00 to \\udfff belong together"
        )
    return JsonValue(value, "", error)


def read_limited(path: Path, max_bytes: int, error: type[PatternDBError], mending: str) -> bytes:
    """Return the content of a regular file.

    Raises ``error`` if it has more bytes, OSError as :func:`patterndb.system.files.open_regular`.

    mending: what would make it smaller, for the message, such as "give fewer points".
    """
    with open_regular(path) as file:
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise error(f"the file is larger than {max_bytes:,} bytes; {mending}")
    return data


@dataclass(frozen=True, slots=True)
class _PackedArray:
    """An array in a document: its type as NumPy names it, little-endian, its shape, its bytes."""

    dtype: str
    shape: list[Annotated[int, Meta(ge=0)]]
    base64: bytes


def encode_json(value: object, *, packed: bool = False) -> bytes:
    """Return the JSON text of structs, dataclasses and arrays, which :meth:`JsonValue.read` reads.

    Arrays are lists; packed: those of more than :data:`LONGEST_LIST` numbers are {"dtype": "<f8",
    "shape": [n, 3], "base64": "..."}, which is read and written 20 times as fast. Numbers are read
    back bit for bit.
    """

    def encode_array(array: object) -> object:
        if not isinstance(array, np.ndarray):
            raise NotImplementedError(f"{type(array)} has no form in JSON")
        found = cast("NDArray[Any]", array)
        if not packed or found.size <= LONGEST_LIST:
            return found.tolist()
        plain = np.ascontiguousarray(found, found.dtype.newbyteorder("<"))
        return _PackedArray(plain.dtype.str, list(plain.shape), plain.tobytes())

    plain = to_builtins(value, enc_hook=encode_array)
    return json.dumps(plain, separators=(",", ":"), allow_nan=False).encode() + b"\n"


def _read_array(kind: Any, value: Any) -> NDArray[Any]:
    """Return the array of an annotation such as NDArray[np.float64] in a list or a packed array."""
    if get_origin(kind) is not np.ndarray:
        raise NotImplementedError(f"{kind} has no form in JSON")
    dtype = np.dtype(get_args(get_args(kind)[1])[0])
    if isinstance(value, dict):
        return _unpack_array(convert(value, _PackedArray), dtype)
    if not isinstance(value, list):
        raise ValueError(f"{_shown(value)} is not a list of numbers")
    try:
        plain: NDArray[Any] = np.array(cast("list[Any]", value))
    except ValueError:
        raise ValueError("its lists are not of one length") from None
    if plain.size and plain.dtype.kind not in ("b" if dtype.kind == "b" else "iuf"):
        raise ValueError("not all of it are numbers")
    with np.errstate(invalid="ignore"):
        found = plain.astype(dtype)
    if dtype.kind == "i" and not (found == plain).all():
        raise ValueError(f"not all of it are whole numbers of {8 * dtype.itemsize} bits")
    return found


def _unpack_array(packed: _PackedArray, dtype: np.dtype[Any]) -> NDArray[Any]:
    if packed.dtype != dtype.newbyteorder("<").str:
        raise ValueError(f"the array is of type {packed.dtype}; it must be {dtype.str}")
    if len(packed.base64) != math.prod(packed.shape) * dtype.itemsize:
        raise ValueError(f"{len(packed.base64)} bytes are not an array of shape {packed.shape}")
    found = np.frombuffer(packed.base64, packed.dtype).reshape(packed.shape).astype(dtype)
    if dtype.kind == "f" and not np.isfinite(found).all():
        raise ValueError("not all of its numbers are finite")
    return found


def read_document(
    path: Path,
    max_bytes: int,
    error: type[PatternDBError],
    what: str,
    read: Callable[[JsonValue], T],
) -> T:
    """Return what ``read`` makes of the JSON document in a file.

    what: what it should hold, for messages. Raises ``error`` with the file and the place in it;
    OSError as :func:`patterndb.system.files.open_regular`.
    """
    with name_file(path, error):
        data = read_limited(path, max_bytes, error, "give fewer points")
        return read(parse_json(data, error, what))


@contextmanager
def name_file(path: Path, error: type[PatternDBError]) -> Generator[None]:
    """Name a file before what goes wrong inside, which is raised as ``error``."""
    try:
        yield
    except PatternDBError as reason:
        raise error(f"{path}: {reason}") from None


#: A surrogate or what may be the escape of one: found in a fraction of the time.
_MAYBE_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]|[\ud800-\udfff]")

#: A surrogate without its other half, escaped or in the text itself: no file can hold it. After an
#: odd number of backslashes another one is no escape.
_HALF_CHARACTER = re.compile(
    r"(?<!\\)(?:\\\\)*("
    r"\\u[dD][89abAB][0-9a-fA-F]{2}(?!\\u[dD][c-fC-F][0-9a-fA-F]{2})"
    r"|(?<!\\u[dD][89abAB][0-9a-fA-F]{2})\\u[dD][c-fC-F][0-9a-fA-F]{2}|[\ud800-\udfff])"
)


def _find_half_character(data: bytes | str) -> str | None:
    """Find a surrogate without its other half in a text of JSON, as an escape."""
    if isinstance(data, bytes):
        data = data.decode(json.detect_encoding(data), "surrogatepass")
    if _MAYBE_SURROGATE.search(data) is None:
        return None
    found = _HALF_CHARACTER.search(data)
    if found is None:
        return None
    return found[1].encode("ascii", "backslashreplace").decode()


#: What JSON has for the types of msgspec, and how messages call it.
_KINDS: dict[type[inspect.Type], tuple[type | tuple[type, ...], str]] = {
    inspect.StructType: (dict, "an object"),
    inspect.DataclassType: (dict, "an object"),
    inspect.DictType: (dict, "an object"),
    inspect.ListType: (list, "a list"),
    inspect.TupleType: (list, "a list"),
    inspect.VarTupleType: (list, "a list"),
    inspect.FrozenSetType: (list, "a list"),
    inspect.BytesType: (str, "a text of base64"),
    inspect.FloatType: ((int, float), "a number"),
    inspect.IntType: (int, "a whole number"),
    inspect.StrType: (str, "a text"),
    inspect.BoolType: (bool, "true or false"),
    inspect.NoneType: (type(None), "null"),
    inspect.LiteralType: (str, "a text"),
    inspect.AnyType: (object, "anything"),
}


def _mend(value: JsonValue, kind: inspect.Type, wanted: str = "") -> object:
    """Raise what is wrong with a value; returned is its copy with whole numbers for 3.0."""
    wanted = wanted or _describe(kind)
    said, kind = _unwrap(kind)
    found = value.value
    if isinstance(kind, inspect.UnionType):
        fitting = [one for one in kind.types if _is_of(found, one)]
        if not fitting:
            value.refuse(wanted)
        return _mend(value, fitting[0])
    if isinstance(kind, inspect.LiteralType):
        if found not in kind.values:
            value.refuse(wanted)
        return found
    if isinstance(kind, inspect.IntType) and isinstance(found, float) and not found % 1:
        found = int(found)
    if not _is_of(found, kind):
        value.refuse(wanted)
    if isinstance(kind, inspect.StructType | inspect.DataclassType):
        fields = {field.encode_name: field for field in kind.fields}
        entries = value.entries(fields)
        for name, field in fields.items():
            if field.required and name not in entries:
                hint = _unwrap(field.type)[0].get("missing")
                hint = f": {hint}" if hint else f"; entries are {', '.join(fields)}"
                value.fail(f'"{name}" is missing{hint}')
        mended = {name: _mend(one, fields[name].type) for name, one in entries.items()}
        # What its __post_init__ refuses, and its arrays.
        value._convert(mended, kind.cls)  # pyright: ignore[reportPrivateUsage]
        return mended
    if isinstance(kind, inspect.DictType):
        return {name: _mend(one, kind.value_type) for name, one in value.entries().items()}
    if isinstance(
        kind, inspect.ListType | inspect.TupleType | inspect.VarTupleType | inspect.FrozenSetType
    ):
        items = value.items()
        if isinstance(kind, inspect.TupleType):
            low, high, kinds = len(kind.item_types), len(kind.item_types), kind.item_types
        else:
            low, high, kinds = kind.min_length, kind.max_length, (kind.item_type,) * len(items)
        if not (low or 0) <= len(items) <= (len(items) if high is None else high):
            value.fail(said.get("length") or f"{_shown(found)} is not {wanted}")
        return [_mend(one, of) for one, of in zip(items, kinds, strict=True)]
    if isinstance(kind, inspect.FloatType | inspect.IntType):
        low = -math.inf if kind.ge is None else kind.ge
        high = math.inf if kind.le is None else kind.le
        if not low <= cast("float", found) <= high:
            whole = isinstance(kind, inspect.IntType)
            number = said.get("description", "a finite number")
            value.refuse(f"a whole number from {low} to {high}" if whole else number)
    return found


def _describe(kind: inspect.Type) -> str:
    """Return what a value of a type is called in messages."""
    said, kind = _unwrap(kind)
    if "description" in said:
        return said["description"]
    if isinstance(kind, inspect.UnionType):
        return " or ".join(map(_describe, kind.types))
    if isinstance(kind, inspect.LiteralType):
        return " or ".join(map(_shown, kind.values))
    return _KINDS[type(kind)][1] if type(kind) in _KINDS else "what it must be"


def _is_of(value: object, kind: inspect.Type) -> bool:
    kind = _unwrap(kind)[1]
    if isinstance(kind, inspect.UnionType):
        return any(_is_of(value, one) for one in kind.types)
    if isinstance(value, bool) and not isinstance(kind, inspect.AnyType):
        return isinstance(kind, inspect.BoolType)
    return isinstance(value, _KINDS.get(type(kind), (object,))[0])


def _unwrap(kind: inspect.Type) -> tuple[dict[str, str], inspect.Type]:
    """Return what is said of a type for messages, and the type itself."""
    said: dict[str, str] = {}
    while isinstance(kind, inspect.Metadata):
        of_kind = cast("Any", kind)
        said = {**(of_kind.extra_json_schema or {}), **(of_kind.extra or {}), **said}
        kind = kind.type
    return said, kind


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = json.dumps(value)
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"
