"""A head: a face with loops around eyes and mouth, and the skull as a box around it.

One half (x >= 0, the head's left) is modelled and mirrored; decimetres, as in `skull`, until it is
done.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from face import CHIN_CORNER, Face, add_face
from modelling import Mesh, Model, Points, mirror
from relaxing import project, relax
from skull import skull, trace

CENTIMETRES = 10.0
"""Centimetres in the unit of the model."""

JAW_ANGLE = (0.52, -0.74, 0.16)
"""Where the jaw turns up towards the ear."""

CHEEK_BONE, JAW_BONE, BEHIND_JAW = (0.58, -0.30, 0.38), (0.50, -0.78, 0.22), (0.46, -0.60, -0.14)
"""Where the lines down the cheek, along the jaw and from there to the nape go at first."""

# Rows of the forehead: height in the middle, and x and height at the temple.
FOREHEAD = ((0.34, 0.64, 0.36), (0.60, 0.58, 0.58))

CROWN, BACK, SIDE = 6, 11, 6
"""Quads over the crown, down the back of the head, and along the side of the head."""

# Rings of the neck: height in front, height behind, radius, z of the axis.
NECK = (
    (-1.10, -0.78, 0.50, -0.10),
    (-1.16, -0.96, 0.46, -0.30),
    (-1.30, -1.14, 0.44, -0.36),
    (-1.45, -1.32, 0.46, -0.40),
)

EAR_ROWS, EAR_COLUMNS = slice(4, 8), slice(2, 5)
"""The points of the side of the head, out of which the ear grows: rows up, columns back."""

EAR_CENTRE = (-0.14, -0.11)
"""Height and depth (y and z) of the middle of the ear."""

EAR_ROOT, EAR_SHELL = (0.235, 0.115), (0.255, 0.145)
"""Half the height and half the width of the ear where it joins the head, and of its rim."""

EAR_ROUNDING = 0.3
"""0 leaves the ear square, 0.5 makes it an ellipse."""

RELAXING, EASING = 200, 2
"""Steps of relaxing on the skull, and of easing the edges of its parts afterwards, free of it."""


def even(way: Sequence[Sequence[float] | Points], count: int) -> Points:
    """``count`` points evenly inside the polyline ``way``, put on the skull, (count, 3)."""
    line = np.array(way, dtype=np.float64)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], count + 2)[1:-1]
    return project(np.column_stack([np.interp(at, length, line[:, k]) for k in range(3)]), skull)


def add_cheek(model: Model, face: Face) -> tuple[list[int], list[int]]:
    """Adds the cheek, from the mask to a line from the eye's outer corner to the jaw's angle.

    Returns the jaw line from the chin to that angle, and that line from the eye down.
    """
    chin, corner = face.mask[CHIN_CORNER], face.eye[7]
    jaw = [
        chin,
        *model.add(*even([model.at(chin), JAW_BONE], 2), *project(np.array([JAW_ANGLE]), skull)),
    ]
    edge = [corner, *model.add(*even([model.at(corner), CHEEK_BONE, JAW_ANGLE], 6)), jaw[-1]]
    beside_mask = [*face.mask[CHIN_CORNER:2:-1], face.eye[10]]
    model.grid(model.patch(jaw, face.eye[10:6:-1], beside_mask, edge[::-1]))
    return jaw, edge


def add_strip(
    model: Model, brow: list[int]
) -> tuple[list[list[int]], list[list[int]], list[list[int]]]:
    """Adds the strip of six columns up the forehead, over the crown and down the back of the head.

    Returns its rows on the forehead (the first is the brow), on the crown and down the back; the
    last row of each is the first of the next.
    """
    s = np.linspace(0.0, 1.0, len(brow))
    forehead = [brow]
    for middle, x, y in FOREHEAD:
        points = np.column_stack([s * x, middle + s * (y - middle), 0.9 - 0.5 * s])
        forehead.append(model.add(*project(points, skull)))
    crown = [forehead[-1]]
    for turn in np.pi * (0.30 + 0.52 * np.arange(1, CROWN + 1) / CROWN):
        z = np.full(len(s), -0.1 + 0.95 * np.cos(turn))
        points = np.column_stack([0.52 * s, 0.30 + (0.9 - 0.25 * s) * np.sin(turn), z])
        crown.append(model.add(*project(points, skull)))
    back = [crown[-1]]
    for y in 0.55 - 1.15 * np.arange(1, BACK + 1) / BACK:
        points = np.column_stack([0.45 * s, np.full(len(s), y), -0.95 + 0.15 * s])
        back.append(model.add(*project(points, skull)))
    for rows in (forehead, crown, back):
        model.grid(rows)
    return forehead, crown, back


def add_neck(model: Model, jaw_ring: list[int]) -> list[int]:
    """Adds the rings under the jaw and down the neck; returns the last, its opening."""
    turn = np.linspace(0.0, np.pi, len(jaw_ring))
    previous = jaw_ring
    for front, behind, radius, axis in NECK:
        y = behind + (front - behind) * (1 + np.cos(turn)) / 2
        points = np.column_stack([radius * np.sin(turn), y, axis + radius * np.cos(turn)])
        if front != NECK[-1][0]:
            points = project(points, skull)
        points[[0, -1], 0] = 0.0
        current = model.add(*points)
        model.bridge(current, previous)
        previous = current
    return previous


def ear_oval(centre: tuple[float, float], high: float, wide: float) -> Points:
    """The 4 x 3 points (12, 2) of an ear as y and z, rows upwards, columns backwards.

    A square rounded to an egg, broader above, leaning backwards.
    """
    up, back = np.meshgrid(np.linspace(-1.0, 1.0, 4), np.linspace(-1.0, 1.0, 3), indexing="ij")
    y = high * up * np.sqrt(1.0 - EAR_ROUNDING * back**2)
    z = -wide * (1.0 + 0.25 * up) * back * np.sqrt(1.0 - EAR_ROUNDING * up**2) - 0.25 * y
    return np.column_stack([centre[0] + y.ravel(), centre[1] + z.ravel()])


def place_ear(model: Model, root: list[int]) -> None:
    """Moves the 4 x 3 points of the ear's root to their place on the skull."""
    outline = ear_oval(EAR_CENTRE, *EAR_ROOT)
    model.move(root, trace(np.column_stack([np.full(len(root), 1.0), outline]), 0))


