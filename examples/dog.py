"""A dog: a body of rings from rump to nose, with legs, tail and ears grown out of it.

One half (x >= 0) is modelled and mirrored. Centimetres: y up, the nose towards +z, standing on y =
0.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from modelling import Mesh, Model, Points, mirror
from relaxing import relax

HALF_RING = 7
"""Points of half a ring of the body, from the middle of the belly to the middle of the back."""

# The rings from rump to nose: z, y, half width, half height, pitch of the body's axis there in
# radians.
BODY = (
    (-27.0, 38.5, 4.2, 4.8, 0.0),
    (-25.0, 37.5, 7.4, 8.0, 0.0),
    (-20.0, 37.0, 8.6, 9.2, 0.0),
    (-14.5, 37.5, 8.2, 8.6, 0.0),
    (-8.0, 38.0, 7.5, 7.6, 0.0),
    (-1.0, 37.2, 8.2, 8.8, 0.0),
    (5.0, 36.8, 8.8, 10.0, 0.0),
    (11.0, 37.5, 8.6, 10.0, 0.2),
    (15.5, 40.5, 7.4, 8.8, 0.6),
    (18.5, 45.5, 5.8, 7.0, 0.9),
    (21.0, 50.2, 5.0, 6.0, 0.85),
    (24.0, 54.0, 5.6, 6.4, 0.4),
    (28.0, 55.5, 6.2, 6.2, 0.0),
    (32.0, 54.6, 5.3, 5.4, -0.2),
    (35.0, 52.6, 3.7, 3.9, -0.2),
    (39.5, 51.6, 3.1, 3.2, -0.1),
    (43.0, 51.2, 2.5, 2.6, 0.0),
)
HIND_ROOT, FRONT_ROOT = 1, 5
"""The rearmost of the three rings that hold each leg's root."""

HEAD = 11
"""The ring at the back of the head: the ear is before it, the eye one ring further."""

# The rings of a leg: middle x, y, z and half widths along x and z.
FRONT_LEG = (
    (6.9, 27.0, 5.5, 3.1, 4.3),
    (6.4, 22.0, 4.6, 2.5, 3.1),
    (6.2, 15.0, 5.0, 2.0, 2.3),
    (6.2, 8.5, 5.4, 1.9, 2.0),
    (6.2, 4.6, 6.1, 1.9, 2.2),
    (6.2, 2.4, 7.4, 2.5, 3.3),
    (6.2, 0.3, 7.6, 2.4, 3.3),
)
HIND_LEG = (
    (6.9, 28.0, -19.5, 3.4, 5.2),
    (6.5, 22.5, -18.3, 2.8, 4.0),
    (6.3, 17.0, -20.3, 2.2, 2.8),
    (6.2, 11.5, -23.6, 1.8, 2.1),
    (6.2, 7.5, -23.4, 1.7, 1.9),
    (6.2, 4.4, -22.6, 1.8, 2.1),
    (6.2, 2.3, -21.2, 2.4, 3.2),
    (6.2, 0.3, -21.0, 2.3, 3.2),
)
# The eight points around a leg (x, z), in the order of the root's outline: from inside before, by
# inside behind and outside behind, to outside before.
DIAGONAL = float(np.sqrt(0.5))
AROUND = DIAGONAL * np.array(
    [(-1, 1), (-1.4, 0), (-1, -1), (0, -1.4), (1, -1), (1.4, 0), (1, 1), (0, 1.4)]
)

# The tail: where the middle of each new end lies (y, z), how large it is against the last, and by
# how much it is turned upwards from it, in radians.
TAIL = (
    (42.3, -30.2, 0.75, 0.0),
    (42.6, -34.2, 0.85, 0.2),
    (44.6, -38.2, 0.85, 0.35),
    (48.2, -41.2, 0.8, 0.35),
    (52.5, -42.8, 0.65, 0.2),
)


