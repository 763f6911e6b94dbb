"""Network files changed at random are read, or refused by name."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.networkfile import parse_drawing
from tests.support.surfacing.networkfiles import CROSSED, Document, change, square_graph
from tests.support.surfacing.sketches import FOLDER


def places_in(value: object, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [at] if at else []
    if isinstance(value, dict):
        found += [p for key, inner in value.items() for p in places_in(inner, (*at, key))]
    if isinstance(value, list):
        found += [p for i, inner in enumerate(value) for p in places_in(inner, (*at, i))]
    return found


SMALL: list[Document] = [
    CROSSED,
    square_graph(),
    {
        "nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        "curves": [
            {"id": 0, "nodes": [0, 1], "points": [[0, 0, 0], [1, 0, 0]]},
            {"id": 0, "nodes": [1, 2], "points": [[1, 0, 0], [1, 1, 0]]},
            {"id": 1, "nodes": [2, 0], "points": [[1, 1, 0], [0, 0, 0]]},
        ],
        "cycles": [[{"curve": 0, "part": 0}, {"curve": 0, "part": 1}, {"curve": 1}]],
        "stages": [[0], [1]],
    },
]

ODD = st.sampled_from(
    [
        *(None, True, -1, 0, 1, 2, 3, 0.5, 1e308, -1e99, 1e-300, 10**30, "", "0", "across"),
        *([], {}, [0, 0], [0, 0, 0], [[0, 0], [1, 1]], [[0, 0, 0]] * 4, {"curve": 0}),
    ]
)


@settings(deadline=None, max_examples=400)
@given(st.data())
def test_a_changed_document_is_read_or_refused_by_name(data: st.DataObject) -> None:
    content = json.loads(json.dumps(data.draw(st.sampled_from(SMALL))))
    for _ in range(data.draw(st.integers(1, 3))):
        place = list(data.draw(st.sampled_from(places_in(content))))
        if data.draw(st.booleans()):
            change(content, place, copy.deepcopy(data.draw(ODD)))
        else:
            change(content, place, copy.deepcopy(value_at(content, place[:1])))
    try:
        parse_drawing(json.dumps(content).encode())
    except InvalidNetworkError as error:
        assert str(error)


def value_at(content: object, place: list[Any]) -> object:
    at: Any = content
    for key in place:
        at = at[key]
    return at


TEXTS = [
    (FOLDER / "loop3.lop").read_text(),
    "v 3\n0 0 0\n1 0 0\n1 1 0\nv 2\n0 0.5 0\n2 0.5 0\n",
    "1\n3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 -1 0\n1.5 .5 0\n.5 .5 0\n",
]

ODD_WORDS = ["", "0", "-1", "1", "2", "7", "x", "v", "nan", "1e308", "1e-300", "9" * 30, "\n", "²"]


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_a_changed_text_is_read_or_refused_by_name(data: st.DataObject) -> None:
    lines = [line.split() for line in data.draw(st.sampled_from(TEXTS)).splitlines()]
    for _ in range(data.draw(st.integers(1, 3))):
        line = data.draw(st.integers(0, len(lines) - 1))
        if lines[line]:
            word = data.draw(st.integers(0, len(lines[line]) - 1))
            lines[line][word] = data.draw(st.sampled_from(ODD_WORDS))
        if data.draw(st.integers(0, 9)) == 0:
            del lines[line:]
            lines.append(["0"])
    try:
        parse_drawing("\n".join(map(" ".join, lines)).encode())
    except InvalidNetworkError as error:
        assert str(error)


@pytest.mark.parametrize("data", [b"", b"\xff\xfe", b"1\n\xff", b"[]", b"7", b"null", b'"v"', b"v"])
def test_what_is_no_network(data: bytes) -> None:
    with pytest.raises(InvalidNetworkError):
        parse_drawing(data)
