"""The four-sided pieces that a half body is meshed in."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.bodies.coons import segment
from patterndb_sketch.features.bodies.curves import Component
from patterndb_sketch.features.bodies.outline import Outline, Path
from patterndb_sketch.features.bodies.wheelhouse import Wheelhouse, inner_line

LOW, HIGH = segment([0.5, 0], [1, 0]), segment([0.5, 1], [1, 1])
LONG_LOW, LONG_HIGH = segment([0, 0], [1, 0]), segment([0, 1], [1, 1])
LEFT, MIDDLE, RIGHT = segment([0, 0], [0, 1]), segment([0.5, 0], [0.5, 1]), segment([1, 0], [1, 1])


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """One side of a piece: the part from ``start`` to ``end`` of the samples under ``key``.

    path: the surface's parameters, for the parameters of the samples.
    """

    key: str
    path: Path
    start: float = 0.0
    end: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A four-sided part of a surface; bottom and top run along p, left and right along q."""

    name: str
    surface: str
    component: Component
    bottom: Edge
    right: Edge
    top: Edge
    left: Edge


def pieces(outline: Outline, over: tuple[float, ...]) -> tuple[Piece, ...]:
    """All pieces; over: parameters of the shoulder where the seams over the arches end."""
    return (
        *_side(outline, over), *_top(outline), *_roof(), *_ends(), *_floor(outline),
        *_house(outline.houses[0], "front_wheelhouse"),
        *_house(outline.houses[1], "rear_wheelhouse"),
    )  # fmt: skip


def _side(outline: Outline, over: tuple[float, ...]) -> list[Piece]:
    """Below, between and above the arches; seams lead from the arches' bends to the shoulder."""
    front, rear = outline.houses
    (f1, f2), (r1, r2) = (house.arch(np.array(house.bends)) for house in outline.houses)
    a, b = front.bends
    sills = [
        Edge("sill_front", segment([0, 0], [front.feet[0], 0])),
        Edge("sill_middle", segment([front.feet[1], 0], [rear.feet[0], 0])),
        Edge("sill_rear", segment([rear.feet[1], 0], [1, 0])),
    ]
    seams = [
        Edge("sill_front", segment([0, f1[1]], f1)),
        Edge("sill_middle", segment(f2, r1)),
        Edge("sill_rear", segment(r2, [1, r2[1]])),
    ]
    ends = [f1, f2, r1, r2]
    ups = [Edge("up", segment(end, [at, 1])) for end, at in zip(ends, over, strict=True)]
    cuts = [0.0, *over, 1.0]
    tops = [Edge("shoulder", LONG_HIGH, p, q) for p, q in pairwise(cuts)]
    corner = [Edge("front_corner", LEFT, 0.0, f1[1]), Edge("front_corner", LEFT, f1[1], 1.0)]
    back = [Edge("rear_corner", RIGHT, 0.0, r2[1]), Edge("rear_corner", RIGHT, r2[1], 1.0)]

    def arch(house: Wheelhouse, start: float, end: float) -> Edge:
        return Edge(f"{house.name}_arch", house.arch, start, end)

    parts = [
        (sills[0], arch(front, 0.0, a), seams[0], corner[0]),
        (seams[0], ups[0], tops[0], corner[1]),
        (arch(front, a, b), ups[1], tops[1], ups[0]),
        (sills[1], arch(rear, 0.0, a), seams[1], arch(front, 1.0, b)),
        (seams[1], ups[2], tops[2], ups[1]),
        (arch(rear, a, b), ups[3], tops[3], ups[2]),
        (sills[2], back[0], seams[2], arch(rear, 1.0, b)),
        (seams[2], back[1], tops[4], ups[3]),
    ]
    names = ("bumper", "fender", "over_front", "sill", "doors", "over_rear", "apron", "quarter")
    return [
        Piece(f"side_{name}", "side", "body", *part)
        for name, part in zip(names, parts, strict=True)
    ]


def _top(outline: Outline) -> list[Piece]:
    """The hood and the deck, each a middle and an outer strip, and the ledge between them."""
    paths, a, c = outline.paths, outline.windscreen, outline.rear_window
    hood, deck, belt = paths["hood_seam"], paths["deck_seam"], paths["belt_line"]
    base, foot = paths["windscreen_base"], paths["rear_window_base"]
    first, last = (path(np.zeros(1))[0] for path in (base, foot))
    split, rear_split = 2.0 * a[0] - 1.0, 2.0 * c[0] - 1.0
    beside = [Edge("ledge", segment(end, [1, end[1]])) for end in (a, c)]
    parts = {
        "hood": (
            Edge("hood_edge", LOW, 0.0, split), Edge("hood", hood),
            Edge("across", base), Edge("hood", segment([0.5, 0], first)),
        ),
        "hood_side": (
            Edge("hood_edge", LOW, split, 1.0), Edge("shoulder", RIGHT, 0.0, a[1]),
            beside[0], Edge("hood", hood),
        ),
        "ledge": (
            beside[0], Edge("shoulder", RIGHT, a[1], c[1]), beside[1], Edge("cabin", belt)
        ),
        "deck": (
            Edge("across", foot), Edge("deck", deck),
            Edge("deck_edge", HIGH, 0.0, rear_split), Edge("deck", segment(last, [0.5, 1])),
        ),
        "deck_side": (
            beside[1], Edge("shoulder", RIGHT, c[1], 1.0),
            Edge("deck_edge", HIGH, rear_split, 1.0), Edge("deck", deck),
        ),
    }  # fmt: skip
    return [Piece(name, "top", "body", *part) for name, part in parts.items()]


