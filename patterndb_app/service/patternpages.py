"""Patterns of a database in pages, and all that is known of one."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from patterndb.core.code import format_id
from patterndb.core.display import Suffix
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.notebook import draw
from patterndb.system.requests import Positive, Text, option
from patterndb_app.service.catalogue import ServedDatabase
from patterndb_app.service.refusals import MalformedRequestError
from query.request import PatternRequest, choose_patterns


class ListedPatternJson(TypedDict):
    """A pattern in a list: ``sides`` is their number, ``svg`` where its picture is."""

    id: str
    sides: int
    n_irregular: int
    n_quads: int
    convex: bool
    frequency: int
    svg: str


class PatternPageJson(TypedDict):
    """A page of a list: ``next`` is the cursor of the page after it; ``total`` of all pages."""

    patterns: list[ListedPatternJson]
    next: str | None
    total: int


class SeenJson(TypedDict):
    """A mesh that a pattern was seen in, and in how many patches of it."""

    mesh: str
    licence: str | None
    author: str | None
    count: int


class PatternDetailJson(TypedDict):
    """All that is known of a pattern.

    quads: counter-clockwise; the vertices of the boundary come first, in order. vertices: (x, y)
    in the plane. valences: of the irregular inner vertices. corners: quads at each corner.
    corner_vertices: where they are. boundary: vertices around the boundary. polychords: the quads
    that each runs through, those from border to border first, then loops.
    """

    id: str
    sides: int
    n_irregular: int
    n_quads: int
    convex: bool
    frequency: int
    svg: str
    origin: str
    quads: list[list[int]]
    vertices: list[list[float]]
    valences: list[int]
    corners: list[int]
    corner_vertices: list[int]
    boundary: list[int]
    polychords: list[list[int]]
    n_loops: int
    rotations: int
    chiral: bool
    occurrences: list[SeenJson]


#: What a list may be sorted by: (k,) keys of the patterns of a class, the smallest first.
PATTERN_ORDERS: Mapping[str, Callable[[PatternClass], NDArray[np.int64]]] = {
    "frequency": lambda patterns: -patterns.frequency,
    "irregular": lambda patterns: patterns.n_irregular.astype(np.int64),
    "quads": lambda patterns: patterns.n_quads.astype(np.int64),
    "name": lambda patterns: np.zeros(len(patterns), np.int64),
}


if TYPE_CHECKING:
    PatternOrderName = str
else:
    PatternOrderName = Literal[tuple(PATTERN_ORDERS)]

Cursor = Annotated[str, Meta(max_length=200)]


class PatternPageRequest(PatternRequest, frozen=True, kw_only=True):
    """Which patterns are on a page: the parameters of its address."""

    order: Annotated[PatternOrderName, option("What comes first.")] = "frequency"
    cursor: Annotated[Cursor | None, option("What the page before gave as next.")] = None
    limit: Annotated[Positive, option("Patterns of a page.")] = 50
    db: Annotated[Text | None, option("The name of a database.")] = None


#: Parameters of the address by the names of options, where they differ: each is given once or more.
PARAMETERS = {"n_sides": "sides", "meshes": "mesh", "licences": "licence"}


def list_page(database: ServedDatabase, choice: PatternPageRequest) -> PatternPageJson:
    """List a page of patterns: those after the cursor, by key and then by name.

    A cursor stays good when patterns come or go: it names the pattern that the page before ended
    with, not a place. Raises MalformedRequestError for a cursor that is none of this order,
    NotFoundError for a mesh or licence that there is not.
    """
    after = None if choice.cursor is None else parse_cursor(choice.cursor, choice.order)
    total = 0
    keys: list[NDArray[np.int64]] = []
    owners: list[tuple[PatternClass, NDArray[np.int64]]] = []
    for patterns, rows in choose_patterns(database.opened, choice):
        total += len(rows)
        key = PATTERN_ORDERS[choice.order](patterns)[rows]
        if after is not None:
            later = (key > after[0]) | ((key == after[0]) & (patterns.ids[rows] > after[1]))
            rows, key = rows[later], key[later]
        # Of each class, no more than a page can be on it.
        first = np.lexsort((patterns.ids[rows], key))[: choice.limit + 1]
        owners.append((patterns, rows[first]))
        keys.append(key[first])
    every = [
        (int(k), int(patterns.ids[row]), patterns, int(row))
        for key, (patterns, rows) in zip(keys, owners, strict=True)
        for k, row in zip(key, rows, strict=True)
    ]
    every.sort(key=lambda one: one[:2])
    shown = every[: choice.limit]
    more = len(every) > len(shown)
    return {
        "patterns": [list_pattern(patterns, row) for _, _, patterns, row in shown],
        "next": format_cursor(choice.order, shown[-1][0], shown[-1][1]) if more else None,
        "total": total,
    }


def list_pattern(patterns: PatternClass, row: int) -> ListedPatternJson:
    """What a list tells of a pattern."""
    name = format_id(int(patterns.ids[row]))
    return {
        "id": name,
        "sides": patterns.n_sides,
        "n_irregular": int(patterns.n_irregular[row]),
        "n_quads": int(patterns.n_quads[row]),
        "convex": int(patterns.n_reflex[row]) == 0,
        "frequency": int(patterns.frequency[row]),
        "svg": f"/v1/patterns/{name}.svg",
    }


def format_cursor(order: str, key: int, number: int) -> str:
    """The cursor of a page that ends with the pattern of this key and id."""
    return base64.urlsafe_b64encode(msgspec.json.encode([order, key, number])).decode().rstrip("=")


def parse_cursor(cursor: str, order: str) -> tuple[int, int]:
    """The key and the id of a cursor; MalformedRequestError where it is none of the order."""
    try:
        packed = base64.b64decode(cursor + "=" * (-len(cursor) % 4), b"-_", validate=True)
        of, key, number = msgspec.json.decode(packed, type=tuple[str, int, int])
    except (ValueError, binascii.Error, msgspec.MsgspecError):
        raise MalformedRequestError(
            "cursor: this is no cursor; take it from the page before"
        ) from None
    if of != order or not (-(2**63) <= key < 2**63 and 0 <= number < 2**63):
        raise MalformedRequestError(
            f"cursor: it is of a list in the order {of[:32]!r}, not {order!r}; begin anew without"
        )
    return key, number


def describe_pattern(database: ServedDatabase, name: str) -> PatternDetailJson:
    """All that is known of the pattern whose name begins so; NotFoundError if not exactly one."""
    pattern = database.opened.pattern(name)
    seen = database.slow.occurrences(pattern)
    known = {mesh.name: mesh.provenance for mesh in database.opened.meshes()}
    from patterndb.geometry.embedding import embed_disk

    disk = pattern.disk()
    occurrences: list[SeenJson] = []
    for one in seen:
        said = known.get(one.mesh)
        occurrences.append(
            {
                "mesh": one.mesh,
                "licence": said.licence if said else None,
                "author": said.author if said else None,
                "count": one.patches,
            }
        )
    return {
        "id": pattern.name,
        "sides": pattern.n_sides,
        "n_irregular": pattern.n_irregular,
        "n_quads": pattern.n_quads,
        "convex": pattern.convex,
        "frequency": pattern.frequency,
        "svg": f"/v1/patterns/{pattern.name}.svg",
        "origin": pattern.origin,
        "quads": disk.quads.tolist(),
        "vertices": [[round(x, 6), round(y, 6)] for x, y in embed_disk(disk).tolist()],
        "valences": list(pattern.valences),
        "corners": list(pattern.corners),
        "corner_vertices": disk.corners.tolist(),
        "boundary": list(range(disk.perimeter)),
        "polychords": list_polychords(pattern),
        "n_loops": pattern.n_loops,
        "rotations": pattern.rotations,
        "chiral": pattern.chiral,
        "occurrences": occurrences,
    }


def list_polychords(pattern: Pattern) -> list[list[int]]:
    """The quads of every polychord, as numbered in the pattern's label, loops after them.

    A quad that a polychord passes twice is in its list once.
    """
    chords = pattern.polychords()
    strands = chords.of_strand
    return [np.flatnonzero((strands == chord).any(axis=1)).tolist() for chord in range(chords.n)]


def draw_pattern(database: ServedDatabase, name: str, suffix: Suffix) -> bytes:
    """A picture of the pattern whose name begins so, as the bytes of an SVG or PNG file."""
    return draw(database.opened.pattern(name), suffix)
