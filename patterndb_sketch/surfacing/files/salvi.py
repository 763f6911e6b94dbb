"""Boundaries of transfinite patches as P. Salvi's program "transfinite" has them.

A loop (.lop): the number of curves, and for each its degree, "K" and K knots, "C" and C control
points of a B-spline. Each begins where the one before ends; together they are one cycle.

Patches (.sdm): the number of patches, and for each the number n of its sides and 2 n + 1
points: n corners, n middle control points and a centre. Side i is the quadratic Bezier from
corner i - 1 to corner i by middle i. Each patch is a cycle, and what patches share is one curve.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.files.splines import beziers_of, polylines_of
from patterndb_sketch.surfacing.files.words import Words
from patterndb_sketch.surfacing.joining.polylines import (
    SAME_PLACE,
    as_curve,
    as_places,
    gather_places,
    measure_diagonal,
    move_ends,
)
from patterndb_sketch.surfacing.network import Curve, Cycle, Network

#: The highest degree of a B-spline. Programs that model shapes have 3, rarely more than 7; far
#: beyond, the Beziers of a B-spline lose digits.
MAX_DEGREE = 11

#: Curves of a loop join if the gap is below this share of the diagonal: files keep six digits.
JOIN = 1e-4


def loop_network(words: Words) -> Network:
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
    return Network(tuple(curves), nodes, (cycle,))


def patches_network(words: Words) -> Network:
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
    return Network(tuple(curves), nodes, tuple(cycles))


def _b_spline(words: Words) -> Points:
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