def ring(z: float, y: float, wide: float, high: float, pitch: float) -> Points:
    """Half a ring of the body, (HALF_RING, 3), from the belly up to the back."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, HALF_RING)
    x, up = wide * np.cos(turn), high * np.sin(turn)
    x[[0, -1]] = 0.0
    return np.column_stack([x, y + np.cos(pitch) * up, z - np.sin(pitch) * up])


def end(model: Model, last: list[int], *, front: bool) -> tuple[int, ...]:
    """Closes the rump or muzzle by half a grid of 4 x 2 quads; returns its upper middle quad."""
    middle = model.at(last[0]) * 0.5 + model.at(last[-1]) * 0.5
    out = np.array([0.0, 0.0, 1.0 if front else -1.0])
    beside = 0.5 * middle + 0.5 * model.at(last[3])
    m, i = model.add(middle + 0.6 * out, beside + 0.5 * out)
    rows = [last[:3], [m, i, last[3]], last[:3:-1]]
    model.grid(rows if front else [row[::-1] for row in rows])
    return m, i, last[5], last[6]


def add_leg(model: Model, rings: list[list[int]], leg: tuple[tuple[float, ...], ...]) -> list[int]:
    """Grows a leg out of 2 x 2 quads between three rings of the body; returns its sole's points."""
    behind, middle, before = rings
    model.remove(model.inside(v for r in rings for v in r[1:4]))
    previous = [
        before[1],
        middle[1],
        behind[1],
        behind[2],
        behind[3],
        middle[3],
        before[3],
        before[2],
    ]
    for x, y, z, wide, deep in leg:
        section = np.column_stack([x + wide * AROUND[:, 0], np.full(8, y), z + deep * AROUND[:, 1]])
        current = model.add(*section)
        model.bridge(previous, current, closed=True)
        previous = current
    sole = model.cap(previous, 2)
    return [v for row in sole for v in row]


def about_middle(matrix: Points, place: tuple[float, float, float]) -> Callable[[Points], Points]:
    """The move that applies ``matrix`` (3, 3) to rows about their middle, which goes to ``place``.

    For a quad with an edge in the mirror plane: its middle counts as in the plane.
    """

    def move(p: Points) -> Points:
        return (p - p.mean(axis=0) * (0.0, 1.0, 1.0)) @ matrix + place

    return move


def add_tail(model: Model, root: tuple[int, ...]) -> None:
    """Grows the tail out of the quad at the middle of the rump by extruding it again and again."""
    quad = [model.find(root)]
    for y, z, size, turn in TAIL:
        c, s = size * np.cos(turn), size * np.sin(turn)
        turned = np.array([[size, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        model.extrude(quad, about_middle(turned, (0.0, y, z)))


def add_nose(model: Model, root: tuple[int, ...]) -> None:
    """Insets the upper quad of the muzzle and pulls it forwards a little."""

    def move(p: Points) -> Points:
        middle = p.mean(axis=0) * (0.0, 1.0, 1.0)
        return middle + (p - middle) * (0.8, 0.75, 0.75) + (0.0, 0.1, 0.7)

    model.extrude([model.find(root)], move)


def add_eye(model: Model, corners: list[int]) -> None:
    """Insets the quad of the eye twice: the lids, then the eyeball set back between them."""
    quad = [model.find(corners)]
    for size, depth in ((0.6, 0.0), (0.75, 0.3)):

        def move(p: Points, size: float = size, depth: float = depth) -> Points:
            middle = p.mean(axis=0)
            return middle + size * (p - middle) - depth * np.array([0.8, 0.3, 0.5])

        model.extrude(quad, move)


def add_ear(model: Model, corners: list[int]) -> None:
    """Grows a pricked ear out of the quad at the top of the head."""
    quad = [model.find(corners)]
    for size, step in (
        (0.95, (0.7, 1.6, -0.5)),
        (0.85, (0.9, 2.6, -0.4)),
        (0.45, (0.5, 3.0, -0.2)),
    ):

        def move(p: Points, size: float = size, step: tuple[float, ...] = step) -> Points:
            middle = p.mean(axis=0)
            return middle + size * (p - middle) * (1.0, 1.0, 0.8) + step

        model.extrude(quad, move)


def dog() -> Mesh:
    """Models the dog."""
    model = Model()
    rings = [model.add(*ring(*shape)) for shape in BODY]
    for behind, before in pairwise(rings):
        model.bridge(behind, before)
    rump = end(model, rings[0], front=False)
    muzzle = end(model, rings[-1], front=True)
    still = set(add_leg(model, rings[HIND_ROOT : HIND_ROOT + 3], HIND_LEG))
    still |= set(add_leg(model, rings[FRONT_ROOT : FRONT_ROOT + 3], FRONT_LEG))
    free = set(range(len(model.points))) - still - {v for r in rings[HEAD:] for v in r}
    model.points = relax(model.points, model.quads, free, steps=2, rate=0.3, half=True)
    add_tail(model, rump)
    add_nose(model, muzzle)
    back, brow, bridge = rings[HEAD : HEAD + 3]
    add_ear(model, [back[4], back[5], brow[4], brow[5]])
    add_eye(model, [brow[3], brow[4], bridge[3], bridge[4]])
    return mirror(model.finish())
