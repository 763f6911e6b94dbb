"""Questions for fills: a request's body as a boundary, strokes, and the library's options."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal, cast

import numpy as np
from msgspec import UNSET, Meta, UnsetType

from patterndb.errors import InvalidBoundaryError, NotFoundError
from patterndb.system.documents import JsonModel, JsonValue, parse_json
from patterndb.system.numbers import MOST_COUNT
from patterndb_app.service.catalogue import ServedDatabase
from patterndb_app.service.limits import Limits
from patterndb_app.service.refusals import LargeRequestError, MalformedRequestError
from query.batchline import has_points, read_question
from query.boundary import Boundary
from query.boundaryfile import BoundaryEntries
from query.errors import InvalidQueryError
from query.listing.orders import ORDERS
from query.stroke import Stroke

Count = Annotated[int, Meta(ge=0, le=MOST_COUNT, description="a whole number from 0")]
Positive = Annotated[int, Meta(ge=1, le=MOST_COUNT, description="a whole number from 1")]
Least = Annotated[
    list[Count], Meta(min_length=2, max_length=2, description="two numbers, [least, greatest]")
]
Edge = Annotated[list[Count], Meta(min_length=2, max_length=2, description="an edge, [side, edge]")]
Name = Annotated[str, Meta(max_length=256, description="a text of at most 256 characters")]
Seconds = Annotated[float, Meta(gt=0, le=1e6, description="seconds, more than 0")]
Sha256 = Annotated[
    str, Meta(pattern="^[0-9a-f]{64}$", description="the id of a surface, 64 hexadecimal digits")
]


class FillOptions(JsonModel):
    """The options of a question, as :func:`query.fills` has them; those left out are its defaults.

    ``corners`` of the library, a range of numbers of corners, is ``pattern_corners`` here, for the
    kinds of the boundary's corners have that name. ``pattern`` goes by the first digits of its
    name. ``threads`` is the service's own.
    """

    db: Name | None = None
    tolerance: Count | UnsetType = UNSET
    limit: Positive | UnsetType = UNSET
    per_pattern: Positive | UnsetType | None = UNSET
    order: Literal[tuple(ORDERS)] | UnsetType | None = UNSET  # type: ignore[valid-type]
    strict: bool | UnsetType = UNSET
    max_boundary_irregular: Count | UnsetType = UNSET
    max_irregular: Count | UnsetType | None = UNSET
    valence: Least | UnsetType | None = UNSET
    max_quads: Positive | UnsetType | None = UNSET
    pattern_corners: Least | UnsetType | None = UNSET
    has_loop: bool | UnsetType | None = UNSET
    min_frequency: Positive | UnsetType | None = UNSET
    meshes: Annotated[list[Name], Meta(max_length=64)] | UnsetType | None = UNSET
    licences: Annotated[list[Name], Meta(max_length=64)] | UnsetType | None = UNSET
    origins: list[Literal["learned", "imported", "family", "constructed"]] | UnsetType | None = (
        UNSET
    )
    pattern: Annotated[str, Meta(pattern="^[0-9a-fA-F]{2,16}$")] | UnsetType | None = UNSET
    use_counts: bool | UnsetType = UNSET
    time_limit: Seconds | None = None
    pool: Positive | UnsetType = UNSET
    solver: Literal["kernel", "cp-sat"] | UnsetType = UNSET
    surface: Sha256 | None = None
    place: bool = True


#: Options that are no keyword of :func:`query.fills`, or go by another name there.
_OWN = ("db", "surface", "place", "pattern", "pattern_corners", "time_limit", "limit")

#: The most fills of an answer where none is asked for.
LIMIT = 20


@dataclass(frozen=True, slots=True, eq=False)
class FillQuestion:
    """A question for fills.

    db: the name of the database, None for the first. pattern: the first digits of a pattern's
    name. options: further keywords of :func:`query.fills`. surface: the id of a surface that fills
    are placed on. place: are fills placed, where the boundary has points?
    """

    boundary: Boundary
    strokes: list[Stroke]
    db: str | None
    pattern: str | None
    surface: str | None
    place: bool
    options: dict[str, Any]

    def find_options(self, database: ServedDatabase) -> dict[str, Any]:
        """The keywords of :func:`query.fills`, with the pattern's id; NotFoundError where the
        database has no pattern of that name."""
        if self.pattern is None:
            return self.options
        name = self.pattern
        if re.fullmatch(r"[0-9a-fA-F]{16}", name):
            number = int(name, 16)
            if number >= 2**63:
                raise NotFoundError(f"no pattern's name begins with {name}")
            return {**self.options, "pattern": name}
        return {**self.options, "pattern": database.ask(lambda db: db.pattern(name)).name}


def read_body(data: bytes, limits: Limits, what: str) -> JsonValue:
    """Read the JSON of a body; what: what it should hold, for messages.

    Raises MalformedRequestError for what is no JSON, LargeRequestError for what is nested deeper
    than ``limits.json_depth``.
    """
    refuse_depth(data, limits.json_depth)
    document = parse_json(data, MalformedRequestError, what)
    if not document.is_object:
        document.refuse("an object")
    return document


#: Texts, in which brackets are no nesting.
_TEXT = re.compile(rb'"(?:[^"\\]|\\.)*"', re.DOTALL)


def refuse_depth(data: bytes, most: int) -> None:
    """Refuse JSON that is nested deeper, before it is parsed."""
    letters = np.frombuffer(_TEXT.sub(b"", data), np.uint8)
    begins = (letters == ord("[")) | (letters == ord("{"))
    ends = (letters == ord("]")) | (letters == ord("}"))
    depth = np.cumsum(begins.astype(np.int8) - ends.astype(np.int8), dtype=np.int64)
    deepest = int(depth.max(initial=0))
    if deepest > most:
        raise LargeRequestError(
            f"the JSON is nested {deepest} levels deep; {most} are the most (json_depth)"
        )


def read_fill_question(data: bytes, limits: Limits) -> FillQuestion:
    """Read the body of a question for fills.

    Raises MalformedRequestError for what is no such question, LargeRequestError for what is over a
    limit, InvalidBoundaryError and InvalidQueryError as the library does.
    """
    document = read_body(data, limits, "a question")
    entries = cast("dict[str, Any]", document.value)
    names = set(FillOptions.__struct_fields__)
    asked = {name: value for name, value in entries.items() if name not in names}
    options = JsonValue(
        {name: value for name, value in entries.items() if name in names}, "", document.error
    ).read(FillOptions)
    _refuse_unknown(asked)
    _refuse_size(asked, limits)
    boundary, strokes = read_question(asked)
    refuse_perimeter(boundary, limits)
    if options.surface is not None and boundary.points is None:
        raise InvalidQueryError(
            "a surface needs a boundary with points on it; give sides as lists of points"
        )
    return FillQuestion(
        boundary,
        strokes,
        options.db,
        options.pattern if isinstance(options.pattern, str) else None,
        options.surface,
        options.place,
        _list_keywords(options, limits),
    )


def _list_keywords(options: FillOptions, limits: Limits) -> dict[str, Any]:
    keywords = {
        name: value
        for name in options.__struct_fields__
        if name not in _OWN and (value := getattr(options, name)) is not UNSET
    }
    for name in ("valence",):
        if keywords.get(name) is not None:
            keywords[name] = tuple(keywords[name])
    if isinstance(options.pattern_corners, list):
        keywords["pattern_corners"] = tuple(options.pattern_corners)
    limit = LIMIT if options.limit is UNSET else options.limit
    for name, value, most in (
        ("limit", limit, limits.fills),
        ("pool", keywords.get("pool", 1), limits.pool),
    ):
        if value > most:
            raise LargeRequestError(f"{name} is {value:,}; {most:,} are the most here")
    return {
        **keywords,
        "limit": limit,
        "time_limit": min(options.time_limit or limits.seconds, limits.seconds),
    }


#: Entries of a boundary with points, beside the options.
POINT_ENTRIES = BoundaryEntries.__struct_fields__


def _refuse_unknown(asked: dict[str, Any]) -> None:
    """Refuse names that are neither of a boundary nor an option: a slip must not be passed over."""
    known = POINT_ENTRIES if has_points(asked) else ("sides", "corners", "strokes", "loops")
    for name in asked:
        if name not in known:
            raise MalformedRequestError(
                f"{name[:64]}: there is no such entry; entries are "
                f"{', '.join((*known, *FillOptions.__struct_fields__))}"
            )


def _refuse_size(asked: dict[str, Any], limits: Limits) -> None:
    """Refuse more sides, strokes or points than may be, before anything is made of them."""
    for name, most in (("sides", limits.sides), ("strokes", limits.strokes)):
        value = asked.get(name)
        if isinstance(value, list) and len(cast("list[Any]", value)) > most:
            raise LargeRequestError(
                f"{len(cast('list[Any]', value)):,} {name}; {most} are the most here"
            )
    loops = asked.get("loops")
    if isinstance(loops, int) and loops > limits.strokes:
        raise LargeRequestError(f"loops is {loops}; {limits.strokes} are the most here")
    points = 0
    for name in ("sides", "strokes"):
        value = asked.get(name)
        for one in cast("list[Any]", value) if isinstance(value, list) else ():
            held = cast("dict[str, Any]", one).get("points") if isinstance(one, dict) else one
            points += len(cast("list[Any]", held)) if isinstance(held, list) else 0
    if points > limits.points:
        raise LargeRequestError(f"{points:,} points; {limits.points:,} are the most here")


def refuse_perimeter(boundary: Boundary, limits: Limits) -> None:
    """Refuse a boundary that is longer than the service allows."""
    if boundary.perimeter > limits.perimeter:
        raise InvalidBoundaryError(
            f"the perimeter {boundary.perimeter:,} is above the limit of {limits.perimeter:,} "
            "edges here; ask for coarser sides"
        )