def _roof() -> list[Piece]:
    low, high = Edge("across", LOW), Edge("across", HIGH)
    screen, middle = Edge("screen", RIGHT), Edge("screen", MIDDLE)
    return [
        Piece("windscreen", "screen", "roof", low, screen, high, middle),
        Piece("roof", "roof", "roof", low, Edge("cabin", RIGHT), high, Edge("cabin", MIDDLE)),
        Piece("rear_window", "window", "roof", low, screen, high, middle),
        Piece(
            "glass", "glass", "roof",
            Edge("cabin", LONG_LOW), screen, Edge("cabin", LONG_HIGH), Edge("screen", LEFT),
        ),
    ]  # fmt: skip


def _ends() -> list[Piece]:
    def end(name: str, low: str, high: str, corner: str) -> Piece:
        sides = (Edge(low, LOW), Edge(corner, RIGHT), Edge(high, HIGH), Edge(corner, MIDDLE))
        return Piece(name, name, "body", *sides)

    return [
        end("nose", "front_bottom", "hood_edge", "front_corner"),
        end("tail", "rear_bottom", "deck_edge", "rear_corner"),
    ]


def _floor(outline: Outline) -> list[Piece]:
    """A middle strip of five parts, and outside of it three: between them are the wheelhouses."""
    front, rear = outline.houses
    inner = inner_line(outline.surfaces["floor"], front.inner)
    cuts = np.array([0.0, *front.feet, *rear.feet, 1.0])
    deep = inner(cuts)
    inside = 2.0 * deep[[0, -1], 0] - 1.0
    names = ("sill_front", "front_span", "sill_middle", "rear_span", "sill_rear")

    def part(start: float, end: float) -> Path:
        return lambda t: inner(start + t * (end - start))

    within = [Edge("inward", segment([0.5, at[1]], at)) for at in deep]
    beyond = [Edge("deep", segment(at, [1, at[1]])) for at in deep]
    within[0] = Edge("front_bottom", LOW, 0.0, inside[0])
    within[-1] = Edge("rear_bottom", HIGH, 0.0, inside[1])
    beyond[0] = Edge("front_bottom", LOW, inside[0], 1.0)
    beyond[-1] = Edge("rear_bottom", HIGH, inside[1], 1.0)
    result: list[Piece] = []
    for i, name in enumerate(names):
        a, b = cuts[i], cuts[i + 1]
        line, middle = Edge(name, part(a, b)), Edge(name, segment([0.5, a], [0.5, b]))
        where = name.replace("sill", "floor").replace("span", "axle")
        sides = (within[i], line, within[i + 1], middle)
        result.append(Piece(f"{where}_middle", "floor", "body", *sides))
        if i % 2 == 0:
            outer = Edge(name, segment([1, a], [1, b]))
            sides = (beyond[i], outer, beyond[i + 1], line)
            result.append(Piece(where, "floor", "body", *sides))
    return result


def _house(house: Wheelhouse, component: Component) -> list[Piece]:
    a, b = house.bends
    name, arch = house.name, f"{house.name}_arch"
    across = [Edge("inwards", segment([at, 0], [at, 1])) for at in (0.0, a, b, 1.0)]
    result = [
        Piece(
            f"{name}_tub_{where}", f"{name}_tub", component,
            Edge(arch, LONG_LOW, start, end), across[i + 1],
            Edge(arch, LONG_HIGH, start, end), across[i],
        )
        for i, (where, start, end) in enumerate(
            [("front", 0.0, a), ("top", a, b), ("rear", b, 1.0)]
        )
    ]  # fmt: skip

    def up_front(t: Floats) -> Points:
        return np.stack([np.zeros(len(t)), t / a], axis=1)

    def over(t: Floats) -> Points:
        return np.stack([(t - a) / (b - a), np.ones(len(t))], axis=1)

    def up_rear(t: Floats) -> Points:
        return np.stack([np.ones(len(t)), (1.0 - t) / (1.0 - b)], axis=1)

    wall = Piece(
        f"{name}_wall", f"{name}_wall", component,
        Edge(f"{name}_span", LONG_LOW), Edge(arch, up_rear, 1.0, b),
        Edge(arch, over, a, b), Edge(arch, up_front, 0.0, a),
    )  # fmt: skip
    return [*result, wall]