def add_ear(model: Model, root: list[int]) -> None:
    """Pulls the ear out of its root: the back of the shell, its rim, then the hollow."""
    region = model.inside(root)
    order = np.argsort(np.argsort(root))  # `extrude` hands the points over by index

    def shell(p: Points) -> Points:
        q = p.copy()
        q[order, 1:] = ear_oval((EAR_CENTRE[0], EAR_CENTRE[1] - 0.04), *EAR_SHELL)
        # It stands off the head, all the more towards the back.
        q[order, 0] += 0.09 + 0.045 * np.tile([-1.0, 0.0, 1.0], 4)
        return q

    def rim(p: Points) -> Points:
        middle = p.mean(axis=0)
        return middle + (p - middle) * (1.0, 0.74, 0.66) + (0.01, 0.0, 0.0)

    def hollow(p: Points) -> Points:
        middle = p.mean(axis=0)
        return middle + (p - middle) * (1.0, 0.9, 0.9) - (0.04, 0.0, 0.0)

    for move in (shell, rim, hollow):
        model.extrude(region, move)


def add_nostril(model: Model, corners: list[int]) -> None:
    """Insets the quad under the wing of the nose and pushes it in."""
    quad = [model.find(corners)]

    def inset(p: Points) -> Points:
        return p.mean(axis=0) + 0.5 * (p - p.mean(axis=0)) + (0.0, 0.012, 0.0)

    model.extrude(quad, inset)


def head() -> Mesh:
    """Models the head; centimetres, y up, looking along z, open at the neck."""
    model = Model()
    face = add_face(model)
    jaw, cheek_edge = add_cheek(model, face)
    forehead, crown, back = add_strip(model, face.brow)

    # The side of the head, between the edge of that strip and the face.
    before = [forehead[2][-1], forehead[1][-1], face.eye[5], face.eye[6], *cheek_edge]
    above, behind = [row[-1] for row in crown], [row[-1] for row in back]
    way = [model.at(jaw[-1]), BEHIND_JAW, model.at(behind[-1])]
    below = [jaw[-1], *model.add(*even(way, SIDE - 1)), behind[-1]]
    side = model.patch(below, above, before[::-1], behind[::-1])
    model.grid(side)

    opening = add_neck(
        model, [*face.mask[:CHIN_CORNER:-1], *jaw[:-1], *below[:-1], *back[-1][::-1]]
    )

    ear = [v for row in side[EAR_ROWS] for v in row[EAR_COLUMNS]]
    place_ear(model, ear)
    still = face.placed | face.eased | set(jaw) | set(ear) | set(opening)
    free = set(range(len(model.points))) - still
    model.points = relax(model.points, model.quads, free, skull, steps=RELAXING, half=True)
    model.points = relax(
        model.points, model.quads, free | face.eased, steps=EASING, rate=0.35, half=True
    )

    add_ear(model, ear)
    add_nostril(model, face.nostril)
    return mirror(model.finish(CENTIMETRES))
