"""Drawings with curves that pass each other on purpose, and must be left apart.

Some curves come within 0.6 to 2 % of the diagonal of each other, or much nearer where each is
exact, and do not meet: a strap over a barrel, two rims, the layers of a scaffold. All others meet,
up to noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from patterndb_sketch.curvenetwork.network import CurveNetwork
from tests.support.surfacing.drawnnetworks import Points, list_corners, stack, wobble

TURN = 2.0 * math.pi

#: How near curves come, and noise, as shares of the diagonal.
GAPS = (0.006, 0.008, 0.01, 0.012, 0.015, 0.02)
NOISES = (0.0, 1e-4, 1e-3)

Pair = tuple[str, str, int]


@dataclass(slots=True)
class Trap:
    """A drawing; pairs of curves that have so many nodes in common at most, and at least."""

    curves: dict[str, Points] = field(default_factory=dict)
    apart: list[Pair] = field(default_factory=list)
    meet: list[Pair] = field(default_factory=list)

    def compare(self, network: CurveNetwork) -> tuple[list[Pair], list[Pair]]:
        """List the pairs that are joined wrongly, and those that should be joined and are not."""
        at: dict[object, set[int]] = {}
        for curve in network.curves:
            at.setdefault(curve.id, set()).update(curve.nodes)

        def count(one: str, other: str) -> int:
            return len(at.get(one, set()) & at.get(other, set()))

        joined = [pair for pair in self.apart if count(*pair[:2]) > pair[2]]
        return joined, [pair for pair in self.meet if count(*pair[:2]) < pair[2]]

    def add_circle(
        self,
        name: str,
        radius: float,
        height: float,
        chance: np.random.Generator,
        centre: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add a circle of 40 to 90 samples."""
        n = int(chance.integers(40, 91))
        t = TURN * (np.arange(n + 1) / n + chance.uniform())
        x, y = centre
        line = stack(x + radius * np.cos(t), y + radius * np.sin(t), height)
        line[-1] = line[0]
        self.curves[name] = line

    def add_line(self, name: str, start: Points | list[float], end: Points | list[float]) -> None:
        """Add a straight curve of a few samples."""
        first, last = np.asarray(start, float), np.asarray(end, float)
        share = np.linspace(0, 1, 2 + len(self.curves) % 6)[:, None]
        self.curves[name] = first + share * (last - first)

    def add_box(self, tag: str, low: list[float], high: list[float]) -> None:
        """Add the edges of a box."""
        places = list_corners(low, high)
        for p in range(8):
            for b in (1, 2, 4):
                if not p & b:
                    self.add_line(f"{tag}{p}{p | b}", places[p], places[p | b])


def draw_barrel(chance: np.random.Generator) -> Trap:
    """Three rings and six meridians."""
    trap = Trap()
    for j, z in enumerate((0.0, 0.6, 1.2)):
        trap.add_circle(f"ring{j}", bulge(z), z, chance)
    for i in range(6):
        z = np.linspace(0, 1.2, int(chance.integers(30, 60)))
        a = TURN * i / 6
        trap.curves[f"meridian{i}"] = stack(bulge(z) * np.cos(a), bulge(z) * np.sin(a), z)
    return trap


def bulge(z: Points | float) -> Points:
    return 0.5 + 0.12 * np.sin(math.pi * np.asarray(z) / 1.2)


def draw_strap(chance: np.random.Generator, gap: float) -> Trap:
    """A strap over a barrel: it ends on two rings and passes over the third."""
    trap = draw_barrel(chance)
    a = TURN * chance.uniform(0.2, 0.8) / 6
    z = np.linspace(0, 1.2, 50)
    radius = bulge(z) + gap * np.sin(math.pi * z / 1.2)
    trap.curves["strap"] = stack(radius * np.cos(a), radius * np.sin(a), z)
    trap.apart = [("strap", "ring1", 0)]
    trap.meet = [("strap", "ring0", 1), ("strap", "ring2", 1)]
    return trap


def draw_hoop(chance: np.random.Generator, gap: float) -> Trap:
    """A hoop around a barrel that touches nothing."""
    trap = draw_barrel(chance)
    z = chance.uniform(0.3, 0.5)
    trap.add_circle("hoop", float(bulge(z)) + gap, z, chance)
    trap.apart = [("hoop", f"meridian{i}", 0) for i in range(6)]
    return trap


