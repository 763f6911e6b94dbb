"""Strict reading of JSON: every refusal names its place."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import UNSET, Meta, UnsetType, field

from patterndb.errors import InvalidMeshError
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Name,
    Point,
    Polyline,
    parse_json,
    read_limited,
)

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


def parsed(text: str) -> JsonValue:
    return parse_json(text, InvalidMeshError, "a test")


@given(VALUES)
def test_values_are_those_of_the_document(value: object) -> None:
    try:
        text = json.dumps(value, allow_nan=False)
    except ValueError:
        with pytest.raises(InvalidMeshError, match="finite"):
            parsed(json.dumps(value))
    else:
        assert parsed(text).value == json.loads(text)


def test_places_are_named_all_the_way_down() -> None:
    document = parsed('{"a": [{"b": [[0, 1], [2, 3, 4]]}]}')
    inner = document.entries(("a",))["a"].items()[0].entries(("b",))["b"]
    assert inner.where == "a[0].b"
    assert inner.points() == [[0.0, 1.0, 0.0], [2.0, 3.0, 4.0]]
    assert inner.items()[1].items()[2].where == "a[0].b[1][2]"


@pytest.mark.parametrize(
    ("text", "call", "message"),
    [
        ('"x"', "number", '"x" is not a number'),
        ("true", "number", "true is not a number"),
        ("1e999", "number", "Infinity is not a finite number"),
        ("1" + "0" * 400, "number", "is not a finite number"),
        ("2.5", "whole", "2.5 is not a whole number"),
        ("1e999", "whole", "Infinity is not a whole number"),
        ("1", "truth", "1 is not true or false"),
        ("1", "text", "1 is not a text"),
        ("{}", "items", "an object is not a list"),
        ("[]", "entries", "a list is not an object"),
        ("[1]", "point", r"a list is not a point \[x, y, z\]"),
    ],
)
def test_refusals(text: str, call: str, message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        getattr(parsed(text), call)()


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("1.5", Name, "1.5 is not a name"),
        ("true", Name, "true is not a name"),
        ("[[0, 0]]", Polyline, "a polyline needs two points or more"),
        ('[[0, 0], [1, "a"]]', Polyline, r'\[1\]\[1\]: "a" is not a number'),
    ],
)
def test_refusals_of_types(text: str, kind: Any, message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        parsed(text).read(kind)


def test_unknown_entries_are_named_with_the_known() -> None:
    with pytest.raises(InvalidMeshError, match=r"^a\.c: there is no such entry; entries are b, d$"):
        parsed('{"a": {"b": 1, "c": 2}}').entries()["a"].entries(("b", "d"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("{", "line 1, column 2: this is not JSON"),
        ('{"a": 1, "b": 2, "a": 3}', 'the entry "a" is there twice'),
        ("[NaN]", "NaN is no number"),
        ("[-Infinity]", "-Infinity is no number"),
        ("[" * 100_000, "nested deeper than a test is"),
        ("9" * 10_000, "this is not JSON that can be read"),
        (b'"\xff"', "byte 1: this is not JSON: the text is not UTF-8"),
    ],
)
def test_what_is_no_json(data: str | bytes, message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        parse_json(data, InvalidMeshError, "a test")


def test_a_file_of_the_limit_is_read_and_a_larger_one_is_not(tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_bytes(b"x" * 1000)
    assert read_limited(path, 1000, InvalidMeshError, "make it small") == b"x" * 1000
    with pytest.raises(InvalidMeshError, match="larger than 999 bytes; make it small"):
        read_limited(path, 999, InvalidMeshError, "make it small")


class Part(JsonModel):
    at: Annotated[Point, Meta(extra={"missing": "where it is"})]
    kind: Annotated[Literal["a", "b"], Meta(description='"a" or "b"')] = "a"
    pair: Annotated[tuple[int, int], Meta(description="a pair")] | UnsetType = UNSET


class Whole(JsonModel):
    parts: list[Polyline | Part]
    names: dict[str, int | str] = field(default_factory=dict)
    count: Annotated[int, Meta(ge=1, le=9)] = 1
    rest: Any = None


def test_declared_documents_are_read() -> None:
    text = '{"parts": [{"at": [1, 2], "pair": [3.0, 4]}, [[0, 1], [2, 3, 4]]], "count": 2.0}'
    whole = parsed(text).read(Whole)
    assert whole == Whole([Part([1, 2], "a", (3, 4)), [[0, 1], [2, 3, 4]]], {}, 2)
    assert isinstance(whole.count, int)
    assert parsed(text).at("parts", 1, 0).where == "parts[1][0]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "a list is not a thing"),
        ("{}", '"parts" is missing; entries are parts, names, count, rest'),
        ('{"parts": [{}]}', 'parts[0]: "at" is missing: where it is'),
        ('{"parts": [{"by": 1}]}', "parts[0].by: there is no such entry; entries are at, kind"),
        ('{"parts": [{"at": [1]}]}', "parts[0].at: a list is not a point [x, y, z]"),
        ('{"parts": [[[0, 0]]]}', "parts[0]: a polyline needs two points or more"),
        ('{"parts": [[[0, 0], [1, 1e999]]]}', "parts[0][1][1]: Infinity is not a finite number"),
        ('{"parts": [null]}', "parts[0]: null is not a list or an object"),
        ('{"parts": null}', "parts: null is not a list"),
        ('{"parts": [{"at": [0, 0], "kind": "c"}]}', 'parts[0].kind: "c" is not "a" or "b"'),
        ('{"parts": [{"at": [0, 0], "pair": [1]}]}', "parts[0].pair: a list is not a pair"),
        ('{"parts": [{"at": [0, 0], "pair": null}]}', "parts[0].pair: null is not a pair"),
        ('{"parts": [], "names": {"a b": true}}', "names.a b: true is not a whole number or a"),
        ('{"parts": [], "count": 10}', "count: 10 is not a whole number from 1 to 9"),
        ('{"parts": [], "rest": [{}], "count": 0.5}', "count: 0.5 is not a whole number"),
    ],
)
def test_what_is_not_as_declared_is_named(text: str, message: str) -> None:
    with pytest.raises(InvalidMeshError) as caught:
        parsed(text).read(Whole, "a thing")
    assert str(caught.value).startswith(message)


def test_entries_that_are_there_twice_are_found_in_linear_time() -> None:
    """Quadratic time would take hours for these."""
    text = "{" + ",".join(f'"{i}": 0' for i in range(300_000)) + ', "299999": 0}'
    with pytest.raises(InvalidMeshError, match='the entry "299999" is there twice'):
        parsed(text)


@pytest.mark.parametrize(
    "text",
    [
        r'"\ud800"',
        r'"\udc00"',
        r'"\\\ud800"',
        r'"\ud800\\udc00"',
        r'"x\ud83d\ud83d\ude00"',
        r'{"\uDFFF": 1}',
        '"\ud800"',
        r'"\ud800"'.encode("utf-16"),
    ],
)
def test_half_a_character_is_refused(text: str | bytes) -> None:
    with pytest.raises(InvalidMeshError, match=r"\\u[dD][89a-fA-F].. is half a character"):
        parse_json(text, InvalidMeshError, "a text")


@pytest.mark.parametrize(
    ("text", "read"),
    [(r'"\ud83d\ude00"', "\U0001f600"), (r'"\\ud800"', r"\ud800"), ('"\U0001f600"', "\U0001f600")],
)
def test_whole_characters_are_read(text: str, read: str) -> None:
    assert parse_json(text, InvalidMeshError, "a text").value == read
    assert parse_json(text.encode(), InvalidMeshError, "a text").value == read
