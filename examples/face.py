"""The face of a head: loops around the eyes and the mouth, the nose, and the mask that joins them.

One half (x >= 0, the head's left); decimetres, as in `skull`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from modelling import Model, Points
from skull import drop

EYE = 12
"""Points of a loop around an eye: inner corner (0), top (3), outer corner (6), bottom (9)."""

EYE_X = 0.315
"""Where the middle of the eye is."""

# Loops around the eye, from the opening outwards: centre x, half width, half height above and
# below, how far the loop is lifted off the face, and the power of `oval`.
EYE_LOOPS = (
    (0.310, 0.135, 0.062, 0.046, 0.004, 1.0),
    (0.312, 0.165, 0.088, 0.066, 0.030, 1.0),
    (0.325, 0.195, 0.135, 0.115, -0.005, 0.95),
    (0.340, 0.225, 0.220, 0.175, 0.0, 0.8),
)

EYE_TILT = 0.133
"""How the line from the inner to the outer corner of the eye rises."""

MOUTH = 9
"""Points of a half loop around the mouth: middle above (0), corner (4), middle below (8)."""

MOUTH_Y = -0.66
"""The height of the line between the lips."""

# Loops around the mouth: half width, half height above and below, lift off the face.
MOUTH_LOOPS = (
    (0.190, 0.010, 0.012, 0.000),
    (0.205, 0.038, 0.052, 0.025),
    (0.225, 0.070, 0.094, 0.004),
    (0.280, 0.110, 0.165, 0.0),
)

SLIT = 0.02
"""How deep the line between the lips lies."""

# The nose, row by row from the bridge to its base: the ridge, its edge, the side.
NOSE = (
    ((0.0, -0.150, 0.965), (0.050, -0.150, 0.930), (0.110, -0.185, 0.815)),
    ((0.0, -0.240, 1.040), (0.055, -0.240, 0.995), (0.130, -0.265, 0.825)),
    ((0.0, -0.330, 1.115), (0.075, -0.335, 1.060), (0.178, -0.350, 0.850)),
    ((0.0, -0.415, 1.130), (0.085, -0.425, 1.070), (0.195, -0.445, 0.860)),
    ((0.0, -0.475, 0.990), (0.060, -0.485, 0.960), (0.150, -0.505, 0.860)),
)

# The inner loop of the mask goes along the side of the nose, then by these points (x, y) around the
# mouth.
AROUND_MOUTH = (
    (0.245, -0.56),
    (0.34, -0.65),
    (0.335, -0.78),
    (0.24, -0.88),
    (0.12, -0.905),
    (0.0, -0.905),
)

# The outer loop: over the bridge of the nose, along the cheek, around the mouth, under the chin.
OUTER_LOOP = (
    *((0.0, -0.09), (0.05, -0.09), (0.122, -0.145)),
    *((0.19, -0.235), (0.25, -0.33), (0.30, -0.42), (0.345, -0.51)),
    *((0.38, -0.60), (0.40, -0.72), (0.36, -0.89)),
    *((0.23, -1.00), (0.12, -1.05), (0.0, -1.07)),
)
OVER_NOSE, CHIN_CORNER = 2, 9
"""Where in the outer loop the bridge of the nose ends, and where the chin begins."""

# Between the eyes: height of each row, and the point of the eye's outermost loop at which it ends.
BETWEEN_EYES = ((-0.025, 11), (0.06, 0), (0.15, 1))


@dataclass(frozen=True, slots=True)
class Face:
    """What the rest of the head is joined to.

    ``eye`` is the outermost loop around the eye, ``mask`` the outer loop of the mask from the
    bridge of the nose to the chin, ``brow`` the chain from the middle to the eye's outer upper
    corner, ``nostril`` the quad under the wing of the nose. ``placed`` are the points that stay
    where they were put, ``eased`` those that only the last easing moves.
    """

    eye: list[int]
    mask: list[int]
    brow: list[int]
    nostril: list[int]
    placed: set[int]
    eased: set[int]


def oval(
    centre: tuple[float, float],
    wide: float,
    above: float,
    below: float,
    turn: Points,
    power: float = 1.0,
) -> Points:
    """Points (n, 2) of an oval at the given angles; a ``power`` below 1 makes it boxier."""
    high = np.where(np.sin(turn) > 0, above, below)
    cos, sin = np.cos(turn), np.sin(turn)
    across, up = (np.sign(t) * np.abs(t) ** power for t in (cos, sin))
    return np.column_stack([centre[0] + wide * across, centre[1] + high * up])


def eye_loops(model: Model) -> tuple[list[int], set[int]]:
    """Adds the loops around the eye and closes the innermost by the eyeball, a grid of 3 x 3 quads.

    Returns the outermost loop and all other points.
    """
    turn = np.pi - 2 * np.pi * np.arange(EYE) / EYE
    loops = []
    for x, wide, above, below, lift, power in EYE_LOOPS:
        flat = oval((x, 0.0), wide, above, below, turn, power)
        flat[:, 1] += EYE_TILT * (flat[:, 0] - EYE_X)
        loops.append(model.add(*(drop(flat) + np.array([0.0, 0.0, lift]))))
    for inside, outside in pairwise(loops):
        model.bridge(inside, outside, closed=True)
    # The loops run clockwise seen from outside; a cap wants them the other way round.
    rows = model.cap(loops[0][1::-1] + loops[0][:1:-1], 3)
    ball = [v for row in rows[1:-1] for v in row[1:-1]]
    model.move(ball, drop(model.at(ball)[:, :2]))
    return loops[-1], {v for loop in loops[:-1] for v in loop} | set(ball)


def mouth_loops(model: Model) -> tuple[list[int], set[int]]:
    """Adds the half loops around the mouth and closes the slit between the lips.

    Returns the outermost half loop, from above to below, and all points.
    """
    turn = np.pi / 2 - np.pi * np.arange(MOUTH) / (MOUTH - 1)
    loops = []
    for wide, above, below, lift in MOUTH_LOOPS:
        points = drop(oval((0.0, MOUTH_Y), wide, above, below, turn))
        # The lips are full in the middle and run out in the corners.
        points[:, 2] += lift * (1.0 - (points[:, 0] / 0.24) ** 2)
        points[[0, -1], 0] = 0.0
        loops.append(model.add(*points))
    for inside, outside in pairwise(loops):
        model.bridge(inside, outside)
    slit = loops[0]
    middle = model.add(*(0.5 * (model.at(slit[:3]) + model.at(slit[:-4:-1])) - (0.0, 0.0, SLIT)))
    model.grid([slit[8:4:-1], [*middle, slit[4]], slit[:4]])
    return loops[-1], {v for loop in loops for v in loop} | set(middle)


def add_face(model: Model) -> Face:
    """Models eye, mouth, nose, and the mask's two loops around nose and mouth together."""
    eye, eye_points = eye_loops(model)
    mouth, mouth_points = mouth_loops(model)
    nose = [model.add(*row) for row in NOSE]
    model.grid(nose[::-1])
    base = len(NOSE) + 1  # where the inner loop leaves the nose: a 5-pole at its wing
    inner = [*nose[0], *(row[2] for row in nose[1:]), *model.add(*drop(np.array(AROUND_MOUTH)))]
    outer = model.add(*drop(np.array(OUTER_LOOP)))
    model.bridge(inner, outer)
    model.bridge(mouth[:3], nose[-1])
    model.bridge(mouth[2:], inner[base:])

    rows = [outer[: OVER_NOSE + 1]]
    for y, corner in BETWEEN_EYES:
        rows.append([*model.add(*drop(np.array([(0.0, y), (0.05, y)]))), eye[corner]])
    model.grid(rows)
    model.quad(outer[2], outer[3], eye[10], eye[11])

    return Face(
        eye=eye,
        mask=outer,
        brow=[*rows[-1], *eye[2:6]],
        nostril=[*nose[3][1:], *nose[4][1:]],
        placed=eye_points
        | mouth_points
        | {v for row in nose for v in row}
        | set(outer[CHIN_CORNER:]),
        eased=set(eye) | set(rows[0]),
    )
