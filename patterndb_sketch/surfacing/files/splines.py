"""Splines as polylines: as many points as their turning asks for."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import BSpline

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.curvenetwork.polylines import measure_angles

#: A polyline turns by no more than this at any point where the spline is smooth, in radians:
#: a quarter of what counts as a corner (patterndb_sketch.curvenetwork.polylines.CORNER_ANGLE).
MAX_TURNING = math.radians(5)

#: How far the spline may be from the polyline, as a share of its length.
MAX_CHORD_ERROR = 1e-3

#: Steps shorter than this share of the spline's length are not halved: at a cusp the turning
#: never becomes small.
SHORTEST_STEP = 1e-4

#: Places closer than this share of the spline's coordinates are one: the rest is rounding.
ROUNDING = 1e-12

#: Steps within a piece from which its turning is judged; Beziers of degree 3 have two bends.
STEPS_JUDGED = 8


def polylines_of(control: Floats, chain: Int64Array) -> list[Points]:
    """Chains of Beziers as polylines, one for every chain.

    control: (m, degree + 1, 3) control points of Beziers, each from the end of the one before
    in its chain. chain: (m,) the chain of each, ascending from 0 without gaps.

    A polyline passes the ends of its Beziers, turns by MAX_TURNING at most between them (cusps
    aside), and is within MAX_CHORD_ERROR of its chain's length from them.
    """
    degree = control.shape[1] - 1
    judged = _bernstein(degree, np.linspace(0, 1, STEPS_JUDGED + 1))
    first_half, second_half = _halves(degree)
    points = judged @ control
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)
    length = np.bincount(chain, steps)
    rounding = np.zeros(len(length))
    np.maximum.at(rounding, chain, ROUNDING * np.abs(points).max(axis=(1, 2)))
    shortest = np.maximum(rounding, SHORTEST_STEP * length)
    starts, sizes, of = np.arange(len(control), dtype=float), np.ones(len(control)), chain
    lasts = control[np.r_[np.flatnonzero(np.diff(chain)), len(control) - 1], -1]
    done: list[tuple[Floats, Points, Int64Array]] = []
    while len(control):
        points = judged @ control
        steps = np.diff(points, axis=1)
        turning = measure_angles(steps[:, :-1], steps[:, 1:]).sum(axis=1)
        # The steps judged leave out half a step at both ends.
        turning *= STEPS_JUDGED / (STEPS_JUDGED - 1)
        bends = (turning > MAX_TURNING) | (_chord_errors(points) > MAX_CHORD_ERROR * length[of])
        split = bends & (np.linalg.norm(steps, axis=2).sum(axis=1) > shortest[of])
        done.append((starts[~split], control[~split, 0], of[~split]))
        control, starts, of = control[split], starts[split], np.tile(of[split], 2)
        sizes = np.tile(sizes[split] / 2, 2)
        control = np.concatenate([first_half @ control, second_half @ control])
        starts = np.r_[starts, starts + sizes[: len(starts)]]
    order = np.argsort(np.concatenate([one[0] for one in done]))
    points = np.concatenate([one[1] for one in done])[order]
    of = np.concatenate([one[2] for one in done])[order]
    parts = np.split(points, np.flatnonzero(np.diff(of)) + 1)
    return [
        _without_rounding(np.concatenate([part, last[None]]), shortest)
        for part, last, shortest in zip(parts, lasts, rounding, strict=True)
    ]


def beziers_of(spline: BSpline) -> Floats:
    """(m, degree + 1, 3) control points of the Beziers that a B-spline in space is made of."""
    degree = int(spline.k)
    knots = np.asarray(spline.t, np.float64)
    breaks = np.unique(knots[degree : len(knots) - degree])
    shares = np.linspace(0, 1, degree + 1)
    at = breaks[:-1, None] + shares * np.diff(breaks)[:, None]
    # At a break a spline that is not continuous there has the value after it.
    at[:, -1] = np.nextafter(breaks[1:], breaks[:-1])
    values = np.asarray(spline(at), np.float64)
    return np.asarray(np.linalg.solve(_bernstein(degree, shares), values), np.float64)


def _bernstein(degree: int, shares: Floats) -> Floats:
    """(k, degree + 1) the weight of every control point at some shares of a Bezier."""
    i = np.arange(degree + 1)
    choose = np.array([math.comb(degree, k) for k in i], np.float64)
    return choose * shares[:, None] ** i * (1 - shares[:, None]) ** (degree - i)


def _halves(degree: int) -> tuple[Floats, Floats]:
    """The matrices that make of a Bezier's control points those of its halves."""
    i = range(degree + 1)
    half = np.array([[math.comb(row, column) / 2**row for column in i] for row in i])
    return half, half[::-1, ::-1]


def _without_rounding(points: Points, shortest: float) -> Points:
    """The polyline without steps up to the shortest; its ends remain."""
    far = np.linalg.norm(np.diff(points, axis=0), axis=1) > shortest
    kept = np.ascontiguousarray(points[np.r_[True, far]])
    if len(kept) == 1:
        return points[[0, -1]]
    kept[-1] = points[-1]
    return kept


def _chord_errors(points: Floats) -> Floats:
    """(m,) how far the inner points of m short polylines (m, k, 3) are from their chords."""
    chords = points[:, -1:] - points[:, :1]
    inner = points[:, 1:-1] - points[:, :1]
    squares = (chords * chords).sum(axis=2, keepdims=True)
    share = (inner * chords).sum(axis=2, keepdims=True) / np.where(squares > 0, squares, 1)
    off = inner - np.clip(share, 0, 1) * chords
    return np.sqrt((off * off).sum(axis=2)).max(axis=1)
