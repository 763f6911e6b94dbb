"""Questions for fills: a request's body as a boundary, strokes, and the library's options."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, cast

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.inspect import TupleType, VarTupleType
from starlette.datastructures import QueryParams

from patterndb.errors import InvalidBoundaryError
from patterndb.system.documents import JsonValue, parse_json
from patterndb.system.requests import Count, Positive, Request, Text, list_options, option
from patterndb_app.service.limits import Limits
from patterndb_app.service.refusals import LargeRequestError, MalformedRequestError
from query.batchline import has_points, read_question
from query.boundary import Boundary
from query.boundaryfile import BoundaryEntries
from query.errors import InvalidQueryError
from query.request import LIMIT, FillRequest

R = TypeVar("R", bound=Request)

Edge = Annotated[list[Count], Meta(min_length=2, max_length=2, description="an edge, [side, edge]")]
Sha256 = Annotated[
    str, Meta(pattern="^[0-9a-f]{64}$", description="the id of a surface, 64 hexadecimal digits")
]


class FillOptions(FillRequest, frozen=True, kw_only=True):
    """The options of a question, with those that only a service has.

    db: the name of the database, None for the first. surface: the id of a surface that fills are
    placed on. place: are fills placed, where the boundary has points?
    """

    limit: Annotated[Positive, option("List at most N fills.")] = LIMIT
    db: Text | None = None
    surface: Sha256 | None = None
    place: bool = True


#: Options that a question has in another form (strokes), or that are the service's own.
_OWN = ("strokes", "threads")

#: The options that a question may have.
OPTIONS = tuple(name for name in FillOptions.__struct_fields__ if name not in _OWN)


@dataclass(frozen=True, slots=True, eq=False)
class FillQuestion:
    """A boundary, and what is asked about it."""

    boundary: Boundary
    request: FillOptions


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


def read_parameters(given: QueryParams, kind: type[R], names: Mapping[str, str]) -> R:
    """Read the parameters of an address as a request.

    names: of parameters by those of options, where they differ. Raises MalformedRequestError that
    names all that are wrong.
    """
    found: dict[str, Any] = {}
    wrong: list[str] = []
    for name, one in list_options(kind).items():
        key = names.get(name, name)
        values = given.getlist(key)
        if not values:
            continue
        several = isinstance(one.type, TupleType | VarTupleType)
        value = values if several else values[-1]
        try:
            found[name] = msgspec.convert(value, one.annotation, strict=False)
        except msgspec.ValidationError as error:
            wrong.append(f"{key}: {error}")
    if wrong:
        raise MalformedRequestError(*wrong)
    return kind(**found)


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
    asked = {name: value for name, value in entries.items() if name not in OPTIONS}
    options = JsonValue(
        {name: value for name, value in entries.items() if name in OPTIONS}, "", document.error
    ).read(FillOptions)
    _refuse_unknown(asked)
    _refuse_size(asked, limits)
    boundary, strokes = read_question(asked)
    refuse_perimeter(boundary, limits)
    if options.surface is not None and boundary.points is None:
        raise InvalidQueryError(
            "a surface needs a boundary with points on it; give sides as lists of points"
        )
    for name, value, most in (
        ("limit", options.limit, limits.fills),
        ("pool", options.pool, limits.pool),
    ):
        if value > most:
            raise LargeRequestError(f"{name} is {value:,}; {most:,} are the most here")
    seconds = min(options.time_limit or limits.seconds, limits.seconds)
    request = msgspec.structs.replace(
        options, strokes=tuple(strokes), time_limit=seconds, threads=THREADS
    )
    return FillQuestion(boundary, request)


#: Threads that look for the fills of one question: the other requests at work have the others.
THREADS = 1

#: Entries of a boundary with points, beside the options.
POINT_ENTRIES = BoundaryEntries.__struct_fields__


def _refuse_unknown(asked: dict[str, Any]) -> None:
    """Refuse names that are neither of a boundary nor an option: a slip must not be passed over."""
    known = POINT_ENTRIES if has_points(asked) else ("sides", "corners", "strokes", "loops")
    for name in asked:
        if name not in known:
            raise MalformedRequestError(
                f"{name[:64]}: there is no such entry; entries are {', '.join((*known, *OPTIONS))}"
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
