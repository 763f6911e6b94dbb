"""Boundaries in the plane, and the patch that each of them suggests."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.tools.planar import PlanarBoundary
from patterndb_sketch.retopo.tools.suggestions import Suggestion, suggest_patch
from tests.support.retopo.boundaries import STEP, boundary

#: Of the cases: radius of what is looked at, snap radius.
RADIUS, SNAP = 1.0, 0.25

#: The corners expected are from runs that end up to a vertex beyond the window, and reach a
#: distance up to another too far.
NEAR = 2 * STEP + 1e-9


def framed(boundaries: list[PlanarBoundary], cursor: tuple[float, float]) -> list[PlanarBoundary]:
    """The boundaries about the vertex nearest to the cursor, u along what arrives there.

    Empty if no vertex is within the snap radius.
    """
    best, at = SNAP, None
    for b in boundaries:
        gaps = np.linalg.norm(b.points - cursor, axis=1)
        k = int(np.argmin(gaps))
        if gaps[k] <= best:
            best, at = float(gaps[k]), (b, k)
    if at is None:
        return []
    b, k = at
    along = b.points[k] - b.points[k - 1] if k or b.closed else b.points[1] - b.points[0]
    along = along / np.linalg.norm(along)
    turn = np.array([along, [-along[1], along[0]]])
    return [
        PlanarBoundary((o.points - b.points[k]) @ turn.T, o.corner, o.closed) for o in boundaries
    ]


def back(
    points: np.ndarray, boundaries: list[PlanarBoundary], cursor: tuple[float, float]
) -> np.ndarray:
    """Points of the frame of :func:`framed` where the boundaries were drawn."""
    shown = framed(boundaries, cursor)
    a, b = boundaries[0].points[:2], shown[0].points[:2]
    u, v = a[1] - a[0], b[1] - b[0]
    angle = np.arctan2(v[0] * u[1] - v[1] * u[0], v @ u)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return (points - b[0]) @ turn.T + a[0]


def asked(
    drawn: list[str],
    cursor: tuple[float, float] = (0.0, 0.0),
    *,
    size: float = 1.0,
    triangle: bool = False,
) -> tuple[Suggestion | None, np.ndarray | None]:
    """What is suggested, and its corners where the boundaries were drawn."""
    boundaries = [boundary(text) for text in drawn]
    found = suggest_patch(framed(boundaries, cursor), size, triangle=triangle)
    if found is None:
        return None, None
    return found, back(found.patch.points, boundaries, cursor)


C = "-0.5,-3 -0.5,0o 0.5,0o 0.5,-3"

LINE = "-3,0 3,0"

#: Name, boundaries (empty side on the left), cursor, triangle?, case, corners, new curves.
CASES = [
    ("a", [LINE], (0, 0), False, "a", [(-1.05, 0), (1.05, 0), (1.05, 2), (-1.05, 2)], 3),
    (
        "b1",
        ["0,3 0,0o 3,0"],
        (0.5, 0),
        False,
        "b1",
        [(0, 2.05), (0, 0), (1.55, 0), (1.55, 2.05)],
        2,
    ),
    (
        "b1 triangle",
        ["0,3 0,0o 3,0"],
        (0.5, 0),
        True,
        "b2",
        [(0, 1.6), (0, 0), (1.55, 0)],
        1,
    ),
    (
        "b1 obtuse",
        ["-1.5,3 0,0o 3,0"],
        (0.5, 0),
        False,
        "b1",
        [(-0.51, 1.03), (0, 0), (1.55, 0), (1.04, 1.03)],
        2,
    ),
    ("b2", ["2,3 0,0o 3,0"], (0.5, 0), False, "b2", [(0.86, 1.29), (0, 0), (1.55, 0)], 1),
    ("c", [C], (0, 0), False, "c", [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.5, 1)], 3),
    (
        "c straight",
        ["-3,0 -0.5,0o 0.5,0o 3,0"],
        (0, 0),
        False,
        "c",
        [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.5, 1)],
        3,
    ),
    (
        "d1",
        ["-3,0 -0.5,0o 0.5,0o 0.5,3"],
        (0, 0),
        False,
        "d1",
        [(-0.5, 0), (0.5, 0), (0.5, 1.05), (-0.5, 1)],
        2,
    ),
    (
        "d1 mirrored",
        ["-0.5,3 -0.5,0o 0.5,0o 3,0"],
        (0, 0),
        False,
        "d1",
        [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.5, 1.05)],
        2,
    ),
    (
        "d2 triangle",
        ["-3,0 -0.5,0o 0.5,0o 0.5,3"],
        (0, 0),
        True,
        "d2",
        [(-0.5, 0), (0.5, 0), (0.5, 1.05)],
        1,
    ),
    (
        "d2 very sharp",
        ["-3,0 -0.5,0o 0.5,0o -2.5,3"],
        (0, 0),
        False,
        "d2",
        [(-0.5, 0), (0.5, 0), (-0.24, 0.74)],
        1,
    ),
    (
        "e",
        ["-0.5,3 -0.5,0o 0.5,0o 0.5,3"],
        (0, 0),
        False,
        "e",
        [(-0.5, 2.05), (-0.5, 0), (0.5, 0), (0.5, 2.05)],
        1,
    ),
    (
        "f1",
        ["-2,1 -0.5,1o -0.5,0o 0.5,0o 0.5,-2"],
        (0, 0),
        False,
        "f1",
        [(-0.5, 1), (-0.5, 0), (0.5, 0), (0.5, 1)],
        2,
    ),
    (
        "f2 triangle",
        ["-2,1 -0.5,1o -0.5,0o 0.5,0o 0.5,-2"],
        (0, 0),
        True,
        "f2",
        [(-0.5, 1), (-0.5, 0), (0.5, 0)],
        1,
    ),
    (
        "f2 very sharp",
        ["-2,1.5 0.25,0.75o -0.5,0o 0.5,0o 0.5,-2"],
        (0, 0),
        False,
        "f2",
        [(0.25, 0.75), (-0.5, 0), (0.5, 0)],
        1,
    ),
    (
        "g",
        ["3,1 -0.5,1o -0.5,0o 0.5,0o 0.5,-2"],
        (0, 0),
        False,
        "g",
        [(0.55, 1), (-0.5, 1), (-0.5, 0), (0.5, 0)],
        1,
    ),
    (
        "g mirrored",
        ["-0.5,-2 -0.5,0o 0.5,0o 0.5,1o -3,1"],
        (0, 0),
        False,
        "g",
        [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.55, 1)],
        1,
    ),
    (
        "h",
        ["-3,1 -0.5,1o -0.5,0o 0.5,0o 0.5,1o 3,1"],
        (0, 0),
        False,
        "h",
        [(-0.5, 1), (-0.5, 0), (0.5, 0), (0.5, 1)],
        1,
    ),
    (
        "h'",
        ["-3,1 -0.5,1o -0.5,0o 0.5,0o 0.5,-0.2o 3,-0.2"],
        (0, 0),
        False,
        "f1",
        [(-0.5, 1), (-0.5, 0), (0.5, 0), (0.5, 1)],
        2,
    ),
    (
        "i",
        [LINE, "3,1.5 -3,1.5"],
        (0, 0),
        False,
        "i",
        [(-1.05, 0), (1.05, 0), (1.05, 1.5), (-1.05, 1.5)],
        2,
    ),
    (
        "i skew",
        [LINE, "3,2.1 -3,0.9"],
        (0, 0),
        False,
        "i",
        [(-1.05, 0), (1.05, 0), (1.03, 1.71), (-1.03, 1.29)],
        2,
    ),
    (
        "j",
        [C, "3,1.5 -3,1.5"],
        (0, 0),
        False,
        "j",
        [(-0.5, 0), (0.5, 0), (0.5, 1.5), (-0.5, 1.5)],
        2,
    ),
    (
        "k",
        [C, "0.6,3 0.6,1.5o -0.6,1.5o -0.6,3"],
        (0, 0),
        False,
        "k",
        [(-0.5, 0), (0.5, 0), (0.6, 1.5), (-0.6, 1.5)],
        2,
    ),
]
