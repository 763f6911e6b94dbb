"""Networks made by hand, and documents changed in one place, for the tests of network files."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.surfacing.networkfile import parse_drawing, read_drawing
from tests.support.shared import SHARED, list_shared
from tests.support.surfacing.sketches import FOLDER

Document = dict[str, Any]

CURVES = SHARED / "data" / "curves"

#: Closed networks whose patches are known: those of the tests, and a larger one where it is.
CLOSED = [
    *sorted(FOLDER.glob("*.json")),
    *list_shared(CURVES / "salvi", "trebol_network.json"),
]

#: Their nodes, curves and cycles.
COUNTS = {
    "ball": (24, 48, 26),
    "corner": (14, 21, 9),
    "gem": (24, 36, 14),
    "trebol_network": (18, 36, 20),
}

#: The patches that they were made from.
PATCHES = [*sorted(FOLDER.glob("*.sdm")), *list_shared(CURVES / "salvi", "trebol.sdm")]

#: Loops of B-splines, graphs of strokes and lists of strokes; people drew those that are shared.
LOOPS = [*sorted(FOLDER.glob("*.lop")), *sorted((CURVES / "salvi").glob("*.lop"))]
GRAPHS = [
    *sorted((FOLDER / "graphs").glob("*.json")),
    *sorted((CURVES / "cassie" / "graph").glob("*.json")),
]
STROKES = [
    *sorted((FOLDER / "strokes").glob("*.curves")),
    *sorted((CURVES / "cassie" / "strokes").glob("*.curves")),
]


def list_graphs(*names: str) -> list[Path]:
    """Return the graphs of the tests, and those of the given names where these are."""
    return [path for path in GRAPHS if path.is_relative_to(FOLDER) or path.stem in names]


@cache
def drawing(path: Path) -> Drawing:
    return read_drawing(path)


@cache
def document(path: Path) -> Document:
    return json.loads(path.read_bytes())


def bezier(control: Points, n: int = 200) -> Points:
    """Points of a Bezier, by the definition."""
    t = np.linspace(0, 1, n + 1)[:, None]
    points = np.repeat(control[None], n + 1, axis=0)
    while points.shape[1] > 1:
        points = (1 - t[:, None]) * points[:, :-1] + t[:, None] * points[:, 1:]
    return np.ascontiguousarray(points[:, 0])


def parsed(content: object) -> Drawing:
    return parse_drawing(json.dumps(content).encode())


def square_graph() -> Document:
    places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    return {
        "strokes": [{"id": 5, "segments": [0, 1]}, {"id": 2, "segments": [2, 3]}],
        "segments": [
            {
                "id": i,
                "stroke_id": 5 if i < 2 else 2,
                "ctrl_pts": [[places[i], places[i], places[(i + 1) % 4], places[(i + 1) % 4]]]
                if i
                else [[places[0], places[1]]],
                "nodes": [i, (i + 1) % 4],
            }
            for i in range(4)
        ],
        "nodes": [{"id": i, "position": p, "neighbor_edges": []} for i, p in enumerate(places)],
        "patches_created": [],
    }


def change(content: Document, place: list[Any], value: object) -> None:
    at: Any = content
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value


#: A square, and a stroke that crosses two of its sides.
CROSSED: Document = {
    "curves": [
        {"points": [[0, 0], [2, 0]]},
        {"points": [[2, 0], [2, 2]]},
        {"points": [[2, 2], [0, 2]]},
        {"points": [[0, 2], [0, 0]]},
        {"id": "across", "points": [[1, -1], [1, 3]], "stroke": 7},
    ],
    "cycles": [[0, "across", 2, 3], [2, 1, {"curve": 0, "reversed": True}, "across"]],
    "stages": [[0, 1], [2, 3], ["across"]],
}
