"""A left hand: four fingers and a thumb as tubes on a palm of two sides, open at the wrist.

Seen from its back, fingers along +y, the thumb towards +x, the back of the hand towards +z.
Centimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from modelling import Mesh, Model, Points
from relaxing import relax

FINGER_COLUMNS = (0, 3, 6, 9)
"""The first of each finger's two columns at the knuckles, little finger first; webs have one."""

KNUCKLE_X = (-4.05, -3.25, -2.4, -2.05, -1.12, -0.2, 0.15, 1.1, 2.05, 2.4, 3.3, 4.2)
"""Where the lines between the eleven columns at the knuckles are."""

GROUPS = (1, 7)
"""First columns of the groups (half a finger, web, half a finger) that go over into one quad."""

KEPT = (0, 1, 4, 5, 6, 7, 10, 11)
"""The lines of the knuckles that run on to the wrist: eleven columns become seven."""

AROUND = np.radians([-45, -90, -135, 180, 135, 90, 45, 0])
"""The points around a finger, counter-clockwise seen from its tip with its back up."""

# Sections of the palm from the wrist to where it widens to eleven columns: y, middle x, half width,
# half thickness, depth of the hollow of the palm.
PALM = (
    (-10.6, -0.25, 2.65, 1.75, 0.0),
    (-9.5, -0.20, 2.75, 1.65, 0.0),
    (-8.2, -0.05, 3.30, 1.60, 0.15),
    (-6.7, 0.05, 3.85, 1.55, 0.35),
    (-5.2, 0.05, 4.05, 1.45, 0.40),
    (-3.9, 0.05, 4.12, 1.35, 0.35),
)
FAN = ((-2.0, 0.05, 4.15, 1.20, 0.2), (0.0, 0.07, 4.15, 1.02, 0.0))
"""The sections of eleven columns, in the same terms; at the second, fingers and webs begin."""

THUMB_ROOT = 2
"""The section of `PALM` at which the thumb's root begins, two quads by two."""

SOFT_STEPS, SOFT_RATE = 3, 0.3
"""How much the palm is relaxed in the end."""


@dataclass(frozen=True, slots=True)
class Finger:
    """A finger: its length, radius at root and tip, and how much it curls in all, in radians."""

    length: float
    root: float
    tip: float
    curl: float


FINGERS = (
    Finger(6.0, 0.82, 0.66, 0.75),
    Finger(7.6, 0.94, 0.73, 0.65),
    Finger(8.3, 0.98, 0.76, 0.55),
    Finger(7.4, 0.96, 0.74, 0.55),
)
FINGER_TURNS = (-0.22, -0.08, 0.02, 0.14)
"""How far each finger is spread from +y towards +x, in radians."""

THUMB = Finger(7.0, 1.2, 0.86, 0.40)

THUMB_AHEAD, THUMB_UP = (0.85, 0.68, -0.42), (0.5, 0.0, 0.85)
"""The direction in which the thumb leaves the palm, and that of its back."""

TIP_BULGE = 0.04
"""How far a finger's tip stands before its last ring, as a part of the finger's length."""

# Rings of a finger: part of its length, and how much wider than a plain taper. Two rings lie close
# at each joint, so that it can bend without pinching.
FINGER_RINGS = (
    (0.10, 0.94),
    (0.30, 0.98),
    (0.42, 1.06),
    (0.50, 1.03),
    (0.66, 0.98),
    (0.73, 1.02),
    (0.88, 1.0),
    (0.965, 0.72),
)
THUMB_RINGS = (
    (0.17, 1.0),
    (0.38, 0.96),
    (0.52, 1.0),
    (0.60, 0.98),
    (0.78, 1.08),
    (0.92, 0.98),
    (0.985, 0.66),
)


def knuckle_arc(x: Points) -> Points:
    """How far the webs lie before or behind those at the middle finger, (n,) at the given x."""
    return np.interp(x, (-4.1, -2.2, 0.0, 1.1, 2.2, 4.2), (-1.5, -0.75, -0.1, 0.0, -0.1, -0.7))


@dataclass(frozen=True, slots=True)
class Section:
    """A closed section: lines on its back and its palm side from -x to +x, and the two edges."""

    back: list[int]
    palm: list[int]
    little: int
    index: int

    def ring(self) -> list[int]:
        """All its points, counter-clockwise seen from the fingers."""
        return [*self.palm[::-1], self.little, *self.back, self.index]

    def little_edge(self) -> list[int]:
        """The three points around the little finger's edge, in the ring's order."""
        return [self.palm[0], self.little, self.back[0]]

    def index_edge(self) -> list[int]:
        """The three points around the index finger's edge, in the ring's order."""
        return [self.back[-1], self.index, self.palm[-1]]


def add_section(model: Model, x: Points, shape: tuple[float, ...], bend: float) -> Section:
    """Adds a section with lines at the given x, in [-1, 1] across the section.

    ``bend`` says how much of the arc of the knuckles it follows.
    """
    y, middle, half, thick, hollow = shape
    at = middle + half * x
    along = y + bend * knuckle_arc(at)
    # A rounded slab: thinner towards either edge, the palm side hollow in the middle.
    slab = thick * (1.0 - 0.45 * np.abs(x) ** 3)
    arch = 0.25 * (1.0 - x**2)
    back = model.add(*np.column_stack([at, along, slab + arch]))
    palm = model.add(*np.column_stack([at, along, -slab + hollow * (1.0 - x**2) + arch]))
    edges = np.array([middle - half * 1.06, middle + half * 1.06])
    ends = y + bend * knuckle_arc(edges)
    little, index = model.add((edges[0], ends[0], 0.0), (edges[1], ends[1], 0.0))
    return Section(back, palm, little, index)


