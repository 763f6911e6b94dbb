"""The header of a PLY file: which elements follow, and what each consists of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ingest.formats.files import ReadLimits
from ingest.formats.grammar import MAX_DIGITS, Fail, quote_token

# Little-endian codes; the body says which end it is.
_TYPES = {
    b"char": "i1",
    b"uchar": "u1",
    b"short": "i2",
    b"ushort": "u2",
    b"int": "i4",
    b"uint": "u4",
    b"float": "f4",
    b"double": "f8",
    b"int8": "i1",
    b"uint8": "u1",
    b"int16": "i2",
    b"uint16": "u2",
    b"int32": "i4",
    b"uint32": "u4",
    b"float32": "f4",
    b"float64": "f8",
}
_ORDERS: dict[bytes, Literal["", "<", ">"]] = {
    b"ascii": "",
    b"binary_little_endian": "<",
    b"binary_big_endian": ">",
}


@dataclass(frozen=True, slots=True)
class Property:
    """One value of an element, or a list of them where ``count_type`` is not None."""

    name: str
    type: str
    count_type: str | None = None

    @property
    def min_bytes(self) -> int:
        return np.dtype(self.count_type or self.type).itemsize


@dataclass(frozen=True, slots=True)
class Element:
    """``count`` rows of the same properties."""

    name: str
    count: int
    properties: tuple[Property, ...]
    line: int

    def index_of(self, *names: str) -> int | None:
        """The position of the one property of one of these names."""
        for position, prop in enumerate(self.properties):
            if prop.name in names:
                return position
        return None


@dataclass(frozen=True, slots=True)
class Header:
    """order: '' for text, '<' and '>' for binary. body: its byte offset. lines: of the header."""

    order: Literal["", "<", ">"]
    elements: tuple[Element, ...]
    body: int
    lines: int


def parse_header(data: bytes, limits: ReadLimits, fail: Fail) -> Header:
    """The header of a PLY file; fails with the line and token at fault.

    Unknown keywords fail, since they could change the layout of the body.
    """
    if not data.startswith((b"ply\n", b"ply\r")):
        fail("not a PLY file: its first line must be 'ply'", line=1, token=data[:16])
    # In a binary file the byte after "end_header" and its newline may be anything, also
    # another newline: so the first line decides what a newline is in this file.
    newline = b"\r" if data[3:4] == b"\r" and data[4:5] != b"\n" else b"\n"
    order: Literal["", "<", ">"] | None = None
    drafts: dict[bytes, _Draft] = {}
    draft: _Draft | None = None
    position, line = data.index(newline) + len(newline), 1
    while True:
        line += 1
        end = data.find(newline, position, limits.max_line_bytes)
        if end < 0:
            fail("the header has no 'end_header' line; is the file cut short?", line=line)
        text = data[position:end]
        position = end + len(newline)
        if b"\0" in text:
            fail("a NUL byte in the header: the file is damaged", line=line)
        tokens = text.split()
        match tokens:
            case [b"comment" | b"obj_info", *_] | []:
                pass
            case [b"end_header"]:
                break
            case [b"format", name, version]:
                if order is not None:
                    fail("a second 'format' line", line=line, token=text)
                if name not in _ORDERS or version != b"1.0":
                    known = ", ".join(quote_token(each) for each in _ORDERS)
                    fail(f"unknown format; known are {known}, all 1.0", line=line, token=text)
                order = _ORDERS[name]
            case [b"element", name, count]:
                if name in drafts:
                    fail("a second element of this name", line=line, token=name)
                draft = drafts[name] = _Draft(_count(count, line, fail), line)
            case [b"property", *words]:
                if draft is None:
                    fail("a property before any element", line=line, token=text)
                prop = _property(words, line, fail)
                if prop.name in draft.properties:
                    fail("a second property of this name", line=line, token=words[-1])
                draft.properties[prop.name] = prop
            case [keyword, *_]:
                fail("not a line of a PLY header", line=line, token=keyword)
    if order is None:
        fail("the header has no 'format' line", line=line)
    elements = (
        Element(quote_token(name), draft.count, tuple(draft.properties.values()), draft.line)
        for name, draft in drafts.items()
    )
    return Header(order, tuple(elements), position, line)


@dataclass(slots=True)
class _Draft:
    """An element whose properties are still being read."""

    count: int
    line: int
    properties: dict[str, Property] = field(default_factory=dict)


def _count(token: bytes, line: int, fail: Fail) -> int:
    if not (token.isdigit() and len(token) <= MAX_DIGITS):
        fail("the number of elements must be a natural number", line=line, token=token)
    return int(token)


def _property(words: list[bytes], line: int, fail: Fail) -> Property:
    match words:
        case [b"list", count_type, type_, name]:
            count_code = _type(count_type, line, fail)
            if count_code.startswith("f"):
                fail("the length of a list must be of an integer type", line=line, token=count_type)
            return Property(quote_token(name), _type(type_, line, fail), count_code)
        case [type_, name]:
            return Property(quote_token(name), _type(type_, line, fail))
        case _:
            fail(
                "a property is 'property <type> <name>' or 'property list <type> <type> <name>'",
                line=line,
                token=b" ".join(words),
            )


def _type(token: bytes, line: int, fail: Fail) -> str:
    if token not in _TYPES:
        fail(
            "unknown type; known are " + ", ".join(map(quote_token, _TYPES)), line=line, token=token
        )
    return _TYPES[token]
