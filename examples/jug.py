"""A jug: a lathed body with a spout, and a handle bridged into its wall (genus 1)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from modelling import Mesh, Model, Points

AROUND = 16
"""Quads around the body; the caps of the two bottoms are grids of AROUND / 4 by AROUND / 4."""

SPOUT, HANDLE = 0, AROUND // 2
"""Where around the body the spout and the handle are: opposite each other."""

# Radius and height in centimetres, from the foot up the outside, over the rim and down the inside.
OUTSIDE = (
    (4.3, 0.0),
    (4.7, 0.25),
    (4.75, 0.8),
    (5.7, 2.6),
    (6.6, 4.9),
    (6.9, 6.5),
    (6.8, 8.1),
    (5.95, 10.6),
    (4.9, 13.0),
    (4.45, 14.4),
    (4.4, 15.8),
    (4.95, 18.3),
)
RIM = ((5.05, 18.75), (4.75, 18.85), (4.55, 18.4))
INSIDE = ((4.0, 16.8), (3.9, 15.0), (4.4, 13.1), (5.9, 10.0), (6.3, 6.7), (5.4, 3.2), (3.6, 1.3))

FOOT_HOLLOW, FLOOR = 0.35, 0.9
"""Heights of the bottom in the middle, outside and inside: the jug stands on its foot ring."""

SPOUT_REACH, SPOUT_LIFT = 1.9, 0.9
"""How far the lip of the spout is pulled outwards and upwards, in centimetres."""

UPPER_ROOT, LOWER_ROOT = 8, 4
"""The lowest ring of `OUTSIDE` in each of the handle's two roots; a root is two quads by two."""

ROOT_SQUEEZE = 0.45
"""How far the columns beside the handle are drawn in, so that its roots are as wide as it is."""

# The rings of the handle from its upper to its lower root: x and z of the middle, half width, half
# thickness.
HANDLE_RINGS = (
    (-5.3, 14.7, 1.15, 0.95),
    (-6.9, 15.5, 1.0, 0.65),
    (-8.6, 15.5, 0.95, 0.55),
    (-10.0, 14.3, 0.9, 0.5),
    (-10.6, 12.3, 0.9, 0.5),
    (-10.2, 10.2, 0.95, 0.55),
    (-9.1, 8.4, 1.0, 0.65),
    (-7.8, 7.1, 1.15, 0.95),
)


def pour(ring: Points, turn: Points, height: float) -> Points:
    """Pulls a ring of the lathe, (AROUND, 3), into the spout: the more, the nearer the rim."""
    near_rim = np.clip((height - 13.0) / 5.8, 0.0, 1.0) ** 1.5
    beak = np.exp(-((np.minimum(turn, 2 * np.pi - turn) / 0.5) ** 2)) * near_rim
    # Beside the beak the wall is drawn in, as a potter's two fingers do it.
    pinch = np.exp(-(((np.minimum(turn, 2 * np.pi - turn) - 0.95) / 0.35) ** 2)) * near_rim
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(AROUND)], axis=1)
    return (
        ring
        + out * (SPOUT_REACH * beak - 0.35 * pinch)[:, None]
        + np.outer(beak, (0, 0, SPOUT_LIFT))
    )


def columns(height: float) -> Points:
    """The angles, (AROUND,), of a ring's points: even, but drawn in towards the handle."""
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    away = turn - 2 * np.pi * HANDLE / AROUND
    rise = np.clip(min(height / 4.0, (18.5 - height) / 2.7), 0.0, 1.0)
    return turn - rise * ROOT_SQUEEZE * away * np.exp(-((away / 0.75) ** 2))


def lathe(model: Model, profile: tuple[tuple[float, float], ...]) -> list[list[int]]:
    """Adds a ring per (radius, height) of the profile; z is up, the spout points along x."""
    rings = []
    for radius, height in profile:
        turn = columns(height)
        ring = np.stack(
            [radius * np.cos(turn), radius * np.sin(turn), np.full(AROUND, height)], axis=1
        )
        rings.append(model.add(*pour(ring, turn, height)))
    return rings


def root(rings: list[list[int]], lowest: int) -> list[list[int]]:
    """The 3 x 3 points of a handle root, rows upwards, columns to the right seen from outside."""
    return [[ring[HANDLE + i] for i in (-1, 0, 1)] for ring in rings[lowest : lowest + 3]]


def outline(block: list[list[int]]) -> list[int]:
    """The eight outer points of a 3 x 3 block, counter-clockwise from its lower left corner."""
    (a, b, c), (h, _, d), (g, f, e) = block
    return [a, b, c, d, e, f, g, h]


def add_handle(model: Model, rings: list[list[int]]) -> None:
    """Cuts the two roots out of the wall and joins them by a bowed tube of eight quads around."""
    upper, lower = root(rings, UPPER_ROOT), root(rings, LOWER_ROOT)
    model.remove(
        [f for block in (upper, lower) for f in model.inside(v for row in block for v in row)]
    )
    # Around the section in the order of `outline`, its corners drawn in.
    rounding = np.array([0.8, 1.0] * 4)
    across = np.array([-1, 0, 1, 1, 1, 0, -1, -1]) * rounding
    upward = np.array([-1, -1, -1, 0, 1, 1, 1, 0]) * rounding
    tangent = np.gradient(np.array(HANDLE_RINGS)[:, :2], axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    previous = outline(upper)
    for (x, z, wide, thick), (tx, tz) in zip(HANDLE_RINGS, tangent, strict=True):
        # Seen from outside at x < 0 the right-hand side is -y; "up" turns with the tube.
        up = np.array([tz, 0.0, -tx])
        right = np.array([0.0, -1.0, 0.0])
        section = np.outer(across * wide, right) + np.outer(upward * thick, up)
        ring = model.add(*(section + np.array([x, 0.0, z])))
        model.bridge(previous, ring, closed=True)
        previous = ring
    # The tube arrives head over heels: its upper edge there is the lower root's lower edge.
    a, b, c, d, e, f, g, h = outline(lower)
    model.bridge(previous, [g, f, e, d, c, b, a, h], closed=True)


def jug() -> Mesh:
    """Models the jug; centimetres, z up, standing on z = 0."""
    model = Model()
    rings = lathe(model, OUTSIDE + RIM + INSIDE)
    for lower, upper in pairwise(rings):
        model.bridge(lower, upper, closed=True)
    # The corners of both grids lie symmetrically to the plane of handle and spout.
    corner = AROUND // 8
    foot = model.cap(rings[0][-corner::-1] + rings[0][:-corner:-1], AROUND // 4)
    floor = model.cap(rings[-1][corner:] + rings[-1][:corner], AROUND // 4)
    for rows, height in ((foot, FOOT_HOLLOW), (floor, FLOOR)):
        inner = [v for row in rows[1:-1] for v in row[1:-1]]
        model.move(inner, model.at(inner) * (1.0, 1.0, 0.0) + (0.0, 0.0, height))
    add_handle(model, rings)
    return model.finish()
