"""Text files of numbers, word by word, with the line for messages."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NoReturn

import numpy as np
from scipy.interpolate import BSpline

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.joining import join_polylines
from patterndb_sketch.curvenetwork.naming import list_parts
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import (
    SAME_PLACE,
    as_curve,
    as_places,
    gather_places,
    measure_diagonal,
    move_ends,
)
from patterndb_sketch.surfacing.files.splines import beziers_of, polylines_of

#: The highest degree of a B-spline. Programs that model shapes have 3, rarely more than 7; far
#: beyond, the Beziers of a B-spline lose digits.
MAX_DEGREE = 11

#: Curves of a loop join if the gap is below this share of the diagonal: files keep six digits.
JOIN = 1e-4


class NumberWords:
    """The words of a text in order; lines matter for messages only.

    data: the bytes of the text. Raises InvalidNetworkError if they are no UTF-8.
    """

    __slots__ = ("_lines", "_next", "_numbers", "_words")

    def __init__(self, data: bytes) -> None:
        try:
            text = data.decode()
        except UnicodeDecodeError as error:
            raise InvalidNetworkError(
                f"byte {error.start}: this is no list of numbers: the text is not UTF-8"
            ) from None
        lines = enumerate(text.splitlines(), 1)
        self._lines = [(number, line.split()) for number, line in lines if line.strip()]
        self._words = [word for _, words in self._lines for word in words]
        self._numbers = [number for number, words in self._lines for _ in words]
        self._next = 0

    @property
    def left(self) -> int:
        """How many words are left."""
        return len(self._words) - self._next

    def peek(self) -> str:
        """The next word, empty after the last."""
        return self._words[self._next] if self.left else ""

    def line(self, index: int) -> list[str]:
        """The words of one line, blank ones not counted; none after the last."""
        return self._lines[index][1] if index < len(self._lines) else []

    def word(self, what: str) -> str:
        """The next word; ``what`` should be there."""
        if not self.left:
            raise InvalidNetworkError(
                f"the text ends where {what} should follow; is the file complete?"
            )
        self._next += 1
        return self._words[self._next - 1]

    def count(self, what: str, least: int, words_each: int = 1) -> int:
        """The next word, the number of things to follow of so many words each."""
        word = self.word(what)
        # Longer than any number of things, and than Python reads.
        if len(word) > 18 or not (word.isascii() and word.isdigit()):
            self.fail(f"{_shown(word)} is not {what}")
        number = int(word)
        if number < least:
            self.fail(f"{what} is {number}; there must be {least} at least")
        if number * words_each > self.left:
            self.fail(
                f"{what} is {number:,}, but only {self.left:,} words follow; is the file complete?"
            )
        return number

    def number(self, what: str) -> float:
        """The next word, a finite number."""
        word = self.word(what)
        try:
            number = float(word)
        except ValueError:
            self.fail(f"{_shown(word)} is not {what}")
        if not math.isfinite(number):
            self.fail(f"{_shown(word)} is not a finite number")
        return number

    def points(self, count: int, what: str) -> list[list[float]]:
        """The next points [x, y, z]."""
        return [[self.number(f"a coordinate of {what}") for _ in range(3)] for _ in range(count)]

    def end(self) -> None:
        """Raise InvalidNetworkError if words are left."""
        if self.left:
            self.fail(
                f"the text goes on with {_shown(self.word(''))} where it should end; are the "
                "counts before it right?"
            )

    def fail(self, message: str) -> NoReturn:
        """Raise InvalidNetworkError with the line of the word read last."""
        number = self._numbers[max(self._next - 1, 0)] if self._numbers else 1
        raise InvalidNetworkError(f"line {number}: {message}")


def _shown(word: str) -> str:
    return repr(word if len(word) <= 40 else word[:39] + "…")


def polylines_drawing(words: NumberWords, tolerance: float | None = None) -> Drawing:
    """The drawing whose strokes are the polylines, each named by its place in the file.

    tolerance: how far apart strokes may pass and still meet. They were drawn in their order:
    each is a stage. Raises InvalidNetworkError that names the line or the stroke.
    """
    polylines: list[Points] = []
    while words.left:
        name = f"stroke {len(polylines)}"
        if words.word("a polyline") != "v":
            words.fail('a polyline begins with "v" and the number of its points')
        count = words.count("the number of points", 2, words_each=3)
        polylines.append(as_curve(words.points(count, name), name))
    found = join_polylines(polylines, tolerance=tolerance)
    parts = list_parts(found.network, range(len(polylines)))
    stages = tuple(tuple(parts[number]) for number in range(len(polylines)))
    return Drawing(found.network, stages, found.notes, found.joins, found.loose)


def loop_network(words: NumberWords) -> CurveNetwork:
    """The network of one closed loop of B-splines, and its cycle.

    Raises InvalidNetworkError that names the line, or the curves that do not join.
    """
    n_curves = words.count("the number of curves", 1)
    polylines: list[Points] = []
    for number in range(n_curves):
        try:
            polylines.append(as_curve(_b_spline(words), f"curve {number}"))
        except ValueError as error:
            if isinstance(error, InvalidNetworkError):
                raise
            words.fail(f"curve {number} is no B-spline: {error}")
    words.end()
    reach = JOIN * measure_diagonal(polylines)
    nodes = np.empty((n_curves, 3))
    for i, points in enumerate(polylines):
        before = polylines[i - 1][-1]
        gap = float(np.linalg.norm(before - points[0]))
        if gap > reach:
            raise InvalidNetworkError(
                f"curve {(i - 1) % n_curves} ends {gap:.3g} away from where curve {i} begins; "
                "curves run around the loop, each from the end of the one before"
            )
        nodes[i] = (before + points[0]) / 2
    curves: list[Curve] = []
    for i, points in enumerate(polylines):
        last = (i + 1) % n_curves
        moved = move_ends(points, nodes[i], nodes[last])
        if len(moved) < 2:
            raise InvalidNetworkError(f"nothing is left of curve {i} between its ends")
        curves.append(Curve(moved, (i, last), i, i))
    cycle = Cycle(tuple((i, False) for i in range(n_curves)))
    return CurveNetwork(tuple(curves), nodes, (cycle,))


def patches_network(words: NumberWords) -> CurveNetwork:
    """The network of the boundaries of all patches, a cycle for each.

    Curves and nodes are numbered as they first come. Raises InvalidNetworkError that names
    the line or the patch.
    """
    n_patches = words.count("the number of patches", 1)
    sides: list[int] = []
    corners: list[list[float]] = []
    middles: list[list[float]] = []
    for number in range(n_patches):
        n = words.count(f"the number of sides of patch {number}", 1)
        of_patch = words.points(n, f"patch {number}")
        # In the order in which the sides begin.
        corners += of_patch[-1:] + of_patch[:-1]
        middles += words.points(n, f"patch {number}")
        # The centre shapes the patch within its boundary, and is no part of the network.
        words.points(1, f"patch {number}")
        sides.append(n)
    words.end()
    control = as_places([*corners, *middles], "the boundary of all patches")
    reach = SAME_PLACE * measure_diagonal([control])
    nodes, corner_nodes = gather_places(np.array(corners), reach)
    _, middle_places = gather_places(np.array(middles), reach)
    curves: list[Curve] = []
    numbers: dict[tuple[int, int, int], int] = {}
    cycles: list[Cycle] = []
    begin = 0
    for patch, n in enumerate(sides):
        steps: list[tuple[int, bool]] = []
        for side in range(n):
            first = int(corner_nodes[begin + side])
            last = int(corner_nodes[begin + (side + 1) % n])
            middle = int(middle_places[begin + side])
            key = (min(first, last), max(first, last), middle)
            if key not in numbers:
                numbers[key] = len(curves)
                bezier = np.array([nodes[first], middles[begin + side], nodes[last]])
                line = polylines_of(bezier[None], np.zeros(1, np.int64))[0]
                points = as_curve(line, f"side {side} of patch {patch}")
                curves.append(Curve(points, (first, last), numbers[key], numbers[key]))
            curve = numbers[key]
            steps.append((curve, curves[curve].nodes != (first, last)))
        cycles.append(Cycle(tuple(steps)))
        begin += n
    return CurveNetwork(tuple(curves), nodes, tuple(cycles))


def _b_spline(words: NumberWords) -> Points:
    degree = words.count("the degree of a curve", 1)
    if degree > MAX_DEGREE:
        words.fail(f"the degree is {degree}; the highest is {MAX_DEGREE}")
    n_knots = words.count("the number of knots", 2 * degree + 2)
    knots = [words.number("a knot") for _ in range(n_knots)]
    n_points = words.count("the number of control points", degree + 1, words_each=3)
    if n_knots != n_points + degree + 1:
        words.fail(
            f"{n_knots} knots and {n_points} control points: of degree {degree} there are "
            f"{degree + 1} more knots than control points"
        )
    control = as_places(words.points(n_points, "a control point"), "the control polygon")
    if any(b < a for a, b in pairwise(knots)):
        words.fail("the knots of the curve before descend; they must ascend")
    beziers = beziers_of(BSpline(np.array(knots), control, degree, extrapolate=False))
    if not len(beziers):
        words.fail("the knots of the curve before are all the same; they must ascend")
    return polylines_of(beziers, np.zeros(len(beziers), np.int64))[0]