def draw_rims(chance: np.random.Generator, gap: float) -> Trap:
    """A rim above the rim of a barrel, on which posts stand."""
    trap = draw_barrel(chance)
    low, radius = 1.2 + gap, float(bulge(1.2))
    trap.add_circle("lid", radius, low, chance)
    for i in range(4):
        a = TURN * (i + 0.3) / 4
        z = np.linspace(low, 1.7, 12)
        r = radius * (1.7 - z + 0.3) / (2.0 - low)
        trap.curves[f"post{i}"] = stack(r * np.cos(a), r * np.sin(a), z)
    trap.apart = [("lid", "ring2", 0), *((("lid", f"meridian{i}", 0)) for i in range(6))]
    trap.apart += [("ring2", f"post{i}", 0) for i in range(4)]
    trap.meet = [("lid", f"post{i}", 1) for i in range(4)]
    return trap


def draw_circles(chance: np.random.Generator, gap: float) -> Trap:
    """Two circles in a plane that nearly touch."""
    trap = Trap(apart=[("a", "b", 0)])
    trap.add_circle("a", 0.5, 0, chance)
    trap.add_circle("b", 0.5, 0, chance, (1 + gap, 0))
    trap.add_line("bar", [-0.5, 0, 0], [-0.1, 0.2, 0.6])
    return trap


def draw_touching(chance: np.random.Generator, gap: float) -> Trap:
    """Circles that touch, at one place each."""
    trap = Trap(apart=[("a", "b", 1), ("a", "c", 1)], meet=[("a", "b", 1), ("a", "c", 1)])
    radius = chance.uniform(0.3, 0.5)
    trap.add_circle("a", 0.5, 0, chance)
    trap.add_circle("b", radius, 0, chance, (0.5 + radius, 0))
    trap.add_circle("c", 0.3, 0, chance, (0, 0.8))
    return trap


def draw_panel(chance: np.random.Generator, gap: float) -> Trap:
    """Lines in pairs, half the gap apart, between two rails."""
    trap = draw_frame()
    v = np.linspace(0, 1, 12)
    for k, x in enumerate((0.3, 0.62)):
        trap.curves[f"p{k}"], trap.curves[f"q{k}"] = bend(x, v), bend(x + gap / 2, v)
        trap.apart.append((f"p{k}", f"q{k}", 0))
        trap.meet += [(f"{c}{k}", rail, 1) for c in "pq" for rail in ("rail0", "rail1")]
    return trap


def draw_stubs(chance: np.random.Generator, gap: float) -> Trap:
    """Short lines on a sheet that begin a gap away from its border."""
    trap = draw_frame()
    for k, x in enumerate((0.3, 0.62)):
        trap.curves[f"p{k}"] = bend(x, np.linspace(gap, 0.4, 9))
        trap.apart.append((f"p{k}", "rail0", 0))
    return trap


def draw_frame() -> Trap:
    """The border of a bent sheet."""
    u, v = np.linspace(0, 1, 60), np.linspace(0, 1, 12)
    lines = {"rail0": bend(u, 0), "rail1": bend(u, 1), "end0": bend(0, v), "end1": bend(1, v)}
    return Trap(lines)


def bend(u: Points | float, v: Points | float) -> Points:
    return stack(2 * np.asarray(u), v, 0.3 * np.sin(2 * np.asarray(u) + 0.3))


def draw_fin(chance: np.random.Generator, gap: float) -> Trap:
    """A fin: two edges that run to one tip, a gap apart at their feet, on two lines."""
    trap = Trap()
    t = np.linspace(0, math.pi / 2, int(chance.integers(20, 30)))
    for name, side in (("left", -gap / 2), ("right", gap / 2)):
        trap.curves[name] = stack(1 - np.cos(t), side * (1 - t / (math.pi / 2)), np.sin(t))
        trap.add_line(f"root {name}", [0, side, 0], [1.2, side, 0])
    trap.add_line("back", [1, 0, 1], [1.2, 0, 0])
    trap.apart = [("left", "right", 1), ("root left", "root right", 1)]
    trap.apart += [("left", "root right", 0), ("right", "root left", 0)]
    trap.meet = [("left", "right", 1), ("left", "root left", 1), ("right", "root right", 1)]
    return trap