def widen(model: Model, narrow: list[int], wide: list[int]) -> None:
    """Joins seven columns to eleven: each of `GROUPS` goes from three to one by two 3-poles."""
    follow = dict(zip(KEPT, narrow, strict=True))
    for a, b in pairwise(KEPT):
        if a not in GROUPS:
            model.bridge([follow[a], follow[b]], [wide[a], wide[b]])
            continue
        low, high = model.at([follow[a], follow[b]]), model.at(wide[a : b + 1])
        c, d = model.add(*(0.5 * high[1:3] + 0.5 * (low * (2 / 3) + low[::-1] / 3)))
        model.bridge([follow[a], c, d, follow[b]], wide[a : b + 1])
        model.quad(follow[a], follow[b], d, c)


def add_finger(
    model: Model,
    root: list[int],
    finger: Finger,
    rings: tuple[tuple[float, float], ...],
    ahead: Points,
    up: Points,
) -> list[int]:
    """Grows a tube from the root's eight points and caps it; returns its first ring.

    ``ahead`` (3,) is the direction at the root, ``up`` (3,) that of the finger's back, away from
    which it curls.
    """
    centre = model.at(root).mean(axis=0)
    ahead = ahead / np.linalg.norm(ahead)
    up = up - (up @ ahead) * ahead
    up /= np.linalg.norm(up)
    side = np.cross(ahead, up)
    previous, done, first = root, 0.0, []
    for part, swell in rings:
        middle = finger.curl * ((part + done) / 2) ** 1.2
        centre = centre + (part - done) * finger.length * (
            np.cos(middle) * ahead - np.sin(middle) * up
        )
        bent = finger.curl * part**1.2
        upward = np.cos(bent) * up + np.sin(bent) * ahead
        radius = swell * (finger.root + (finger.tip - finger.root) * part)
        ring = centre + radius * (
            np.outer(np.cos(AROUND), side) + 0.95 * np.outer(np.sin(AROUND), upward)
        )
        current = model.add(*ring)
        model.bridge(previous, current, closed=True)
        first = first or current
        previous, done = current, part
    tip = model.cap(previous, 2)[1][1]
    end = np.cos(finger.curl) * ahead - np.sin(finger.curl) * up
    model.move([tip], (centre + TIP_BULGE * finger.length * end)[None])
    return first


def hand() -> Mesh:
    """Models the hand; centimetres, open at the wrist."""
    model = Model()
    wide_x = 2 * (np.array(KNUCKLE_X) - KNUCKLE_X[0]) / (KNUCKLE_X[-1] - KNUCKLE_X[0]) - 1
    narrow_x = np.linspace(-1.0, 1.0, len(KEPT))
    palm = []
    for k, shape in enumerate(PALM):
        t = k / len(PALM)
        palm.append(add_section(model, (1 - t) * narrow_x + t * wide_x[list(KEPT)], shape, 0.8 * t))
    fan = [add_section(model, wide_x, FAN[0], 0.9), add_section(model, wide_x, FAN[1], 1.0)]

    for lower, upper in [*pairwise(palm), *pairwise(fan)]:
        model.bridge(lower.ring(), upper.ring(), closed=True)
    last, first = palm[-1], fan[0]
    widen(model, last.back, first.back)
    widen(model, last.palm[::-1], first.palm[::-1])
    model.bridge(last.little_edge(), first.little_edge())
    model.bridge(last.index_edge(), first.index_edge())

    # Cut the thumb's root out of the edge of the palm.
    low, middle, high = palm[THUMB_ROOT : THUMB_ROOT + 3]
    model.remove(model.inside(v for section in (low, middle, high) for v in section.index_edge()))
    root = [low.palm[-1], middle.palm[-1], high.palm[-1], high.index]
    root += [high.back[-1], middle.back[-1], low.back[-1], low.index]
    soft = set(
        add_finger(model, root, THUMB, THUMB_RINGS, np.array(THUMB_AHEAD), np.array(THUMB_UP))
    )

    # At the knuckles: webs between the fingers, then the fingers.
    front = fan[1]
    inner = model.add(*(0.5 * (model.at(front.back) + model.at(front.palm))))
    level = [front.little, *inner[1:-1], front.index]
    for c in (c + 2 for c in FINGER_COLUMNS[:-1]):
        model.bridge(front.palm[c : c + 2][::-1], level[c : c + 2][::-1])
        model.bridge(level[c : c + 2][::-1], front.back[c : c + 2][::-1])
    for c, finger, turn in zip(FINGER_COLUMNS, FINGERS, FINGER_TURNS, strict=True):
        root = [*front.palm[c : c + 3][::-1], level[c], *front.back[c : c + 3], level[c + 2]]
        ahead = np.array([np.sin(turn), np.cos(turn), -0.1])
        soft |= set(add_finger(model, root, finger, FINGER_RINGS, ahead, np.array([0.0, 0.0, 1.0])))

    soft |= {v for section in [*palm[1:], *fan] for v in section.ring()}
    model.points = relax(model.points, model.quads, soft, steps=SOFT_STEPS, rate=SOFT_RATE)
    return model.finish()
