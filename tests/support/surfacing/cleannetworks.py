"""Clean networks of which it is known what is meant: curves of surfaces, and their patches.

Every network is cut from a surface along its parameter lines, drawn as straight edges or as curves
of several samples, and comes with the cycles that are meant. Where nothing in the curves tells a
lid from an opening (the ends of a tube, the ground of a dome), the lid is ``optional``: found or
not, it is right.

tests/patterndb_sketch/surfacing/cycles/test_clean.py asks some of them,
benchmarks/surfacing/clean_cycles.py all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle

Points = NDArray[np.float64]

#: Where a parameter (u, v) of a surface lies.
Place = Callable[[float, float], Sequence[float] | Points]

#: Edges of a curve that is drawn as one.
SAMPLES = 8


@dataclass(frozen=True, slots=True)
class CleanNetwork:
    """A network, and what is meant.

    network: the curves, and as its cycles those that are meant. optional: cycles, as sorted curves,
    that may be found or not.
    """

    name: str
    family: str
    network: CurveNetwork = field(repr=False)
    optional: frozenset[tuple[int, ...]] = frozenset()

    def compare(self, cycles: Sequence[Cycle]) -> tuple[int, int]:
        """Count the cycles that are missing among some, and those that are too many."""
        meant = {tuple(sorted(cycle.curves)) for cycle in self.network.cycles}
        found = {tuple(sorted(cycle.curves)) for cycle in cycles}
        return len(meant - found), len(found - meant - self.optional)


class Drawing:
    """Curves between named nodes, and faces along them."""

    def __init__(self) -> None:
        self._places: dict[object, Points] = {}
        self._curves: dict[frozenset[object], tuple[object, object, Points]] = {}
        self._faces: list[list[object]] = []
        self._lids: list[list[object]] = []

    def line(self, a: object, b: object, points: Points) -> None:
        """A curve from node to node; the first between two nodes is the one that counts."""
        start = self._places.setdefault(a, points[0])
        end = self._places.setdefault(b, points[-1])
        points = np.concatenate([[start], points[1:-1], [end]])
        self._curves.setdefault(frozenset((a, b)), (a, b, points))

    def face(self, nodes: list[object]) -> None:
        """A patch that is meant, by its nodes in order."""
        self._faces.append(nodes)

    def lid(self, nodes: list[object]) -> None:
        """A cycle that may be a patch or not, in place of one that is meant if there is such."""
        self._lids.append(nodes)
        self._faces = [face for face in self._faces if set(face) != set(nodes)]

    def finish(self, name: str, family: str) -> CleanNetwork:
        number = {node: k for k, node in enumerate(self._places)}
        place = {key: k for k, key in enumerate(self._curves)}
        curves = tuple(
            Curve(np.ascontiguousarray(points), (number[a], number[b]), k, k)
            for k, (a, b, points) in enumerate(self._curves.values())
        )

        def walk(nodes: list[object]) -> Cycle:
            steps: list[tuple[int, bool]] = []
            for a, b in zip(nodes, [*nodes[1:], nodes[0]], strict=True):
                curve = place[frozenset((a, b))]
                steps.append((curve, curves[curve].nodes[0] != number[a]))
            return Cycle(tuple(steps))

        cycles = tuple(walk(nodes) for nodes in self._faces)
        lids = frozenset(tuple(sorted(walk(nodes).curves)) for nodes in self._lids)
        nodes = np.array(list(self._places.values()))
        return CleanNetwork(name, family, CurveNetwork(curves, nodes, cycles), lids)


def draw_grid(
    drawing: Drawing,
    place: Place,
    us: Sequence[float],
    vs: Sequence[float],
    name: Callable[[int, int], object] = lambda i, j: (i, j),
    *,
    samples: int = 1,
    without: Callable[[int, int], bool] = lambda i, j: False,
) -> None:
    """Draw the parameter lines of a surface at us and vs, and a face for each of their cells.

    name: of node (i, j); where two are alike the surface closes, and edges of no length are left
    out. without: cells that are not there.
    """

    def edge(i: int, j: int, k: int, l: int) -> None:  # noqa: E741
        a, b = name(i, j), name(k, l)
        if a == b:
            return
        t = np.linspace(0.0, 1.0, samples + 1)
        u, v = us[i] + t * (us[k] - us[i]), vs[j] + t * (vs[l] - vs[j])
        drawing.line(a, b, np.array([place(*at) for at in zip(u, v, strict=True)], float))

    for i in range(len(us) - 1):
        for j in range(len(vs) - 1):
            if without(i, j):
                continue
            around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            for (a, b), (c, d) in zip(around, around[1:] + around[:1], strict=True):
                edge(a, b, c, d)
            nodes = list(dict.fromkeys(name(*at) for at in around))
            drawing.face(nodes)


def make_sheet(
    name: str, family: str, place: Place, m: int, n: int, samples: int, **more: object
) -> CleanNetwork:
    """A sheet of m by n cells over the unit square."""
    drawing = Drawing()
    us, vs = np.linspace(0, 1, m + 1).tolist(), np.linspace(0, 1, n + 1).tolist()
    draw_grid(drawing, place, us, vs, samples=samples, **more)  # type: ignore[arg-type]
    return drawing.finish(name, family)


def list_sheets() -> Iterator[CleanNetwork]:
    """Sheets: flat, wavy, saddles, bent round a cylinder, half pipes."""
    for m, n in ((1, 1), (1, 2), (2, 2), (3, 2), (3, 3), (4, 3), (5, 5), (8, 2), (7, 6)):
        for stretch in (1.0, 2.5):
            yield make_sheet(
                f"flat {m} x {n}, {stretch:g}",
                "flat sheets",
                lambda u, v, m=m, n=n, s=stretch: (s * m * u, n * v, 0.0),
                m,
                n,
                1,
            )
    for m, n in ((2, 1), (2, 2), (3, 2), (3, 3), (4, 3), (5, 4), (6, 6)):
        for height in (0.15, 0.3, 0.6, 1.0):
            for waves in (0.5, 1.0, 1.5):
                for samples in (1, SAMPLES):
                    yield make_sheet(
                        f"wavy {m} x {n}, {height:g} high, {waves:g} waves, {samples} edges",
                        "wavy sheets",
                        lambda u, v, m=m, n=n, h=height, w=waves: (
                            m * u,
                            n * v,
                            h * math.sin(2 * math.pi * w * u) * math.cos(math.pi * w * v),
                        ),
                        m,
                        n,
                        samples,
                    )
    for m, n in ((2, 2), (3, 3), (4, 2), (5, 5)):
        for height in (0.2, 0.5, 1.0):
            yield make_sheet(
                f"saddle {m} x {n}, {height:g} high",
                "saddles",
                lambda u, v, h=height: (u - 0.5, v - 0.5, h * (2 * u - 1) * (2 * v - 1)),
                m,
                n,
                SAMPLES,
            )
    for degrees in (90, 120, 150, 180, 210, 240, 270, 300, 330):
        for m, n in ((2, 1), (3, 1), (3, 2), (4, 2), (6, 1), (6, 3)):
            for height in (0.5, 1.5, 3.0):
                for samples in (1, SAMPLES):
                    if samples == 1 and degrees / m > 100:
                        continue
                    yield make_sheet(
                        f"cylinder {degrees} deg, {m} x {n}, {height:g} high, {samples} edges",
                        "half pipes" if degrees == 180 else "bent sheets",
                        lambda u, v, a=degrees, h=height: (
                            math.cos(math.radians(a) * u),
                            math.sin(math.radians(a) * u),
                            h * v,
                        ),
                        m,
                        n,
                        samples,
                    )


def list_closed_round() -> Iterator[CleanNetwork]:
    """Tubes, domes, bottles, spheres, tori, Moebius strips."""
    for m in (3, 4, 5, 6, 8, 12):
        for n in (1, 2, 3, 5):
            for height in (0.6, 1.5):
                for samples in (1, SAMPLES):
                    yield make_revolved(
                        f"tube {m} x {n}, {height:g} a ring, {samples} edges",
                        "tubes",
                        [(1.0, height * k) for k in range(n + 1)],
                        m,
                        samples,
                    )
    for m in (3, 4, 6, 8):
        for n in (1, 2, 3):
            for height in (0.5, 1.0, 1.5):
                profile = [
                    (math.cos(a), height * math.sin(a))
                    for a in np.linspace(0.0, math.pi / 2, n + 1).tolist()
                ]
                profile[-1] = (0.0, height)

                def outline(t: float, height: float = height) -> tuple[float, float]:
                    return math.cos(t * math.pi / 2), height * math.sin(t * math.pi / 2)

                name = f"dome {m} x {n}, {height:g} high"
                yield make_revolved(name, "domes", profile, m, SAMPLES, outline)
    for m in (4, 6, 8):
        for n in (2, 3, 4, 6):
            at = np.linspace(-math.pi / 2, math.pi / 2, n + 1).tolist()
            profile = [(max(0.0, math.cos(a)), math.sin(a)) for a in at]
            profile[0], profile[-1] = (0.0, -1.0), (0.0, 1.0)
            for samples in (1, SAMPLES):
                yield make_revolved(
                    f"sphere {m} x {n}, {samples} edges",
                    "spheres",
                    profile,
                    m,
                    samples,
                    lambda t: (math.sin(math.pi * t), -math.cos(math.pi * t)),
                )
    bottles = {
        "bottle": [(0.9, 0), (1, 0.3), (1, 2), (0.8, 2.6), (0.35, 3.1), (0.35, 3.8)],
        "vase": [(0.6, 0), (1.1, 0.8), (1.2, 1.6), (0.7, 2.4), (0.5, 2.8), (0.8, 3.3)],
        "bowl": [(0.4, 0), (1.0, 0.25), (1.5, 0.8), (1.7, 1.5)],
        "pointed": [(0.0, 0), (1.0, 0.5), (1.1, 1.5), (0.4, 2.4), (0.3, 3.0)],
        "goblet": [(0.9, 0), (0.15, 0.25), (0.12, 1.2), (0.8, 1.7), (1.0, 2.6)],
    }
    for name, profile in bottles.items():
        for m in (4, 6, 8):
            yield make_revolved(f"{name}, {m} meridians", "bottles", profile, m, SAMPLES)
    for m, n in ((3, 3), (4, 3), (5, 3), (5, 4), (4, 5), (6, 4), (8, 6), (12, 5)):
        for radius in (2.0, 3.0):
            for samples in (1, SAMPLES):
                drawing = Drawing()
                draw_grid(
                    drawing,
                    lambda u, v, r=radius: (
                        (r + math.cos(2 * math.pi * v)) * math.cos(2 * math.pi * u),
                        (r + math.cos(2 * math.pi * v)) * math.sin(2 * math.pi * u),
                        math.sin(2 * math.pi * v),
                    ),
                    np.linspace(0, 1, m + 1).tolist(),
                    np.linspace(0, 1, n + 1).tolist(),
                    lambda i, j, m=m, n=n: (i % m, j % n),
                    samples=samples,
                )
                yield drawing.finish(f"torus {m} x {n}, {radius:g}, {samples} edges", "tori")
    for m in (5, 6, 7, 8, 10, 12, 16, 24):
        for width in (0.5, 1.0, 1.5):
            for samples in (1, SAMPLES):
                drawing = Drawing()
                draw_grid(
                    drawing,
                    lambda u, v, w=width: (
                        (3 + w * (2 * v - 1) * math.cos(math.pi * u)) * math.cos(2 * math.pi * u),
                        (3 + w * (2 * v - 1) * math.cos(math.pi * u)) * math.sin(2 * math.pi * u),
                        w * (2 * v - 1) * math.sin(math.pi * u),
                    ),
                    np.linspace(0, 1, m + 1).tolist(),
                    [0.0, 1.0],
                    lambda i, j, m=m: (i % m, j if i < m else 1 - j),
                    samples=samples,
                )
                name = f"Moebius strip of {m}, {width:g} wide, {samples} edges"
                yield drawing.finish(name, "Moebius strips")


def make_revolved(
    name: str,
    family: str,
    profile: Sequence[tuple[float, float]],
    m: int,
    samples: int,
    outline: Callable[[float], tuple[float, float]] | None = None,
) -> CleanNetwork:
    """A profile (radius, height) revolved, with m meridians; its open ends may have lids.

    outline: the profile as a curve, by shares from 0 to 1; without it a smooth one through the
    points.
    """
    drawing = Drawing()
    knots = np.arange(len(profile))
    smooth = PchipInterpolator(knots, np.array(profile), axis=0)

    def place(u: float, v: float) -> tuple[float, float, float]:
        if outline is not None:
            r, h = outline(v / (len(profile) - 1))
        elif samples > 1:
            r, h = smooth(v)
        else:
            r, h = profile[round(v)]
        return r * math.cos(2 * math.pi * u), r * math.sin(2 * math.pi * u), h

    def node(i: int, j: int) -> object:
        return ("pole", j) if profile[j][0] == 0.0 else (i % m, j)

    us = np.linspace(0, 1, m + 1).tolist()
    draw_grid(drawing, place, us, knots.tolist(), node, samples=samples)
    for j in (0, len(profile) - 1):
        if profile[j][0] > 0.0:
            drawing.lid([node(i, j) for i in range(m)])
    return drawing.finish(name, family)


def list_solids() -> Iterator[CleanNetwork]:
    """Boxes whose faces are divided, prisms, frusta, pyramids, an L, steps."""
    for counts in ((1, 1, 1), (2, 1, 1), (2, 2, 1), (2, 2, 2), (3, 2, 1), (3, 3, 3), (4, 3, 2)):
        for sides in ((1.0, 1.0, 1.0), (2.0, 1.0, 0.6), (3.0, 2.0, 0.4)):
            drawing = Drawing()
            draw_box(drawing, counts, sides)
            name = (
                "box " + " x ".join(map(str, counts)) + f", {sides[0]:g} {sides[1]:g} {sides[2]:g}"
            )
            yield drawing.finish(name, "boxes")
    for n in (3, 4, 5, 6, 8, 12):
        for height in (0.3, 1.3, 3.0):
            for top in (1.0, 0.6):
                drawing = Drawing()
                at = [2 * math.pi * i / n for i in range(n)]
                rings = [(1.0, 0.0), (top, height)]
                for k, (r, z) in enumerate(rings):
                    ring = [np.array([r * math.cos(a), r * math.sin(a), z]) for a in at]
                    for i in range(n):
                        drawing.line(
                            (k, i), (k, (i + 1) % n), np.array([ring[i], ring[(i + 1) % n]])
                        )
                    drawing.face([(k, i) for i in range(n)])
                for i, a in enumerate(at):
                    ends = [[r * math.cos(a), r * math.sin(a), z] for r, z in rings]
                    drawing.line((0, i), (1, i), np.array(ends))
                    drawing.face([(0, i), (0, (i + 1) % n), (1, (i + 1) % n), (1, i)])
                name = f"prism of {n}, {height:g} high, top {top:g}"
                yield drawing.finish(name, "prisms")


def draw_box(
    drawing: Drawing,
    counts: Sequence[int],
    sides: Sequence[float],
    open_sides: Sequence[tuple[int, int]] = (),
    bend: Callable[[Points], Points] = lambda at: at,
) -> None:
    """Draw a box whose faces are divided; some sides (axis, 0 or 1) may be left open."""
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, 1):
            if (axis, end) in open_sides:
                continue

            def node(
                i: int, j: int, axis: int = axis, a: int = a, b: int = b, end: int = end
            ) -> object:
                at = [0, 0, 0]
                at[axis], at[a], at[b] = end * counts[axis], i, j
                return tuple(at)

            def place(
                u: float, v: float, axis: int = axis, a: int = a, b: int = b, end: int = end
            ) -> Sequence[float]:
                at = np.zeros(3)
                at[axis], at[a], at[b] = end * sides[axis], u * sides[a], v * sides[b]
                return bend(at).tolist()

            us = np.linspace(0, 1, counts[a] + 1).tolist()
            vs = np.linspace(0, 1, counts[b] + 1).tolist()
            draw_grid(drawing, place, us, vs, node)


def list_joined() -> Iterator[CleanNetwork]:
    """Sheets that cross, walls and handles on a sheet, open boxes, shells like cars."""
    for m in (2, 4):
        for n in (1, 2, 3):
            drawing = Drawing()
            us, vs = np.linspace(-1, 1, m + 1).tolist(), np.linspace(0, 1, n + 1).tolist()
            for flat in (True, False):
                draw_grid(
                    drawing,
                    lambda u, v, flat=flat, n=n: (u, 0, n * v) if flat else (0, u, n * v),
                    us,
                    vs,
                    lambda i, j, flat=flat, m=m: (
                        (0, 0, j) if 2 * i == m else ("flat" if flat else "upright", i, j)
                    ),
                )
            yield drawing.finish(f"crossing sheets {m} x {n}", "crossing sheets")
    for m, n in ((2, 1), (2, 2), (4, 3)):
        for height in (0.5, 1.0):
            drawing = Drawing()
            us, vs = np.linspace(-1, 1, m + 1).tolist(), np.linspace(0, n, n + 1).tolist()
            draw_grid(drawing, lambda u, v: (u, v, 0), us, vs)
            draw_grid(
                drawing,
                lambda u, v, h=height: (0, v, h * u),
                [0.0, 1.0],
                vs,
                lambda i, j, m=m: ("top", j) if i else (m // 2, j),
            )
            yield drawing.finish(f"wall on {m} x {n}, {height:g} high", "walls")
    for height in (0.4, 0.8):
        for m in (6, 8):
            # A cup with a handle: a strip of three patches that begins and ends on a meridian.
            drawing = Drawing()
            at = np.linspace(0, 1, m + 1).tolist()
            draw_grid(
                drawing,
                lambda u, v: (math.cos(2 * math.pi * u), math.sin(2 * math.pi * u), 3 * v),
                at,
                np.linspace(0, 1, 4).tolist(),
                lambda i, j, m=m: (i % m, j),
                samples=SAMPLES,
            )
            drawing.lid([(i, 0) for i in range(m)])
            drawing.lid([(i, 3) for i in range(m)])
            step = 2 * math.pi / m
            sides = [(0, 1.0, 0.0), (1, math.cos(step), math.sin(step))]
            for k, x, y in sides:
                for z in (1, 2):
                    drawing.line(
                        (k, z), ("out", k, z), np.array([[x, y, z], [x + height, y, z]], float)
                    )
                ends = [[x + height, y, z] for z in (1, 2)]
                drawing.line(("out", k, 1), ("out", k, 2), np.array(ends, float))
            for z in (1, 2):
                ends = [[x + height, y, z] for _, x, y in sides]
                drawing.line(("out", 0, z), ("out", 1, z), np.array(ends, float))
                drawing.face([(0, z), (1, z), ("out", 1, z), ("out", 0, z)])
            drawing.face([("out", 0, 1), ("out", 1, 1), ("out", 1, 2), ("out", 0, 2)])
            for k in (0, 1):
                drawing.lid([(k, 1), (k, 2), ("out", k, 2), ("out", k, 1)])
            # A handle that is solid hides the wall behind it.
            drawing.lid([(0, 1), (1, 1), (1, 2), (0, 2)])
            yield drawing.finish(f"cup of {m} with a handle {height:g} out", "handles")
    for counts in ((1, 1, 1), (2, 2, 1), (3, 2, 2)):
        for sides in ((1.0, 1.0, 1.0), (2.0, 1.5, 0.5)):
            drawing = Drawing()
            draw_box(drawing, counts, sides, [(2, 1)])
            rim = [(i, 0, counts[2]) for i in range(counts[0])]
            rim += [(counts[0], j, counts[2]) for j in range(counts[1])]
            rim += [(i, counts[1], counts[2]) for i in range(counts[0], 0, -1)]
            rim += [(0, j, counts[2]) for j in range(counts[1], 0, -1)]
            drawing.lid([*rim])
            name = "open box " + " x ".join(map(str, counts)) + f", {sides[2]:g} high"
            yield drawing.finish(name, "open boxes")
    for roof in (0.5, 0.7):
        for arches in (False, True):
            for samples in (1, SAMPLES):
                yield make_car(roof, arches, samples)


def make_car(roof: float, arches: bool, samples: int) -> CleanNetwork:
    """A shell like a car's: bonnet, screens, roof, boot and sides, open below, with wheel arches.

    A section of six edges from sill to sill, at stations along the length; below the first station
    of a side a wheel arch may cut off its patch in a half circle.
    """
    drawing = Drawing()
    #: x, height of the middle, half width at the shoulder, height of the shoulder.
    stations = [
        (0.0, 0.62, 0.70, 0.55),
        (0.9, 0.78, 0.82, 0.68),
        (1.5, 0.82, 0.85, 0.72),
        (2.1, 0.80 + roof, 0.85, 0.75),
        (3.0, 0.80 + roof, 0.85, 0.76),
        (3.7, 0.85, 0.84, 0.75),
        (4.3, 0.75, 0.74, 0.66),
    ]
    smooth = PchipInterpolator(np.arange(len(stations)), np.array(stations), axis=0)

    def section(k: float) -> Points:
        x, top, half, shoulder = smooth(k)
        edge = 0.62 * half
        right = [(half * 0.97, 0.25), (half, shoulder), (edge, top)]
        ring = [(-w, z) for w, z in right] + [(w, z) for w, z in right[::-1]]
        return np.array([[x, w, z] for w, z in ring])

    def place(u: float, v: float) -> Points:
        ring = section(u)
        j = min(int(v), 4)
        return ring[j] + (v - j) * (ring[j + 1] - ring[j])

    def is_arch(i: int, j: int) -> bool:
        return arches and i in (0, 4) and j in (0, 4)

    us, vs = list(range(len(stations))), list(range(6))
    draw_grid(drawing, place, us, vs, samples=samples, without=is_arch)
    if arches:
        for i in (0, 4):
            for side in (0, 4):
                low, high = (0, 1) if side == 0 else (5, 4)
                ends = np.array([place(i, low), place(i + 1, low)])
                feet = [ends[0] + t * (ends[1] - ends[0]) for t in (0.2, 0.8)]
                middle, reach = (feet[0] + feet[1]) / 2, (feet[1] - feet[0]) / 2
                a = np.linspace(0.0, math.pi, 2 * SAMPLES + 1)
                up = np.array([0.0, 0.0, 0.3])
                arch = middle - np.cos(a)[:, None] * reach + np.sin(a)[:, None] * up
                drawing.line((i, low), ("foot", i, side, 0), np.array([ends[0], feet[0]]))
                drawing.line(("foot", i, side, 0), ("foot", i, side, 1), arch)
                drawing.line(("foot", i, side, 1), (i + 1, low), np.array([feet[1], ends[1]]))
                t = np.linspace(0.0, 1.0, samples + 1)
                line = np.array([place(i + s, high) for s in t])
                drawing.line((i, high), (i + 1, high), line)
                for k in (i, i + 1):
                    drawing.line((k, low), (k, high), np.array([place(k, low), place(k, high)]))
                drawing.face(
                    [
                        (i, low),
                        ("foot", i, side, 0),
                        ("foot", i, side, 1),
                        (i + 1, low),
                        (i + 1, high),
                        (i, high),
                    ]
                )
    for k in (0, len(stations) - 1):
        drawing.line((k, 0), (k, 5), np.array([place(k, 0), place(k, 5)]))
        drawing.face([(k, j) for j in range(6)])
    name = f"car, roof {roof:g} high{', wheel arches' if arches else ''}, {samples} edges"
    return drawing.finish(name, "car-like shells")


@cache
def list_clean_networks() -> tuple[CleanNetwork, ...]:
    """Return all of them, made once."""
    return (*list_sheets(), *list_closed_round(), *list_solids(), *list_joined())
