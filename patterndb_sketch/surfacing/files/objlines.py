"""Curves in a Wavefront OBJ file: its line elements (l) over its vertices (v).

Programs that make meshes of curves write a curve as one element of many vertices, or as many
elements of two. Elements that share a vertex meet there; a chain of elements through vertices
where nothing else meets is one curve, broken where it turns as at a corner. Faces and everything
else are left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NoReturn

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.joining import join_polylines
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import as_curve, as_places, measure_angles

#: How an OBJ file begins, but no other file of curves: with a comment, a name, or numbers that are
#: no coordinates. Polylines as drawn (.curves) begin with v, too: they have no elements.
_BEGINNING = re.compile(rb"\s*(?:#|(?:o|g|s|mtllib|usemtl|vn|vt|vp|l|f|p)[ \t])")
#: Elements that alone meet at a vertex and turn there by more than this, in radians, are two
#: curves: a circle of six edges is one, a square is four.
CORNER_ANGLE = math.radians(65)

_ELEMENT = re.compile(rb"[\r\n][ \t]*[lfp][ \t]")


def is_obj(data: bytes) -> bool:
    """Is the content of a file that of an OBJ file?"""
    text = data.removeprefix(b"\xef\xbb\xbf")
    if _BEGINNING.match(text):
        return True
    return text.lstrip()[:1] == b"v" and _ELEMENT.search(text) is not None


def obj_drawing(data: bytes, tolerance: float | None = None) -> Drawing:
    """Return the drawing whose curves are the chains of line elements in an OBJ file.

    tolerance: how far apart curves may pass and still meet. Each is named by its place among the
    curves. Raises InvalidNetworkError that names the line.
    """
    points, elements = _read(data)
    chains = _chain(elements, points)
    polylines = [as_curve(points[chain], f"curve {i}") for i, chain in enumerate(chains)]
    found = join_polylines(polylines, tolerance=tolerance)
    return Drawing(found.network, (), found.notes)


def _read(data: bytes) -> tuple[Points, list[list[int]]]:
    """The vertices (v, 3) of a file, and the vertices of its line elements, from 0."""
    vertices: list[list[float]] = []
    elements: list[tuple[int, list[int]]] = []
    n_faces = 0
    for number, (keyword, *words) in _statements(data):
        if keyword == "v":
            vertices.append(_to_point(words, number))
        elif keyword == "l":
            elements.append((number, [_to_index(word, len(vertices), number) for word in words]))
        elif keyword == "f":
            n_faces += 1
    if not elements:
        there = f"{n_faces:,} faces and " if n_faces else ""
        raise InvalidNetworkError(
            f"the OBJ file has {there}no curves, elements that begin with l; export the curves as "
            "lines (in Blender: convert them to meshes first)"
        )
    for number, element in elements:
        if len(element) < 2:
            _fail(number, "a line element has two vertices or more; delete it")
        wrong = [v for v in element if not 0 <= v < len(vertices)]
        if wrong:
            _fail(number, f"the element names vertex {wrong[0] + 1}; the file has {len(vertices)}")
    return as_places(vertices, "the file"), [element for _, element in elements]


def _statements(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """The number of the line and the words of every statement, continued lines joined."""
    words: list[str] = []
    first = 0
    # Names may be in any encoding; numbers and keywords are ASCII.
    lines = data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    for number, line in enumerate(re.split(r"\r\n|\r|\n", lines), 1):
        text, comment, _ = line.partition("#")
        first = first or number
        is_continued = not comment and text.endswith("\\") and _may_continue(words, text)
        words += (text[:-1] if is_continued else text).split()
        if is_continued:
            continue
        if words:
            yield first, words
        words, first = [], 0
    if words:
        yield first, words


def _may_continue(words: list[str], text: str) -> bool:
    """Is a backslash at the end no part of a name, such as a path on Windows?"""
    return ((words or text.split())[:1] or [""])[0] in ("v", "l", "f")


def _to_point(words: list[str], number: int) -> list[float]:
    if len(words) < 3:
        _fail(number, f"a vertex has three numbers, this one has {len(words)}")
    try:
        return [float(word) for word in words[:3]]
    except ValueError:
        _fail(number, f"{' '.join(words[:3])[:60]!r} is not three numbers")


def _to_index(word: str, n_read: int, number: int) -> int:
    """A vertex from 0, of a corner v or v/vt; negative ones count back from the last one read."""
    text = word.split("/", 1)[0]
    if re.fullmatch(r"-?[0-9]{1,18}", text) is None or int(text) == 0:
        _fail(number, f"{word[:60]!r} is not the number of a vertex, from 1")
    index = int(text)
    if index < 0 and -index > n_read:
        _fail(number, f"{word} reaches back before the first vertex: {n_read} were read so far")
    return index - 1 if index > 0 else n_read + index


def _fail(number: int, message: str) -> NoReturn:
    raise InvalidNetworkError(f"line {number}: {message}")


def _chain(elements: list[list[int]], points: Points) -> list[list[int]]:
    """Chains of elements: cut where they share a vertex, joined where two alone meet smoothly."""
    # A step that is there twice would be two curves at one place.
    steps = {tuple(sorted(step)): step for one in elements for step in pairwise(one)}
    beside: dict[int, list[int]] = {}
    for a, b in steps.values():
        if a != b:
            beside.setdefault(a, []).append(b)
            beside.setdefault(b, []).append(a)
    inner = {v for one in elements for v in one[1:-1]}
    through = {
        v: (near[0], near[1])
        for v, near in beside.items()
        if len(near) == 2 and (v in inner or _is_smooth(points, near[0], v, near[1]))
    }
    left = {frozenset(step) for step in steps.values() if step[0] != step[1]}
    chains: list[list[int]] = []
    # From the ends of chains first; what is left then are closed ones.
    for only_ends in (True, False):
        for a, b in steps.values():
            for first, second in ((a, b), (b, a)):
                if frozenset((first, second)) not in left or (only_ends and first in through):
                    continue
                chain = [first, second]
                left.discard(frozenset((first, second)))
                while chain[-1] in through:
                    one, other = through[chain[-1]]
                    onward = other if one == chain[-2] else one
                    if frozenset((chain[-1], onward)) not in left:
                        break
                    left.discard(frozenset((chain[-1], onward)))
                    chain.append(onward)
                chains.append(chain)
    return chains


def _is_smooth(points: Points, a: int, v: int, b: int) -> bool:
    """Does a chain turn at vertex v by less than at a corner?"""
    before, after = points[v] - points[a], points[b] - points[v]
    return float(measure_angles(before[None], after[None])[0]) < CORNER_ANGLE