def draw_rings(chance: np.random.Generator, gap: float) -> Trap:
    """Two rings a gap apart, with spokes across both."""
    trap = Trap(apart=[("in", "out", 0)])
    for name, radius in (("in", 0.5), ("out", 0.5 + gap), ("far", 1.1)):
        trap.add_circle(name, radius, 0, chance)
    for i in range(5):
        a = TURN * i / 5 + 0.2
        way = np.array([math.cos(a), math.sin(a), 0])
        trap.add_line(f"spoke{i}", 0.5 * way, 1.1 * way)
        trap.meet += [(f"spoke{i}", name, 1) for name in ("in", "out", "far")]
    return trap


def draw_walls(chance: np.random.Generator, gap: float) -> Trap:
    """A box with thin walls: an outer frame and an inner one."""
    trap = Trap()
    trap.add_box("o", [0, 0, 0], [1, 0.8, 0.6])
    trap.add_box("i", [gap, gap, gap], [1 - gap, 0.8 - gap, 0.6])
    edges = [name[1:] for name in trap.curves if name[0] == "o"]
    trap.apart = [(f"o{edge}", f"i{edge}", 0) for edge in edges]
    trap.meet = [("o01", "o02", 1), ("i01", "i02", 1), ("o46", "o67", 1)]
    return trap


def draw_wires(chance: np.random.Generator, gap: float) -> Trap:
    """A scaffold: two layers of bars that pass each other."""
    trap = Trap()
    for i in range(4):
        at = 0.1 + 0.25 * i
        trap.add_line(f"a{i}", [0, at, 0], [1, at, 0])
        trap.add_line(f"b{i}", [at, 0, gap], [at, 1, gap])
        trap.apart += [(f"a{i}", f"b{j}", 0) for j in range(4)]
    for end in range(2):
        trap.add_line(f"fa{end}", [end, 0.1, 0], [end, 0.85, 0])
        trap.add_line(f"fb{end}", [0.1, end, gap], [0.85, end, gap])
        trap.meet += [(f"{c}{i}", f"f{c}{end}", 1) for c in "ab" for i in range(4)]
    return trap


def draw_stack(chance: np.random.Generator, gap: float) -> Trap:
    """Boxes laid on each other crosswise, a fifth of the gap apart."""
    trap = Trap()
    up = 0.2 + gap / 5
    trap.add_box("0", [0, 0, 0], [1, 1, 0.2])
    trap.add_box("1", [0.1, -0.1, up], [0.9, 1.1, up + 0.2])
    trap.add_box("2", [-0.1, 0.1, 2 * up], [1.1, 0.9, 2 * up + 0.2])
    names = list(trap.curves)
    trap.apart = [(a, b, 0) for a in names for b in names if a[0] < b[0]]
    trap.meet = [("001", "002", 1), ("101", "102", 1), ("246", "267", 1)]
    return trap


TRAPS: dict[str, Callable[[np.random.Generator, float], Trap]] = {
    "strap": draw_strap,
    "hoop": draw_hoop,
    "rims": draw_rims,
    "circles": draw_circles,
    "touching": draw_touching,
    "panel": draw_panel,
    "stubs": draw_stubs,
    "fin": draw_fin,
    "rings": draw_rings,
    "walls": draw_walls,
    "wires": draw_wires,
    "stack": draw_stack,
}

#: Traps only where all is exact: their gap is of the size of the noise.
EXACT_ONLY = {"stack"}


def list_traps(seed: int) -> Iterator[tuple[str, Trap]]:
    """List traps of all kinds with every gap and every noise, and their names."""
    for number, (name, draw) in enumerate(TRAPS.items()):
        for noise in NOISES[: 1 if name in EXACT_ONLY else None]:
            for gap in GAPS:
                keys = [seed, number, round(1e6 * gap), round(1e6 * noise)]
                sample = draw(np.random.default_rng(keys), gap)
                everything = np.concatenate(list(sample.curves.values()))
                diagonal = float(np.linalg.norm(np.ptp(everything, axis=0)))
                chance = np.random.default_rng(keys)
                trap = draw(chance, gap * diagonal)
                if noise:
                    for curve, line in trap.curves.items():
                        trap.curves[curve] = wobble(line, 0.5 * noise * diagonal, chance)
                yield f"{name}, gap {gap:g}, noise {noise:g}", trap
