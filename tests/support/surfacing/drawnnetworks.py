"""Networks as people draw them, of which it is known which patches are meant.

A network is a set of smooth curves on a known surface. Each curve is sampled for itself, so that
curves cross between samples, and then drawn with a fault: too short, too long, off its place, off
at every sample, twice, in two parts that overlap, or with any of these. How much is a share of the
drawing's diagonal. A patch is named by the set of the curves that it runs along; lids that nothing
in the curves asks for may be found or not.

benchmarks/surfacing/drawn_cycles.py counts what is found of all of them, the tests of some.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.polyline import arc_length, at_lengths

Points = NDArray[np.float64]

#: A curve by a parameter (k,) from 0 to 1.
Track = Callable[[Points], Points]

#: A surface by two parameters (k,) from 0 to 1.
Sheet = Callable[[Points, Points], Points]

TURN = 2.0 * math.pi

#: Faults, and by how much curves are off, as shares of the diagonal.
FAULTS = ("gap", "overshoot", "noise", "jitter", "double", "overlap", "mix")
LEVELS = (1e-4, 1e-3, 3e-3, 1e-2)

#: Every network in so many sizes.
SIZES = 3

#: Samples of a curve: at least, and at most. Straight ones have few.
SAMPLES = 25, 90
STRAIGHT = 2, 8


@dataclass(slots=True)
class Design:
    """Curves, and the patches that they are meant to bound, by the names of curves."""

    tracks: dict[str, tuple[Track, bool, tuple[int, int]]] = field(default_factory=dict)
    meant: list[tuple[str, ...]] = field(default_factory=list)
    maybe: list[tuple[str, ...]] = field(default_factory=list)

    def add(
        self, name: str, track: Track, closed: bool = False, samples: tuple[int, int] = SAMPLES
    ) -> str:
        """Add a curve, and return its name."""
        self.tracks[name] = track, closed, samples
        return name

    def line(self, name: str, start: ArrayLike, end: ArrayLike) -> str:
        """Add a straight curve."""
        first, last = np.asarray(start, float), np.asarray(end, float)
        return self.add(name, lambda t: first + np.outer(t, last - first), samples=STRAIGHT)


@dataclass(frozen=True, slots=True)
class DrawnCurves:
    """A drawing: polylines by their names, and what is meant; ``name~`` is a stroke drawn again."""

    name: str
    family: str
    fault: str
    level: float
    curves: dict[str, Points] = field(repr=False)
    meant: Counter[frozenset[str]] = field(repr=False)
    maybe: Counter[frozenset[str]] = field(repr=False)

    def compare(self, cycles: Sequence[Sequence[object]]) -> tuple[int, int]:
        """Count the patches that are found among cycles, by names of curves, and the false ones."""
        found = Counter(frozenset(str(name).rstrip("~") for name in cycle) for cycle in cycles)
        hit = sum((self.meant & found).values())
        return hit, sum(((found - self.meant) - self.maybe).values())


def stack(*columns: ArrayLike) -> Points:
    """(k, 3) points of three columns."""
    return np.column_stack(np.broadcast_arrays(*columns)).astype(float)


def design_sheet(
    sheet: Sheet,
    counts: tuple[int, int],
    closed: tuple[bool, bool] = (False, False),
    *,
    lids: bool = False,
    samples: tuple[int, int] = SAMPLES,
) -> Design:
    """Draw lines at fixed parameters of a surface; all of their cells are meant."""
    design = Design()
    at = [np.linspace(0, 1, n + 1)[: n + (not c)] for n, c in zip(counts, closed, strict=True)]
    us = [
        design.add(f"u{i}", lambda t, u=u: sheet(np.full_like(t, u), t), closed[1], samples)
        for i, u in enumerate(at[0].tolist())
    ]
    vs = [
        design.add(f"v{j}", lambda t, v=v: sheet(t, np.full_like(t, v)), closed[0], samples)
        for j, v in enumerate(at[1].tolist())
    ]
    for i in range(counts[0]):
        for j in range(counts[1]):
            design.meant.append((us[i], us[(i + 1) % len(us)], vs[j], vs[(j + 1) % len(vs)]))
    for around, lines in ((closed[1], us), (closed[0], vs)):
        if lids and around:
            design.maybe += [(lines[0],), (lines[-1],)]
    return design


def design_torus(chance: np.random.Generator, size: int) -> Design:
    """Rings around the tube of a torus, and along it."""
    a = chance.uniform(0.25, 0.45)

    def sheet(u: Points, v: Points) -> Points:
        ring = 1.0 + a * np.cos(TURN * v)
        return stack(ring * np.cos(TURN * u), ring * np.sin(TURN * u), a * np.sin(TURN * v))

    return design_sheet(sheet, ((5, 3), (8, 4), (12, 6))[size], (True, True))


def design_cloth(chance: np.random.Generator, size: int) -> Design:
    """A sheet with waves."""
    k, b = chance.uniform(1, 3), chance.uniform(0.1, 0.3)

    def sheet(u: Points, v: Points) -> Points:
        wave = b * np.sin(k * u + 0.5) * np.cos(2.2 * v) + 0.2 * u * v
        return stack(2.0 * u, 1.4 * v, wave)

    return design_sheet(sheet, ((3, 2), (5, 4), (9, 7))[size])


def design_vase(chance: np.random.Generator, size: int) -> Design:
    """A vessel of revolution, open above and below."""
    p = chance.uniform(0.15, 0.3)

    def sheet(u: Points, v: Points) -> Points:
        radius = 0.5 + p * np.sin(5.0 * v + 0.4)
        return stack(radius * np.cos(TURN * u), radius * np.sin(TURN * u), 1.8 * v)

    return design_sheet(sheet, ((4, 3), (6, 5), (10, 8))[size], (True, False), lids=True)


def design_sphere(chance: np.random.Generator, size: int) -> Design:
    """Great circles through both poles of a ball, and circles of latitude."""
    design = Design()
    count, latitudes = ((3, [0.0]), (4, [-0.5, 0.5]), (6, [-0.8, -0.3, 0.3, 0.8]))[size]
    turn = chance.uniform(0, math.pi)
    for i in range(count):
        a = turn + math.pi * i / count
        design.add(
            f"m{i}",
            lambda t, a=a: stack(
                np.cos(a) * np.cos(TURN * t), np.sin(a) * np.cos(TURN * t), np.sin(TURN * t)
            ),
            True,
        )
    for j, at in enumerate(latitudes):
        design.add(
            f"l{j}",
            lambda t, at=at: stack(
                np.cos(at) * np.cos(TURN * t), np.cos(at) * np.sin(TURN * t), np.sin(at)
            ),
            True,
        )
    for i in range(2 * count):
        sides = f"m{i % count}", f"m{(i + 1) % count}"
        design.meant += [(*sides, "l0"), (*sides, f"l{len(latitudes) - 1}")]
        design.meant += [(*sides, f"l{j}", f"l{j + 1}") for j in range(len(latitudes) - 1)]
    return design


def design_rounded_box(chance: np.random.Generator, size: int) -> Design:
    """A box whose upright edges are rounded: rings of arcs and lines, uprights where these meet."""
    depth, height, q = chance.uniform(0.6, 0.9), chance.uniform(0.5, 0.8), chance.uniform(0.12, 0.2)
    centres = [(1 - q, depth - q), (q - 1, depth - q), (q - 1, q - depth), (1 - q, q - depth)]
    corners: list[Points] = []
    for k, (x, y) in enumerate(centres):
        angles = math.pi / 2 * (k + np.linspace(0, 1, 60))
        corners.append(stack(x + q * np.cos(angles), y + q * np.sin(angles), 0.0))
    ring = np.concatenate([*corners, corners[0][:1]])
    whole = float(arc_length(ring)[-1])
    design = Design()
    heights = np.linspace(0, height, (2, 3, 5)[size]).tolist()
    for i, z in enumerate(heights):
        design.add(
            f"r{i}",
            lambda t, z=z: at_lengths(ring, (t % 1.0) * whole) + np.array([0.0, 0.0, z]),
            True,
            (60, 120),
        )
    feet = [end for corner in corners for end in (corner[0], corner[-1])]
    for j, foot in enumerate(feet):
        design.line(f"e{j}", foot, foot + np.array([0.0, 0.0, height]))
    for i in range(len(heights) - 1):
        design.meant += [(f"r{i}", f"r{i + 1}", f"e{j}", f"e{(j + 1) % 8}") for j in range(8)]
    design.maybe += [("r0",), (f"r{len(heights) - 1}",)]
    return design


def design_prism(chance: np.random.Generator, size: int) -> Design:
    """The frame of a prism with three polygons and uprights that run past the middle one."""
    n = (4, 6, 9)[size]
    design = Design()
    angles = TURN * (np.arange(n) + chance.uniform(-0.2, 0.2, n)) / n
    polygon = stack(np.cos(angles), 0.8 * np.sin(angles), 0.0)
    levels = [np.array([0.0, 0.0, z]) for z in (0.0, 0.7, 1.3)]
    for k, up in enumerate(levels):
        for i in range(n):
            design.line(f"b{k},{i}", polygon[i] + up, polygon[(i + 1) % n] + up)
    for i in range(n):
        design.line(f"h{i}", polygon[i], polygon[i] + levels[-1])
    for k in range(2):
        for i in range(n):
            design.meant.append((f"b{k},{i}", f"b{k + 1},{i}", f"h{i}", f"h{(i + 1) % n}"))
    lids = [tuple(f"b{k},{i}" for i in range(n)) for k in range(3)]
    design.meant += [lids[0], lids[2]]
    design.maybe.append(lids[1])
    return design


def design_hull(chance: np.random.Generator, size: int) -> Design:
    """A boat that narrows to its stem."""
    b, d = chance.uniform(0.5, 0.7), chance.uniform(0.4, 0.6)

    def sheet(u: Points, v: Points) -> Points:
        beam = b * np.sqrt(np.clip(1 - (0.85 * u) ** 2.2, 0, 1))
        s = math.pi * (v - 0.5)
        keel = -d * (1 - 0.5 * u**2) * np.cos(s) + 0.25 * u**2
        return stack(3.0 * u, beam * np.sin(s), keel)

    return design_sheet(sheet, ((3, 2), (5, 4), (8, 6))[size])


def design_car(chance: np.random.Generator, size: int) -> Design:
    """A car's body with a bonnet and a boot, open below."""
    s = chance.uniform(0.25, 0.4)

    def sheet(u: Points, v: Points) -> Points:
        side = (0.9 - 0.15 * (2 * u - 1) ** 2) * np.cos(math.pi * v)
        roof = 0.75 + s * np.tanh(9 * (u - 0.3)) - s * np.tanh(9 * (u - 0.8))
        return stack(4.0 * u, side, roof * np.sin(math.pi * v) ** 0.8)

    return design_sheet(sheet, ((4, 3), (6, 4), (10, 6))[size], samples=(45, 120))


def design_elbow(chance: np.random.Generator, size: int) -> Design:
    """A pipe that bends by a quarter and then runs straight, open at both ends."""
    a = chance.uniform(0.25, 0.35)

    def sheet(u: Points, v: Points) -> Points:
        bend = np.clip(u / 0.6, 0, 1) * math.pi / 2
        on = np.clip((u - 0.6) / 0.4, 0, 1) * 1.1
        radius = 1.0 + a * np.cos(TURN * v)
        return stack(radius * np.cos(bend) - on, radius * np.sin(bend), a * np.sin(TURN * v))

    counts = ((3, 3), (5, 4), (8, 6))[size]
    return design_sheet(sheet, counts, (False, True), lids=True, samples=(40, 90))


def design_nose(chance: np.random.Generator, size: int) -> Design:
    """A blunt nose: rings, and stringers that all meet at its tip."""
    n, m = ((4, 2), (6, 4), (9, 6))[size]
    power = chance.uniform(0.5, 0.7)
    design = Design()
    for j in range(m):
        u = (j + 1) / m
        r = 0.6 * u**power
        design.add(
            f"r{j}",
            lambda t, u=u, r=r: stack(r * np.cos(TURN * t), r * np.sin(TURN * t), 1.7 * u),
            True,
        )
    for i in range(n):
        a = TURN * i / n
        design.add(
            f"s{i}",
            lambda t, a=a: stack(0.6 * t * np.cos(a), 0.6 * t * np.sin(a), 1.7 * t ** (1 / power)),
        )
    for i in range(n):
        sides = f"s{i}", f"s{(i + 1) % n}"
        design.meant += [(*sides, "r0")]
        design.meant += [(*sides, f"r{j}", f"r{j + 1}") for j in range(m - 1)]
    design.maybe.append((f"r{m - 1}",))
    return design


def design_saddle(chance: np.random.Generator, size: int) -> Design:
    """A saddle."""
    k = chance.uniform(0.4, 0.8)

    def sheet(u: Points, v: Points) -> Points:
        x, y = 2 * u - 1, 2 * v - 1
        return stack(x, y, k * (x**2 - y**2))

    return design_sheet(sheet, ((2, 3), (4, 4), (7, 6))[size])


def design_chair(chance: np.random.Generator, size: int) -> Design:
    """A seat, cushions and legs, each a box of straight edges that touches no other."""
    design = Design()

    def box(tag: str, low: Sequence[float], high: Sequence[float]) -> None:
        places = list_corners(low, high)
        edges = {
            frozenset((p, p | b)): design.line(f"{tag}{p}{p | b}", places[p], places[p | b])
            for p in range(8)
            for b in (1, 2, 4)
            if not p & b
        }
        faces = ("0132", "4576", "0154", "2376", "0264", "1375")
        for face in (list(map(int, word)) for word in faces):
            around = zip(face, face[1:] + face[:1], strict=True)
            design.meant.append(tuple(edges[frozenset(pair)] for pair in around))

    width = chance.uniform(0.9, 1.2)
    box("seat", (0, 0, 1), (width, 1, 1.2))
    for k in range((0, 1, 3)[size]):
        box(f"cushion{k}.", (0.1 + 0.3 * k, 0.3, 1.45), (0.3 + 0.3 * k, 0.45, 2.2))
    feet = [(0.1, 0.1), (width - 0.3, 0.1), (0.1, 0.7), (width - 0.3, 0.7)]
    for k, (x, y) in enumerate(feet[: (2, 4, 4)[size]]):
        box(f"leg{k}.", (x, y, 0), (x + 0.2, y + 0.2, 0.85))
    return design


def list_corners(low: ArrayLike, high: ArrayLike) -> list[Points]:
    """List the eight corners of a box; the bits of their numbers: on which side in x, y, z."""
    x, y, z = np.stack([low, high]).astype(float).T
    return [np.array([x[p >> 2], y[p >> 1 & 1], z[p & 1]]) for p in range(8)]


#: Constants were chosen on the families of the first half; those of the second only report.
HALVES: dict[str, dict[str, Callable[[np.random.Generator, int], Design]]] = {
    "first": {
        "torus": design_torus,
        "cloth": design_cloth,
        "vase": design_vase,
        "sphere": design_sphere,
        "rounded box": design_rounded_box,
        "prism": design_prism,
    },
    "second": {
        "hull": design_hull,
        "car": design_car,
        "elbow": design_elbow,
        "nose": design_nose,
        "saddle": design_saddle,
        "chair": design_chair,
    },
}


def sample_track(
    track: Track, closed: bool, samples: tuple[int, int], chance: np.random.Generator
) -> Points:
    """Sample a curve about evenly; a closed one from any place on."""
    t = np.linspace(0, 1, 2001)
    along = arc_length(track(t))
    n = int(chance.integers(samples[0], samples[1] + 1))
    share = np.linspace(0, 1, n)
    if n > 4:
        share[1:-1] += chance.uniform(-0.25, 0.25, n - 2) / (n - 1)
    if closed:
        share = (share + chance.uniform(0, 1)) % 1.0
        share[-1] = share[0]
    return track(np.interp(share * along[-1], along, t))


def is_closed(line: Points) -> bool:
    return bool(np.allclose(line[0], line[-1], rtol=0, atol=1e-12))


def cut_out(line: Points, begin: float, end: float) -> Points:
    """Take the part of a polyline between two arc lengths."""
    along = arc_length(line)
    margin = 1e-9 * along[-1]
    inner = line[(along > begin + margin) & (along < end - margin)]
    return np.concatenate([at_lengths(line, [begin]), inner, at_lengths(line, [end])])


def shorten(line: Points, off: float, chance: np.random.Generator) -> Points:
    """Take up to ``off`` from both ends of an open curve."""
    if is_closed(line):
        return line
    last = float(arc_length(line)[-1])
    first, second = np.minimum(chance.uniform(0.3, 1, 2) * off, 0.2 * last).tolist()
    return cut_out(line, first, last - second)


def lengthen(line: Points, off: float, chance: np.random.Generator) -> Points:
    """Go on by up to ``off`` beyond both ends of an open curve."""
    if is_closed(line):
        return line
    first, last = line[0] - line[1], line[-1] - line[-2]
    a, b = chance.uniform(0.3, 1, 2) * off
    before = line[0] + a * first / np.linalg.norm(first)
    return np.concatenate([before[None], line, (line[-1] + b * last / np.linalg.norm(last))[None]])


def wobble(line: Points, off: float, chance: np.random.Generator) -> Points:
    """Move a curve smoothly, by up to ``off``."""
    along = arc_length(line)
    share = along / along[-1]
    moves = np.zeros_like(line)
    for k in range(3):
        phase = chance.uniform(0, TURN) if k else 0.0
        wave = np.cos((TURN if is_closed(line) else math.pi) * k * share + phase)
        moves += chance.normal(size=3) * wave[:, None] / (1 + k)
    if is_closed(line):
        moves[-1] = moves[0]
    greatest = np.linalg.norm(moves, axis=1).max()
    return line + moves * (off * chance.uniform(0.3, 1) / greatest)


def shake(line: Points, off: float, chance: np.random.Generator) -> Points:
    """Move every sample for itself, by up to 0.6 of ``off``."""
    moves = chance.normal(size=line.shape)
    moves *= (off * chance.uniform(0, 0.6, len(line)) / np.linalg.norm(moves, axis=1))[:, None]
    if is_closed(line):
        moves[-1] = moves[0]
    return line + moves


def draw_design(
    design: Design, fault: str, level: float, chance: np.random.Generator
) -> dict[str, Points]:
    """Draw the curves of a design with a fault of so many diagonals."""
    t = np.linspace(0, 1, 201)
    places = np.concatenate([track(t) for track, _, _ in design.tracks.values()])
    diagonal = float(np.linalg.norm(np.ptp(places, axis=0)))
    drawn: dict[str, Points] = {}
    for name, (track, closed, samples) in design.tracks.items():
        faults, off = {fault}, level * diagonal
        if fault == "mix":
            faults = {one for one in FAULTS[:-1] if chance.random() < 0.25}
            off *= chance.choice([0.0, 0.1, 0.3, 1.0])
        straight = samples == STRAIGHT
        if fault == "sparse" and not straight:
            samples = max(9, samples[0] // 4), max(14, samples[1] // 2)
        line = sample_track(track, closed, samples, chance)
        again: Points | None = None
        if "overlap" in faults and not closed and chance.random() < 0.5:
            other = sample_track(track, closed, samples, chance)
            last = float(arc_length(line)[-1])
            at = chance.uniform(0.35, 0.65) * last
            again = cut_out(other, at - last / 12, float(arc_length(other)[-1]))
            line = cut_out(line, 0.0, at + last / 12)
            again = wobble(again, 0.5 * off, chance) if off else again
        elif "double" in faults and chance.random() < (0.4 if fault == "double" else 0.6):
            again = sample_track(track, closed, samples, chance)
            if chance.random() < 0.6:
                a, b = np.sort(chance.uniform(0, 1, 2)).tolist()
                last = float(arc_length(again)[-1])
                again = cut_out(again, *((a * last, b * last) if b - a > 0.25 else (0, 0.4 * last)))
            again = wobble(again, max(off, 1e-7 * diagonal), chance)
            again = again[::-1] if chance.random() < 0.5 else again
        if "noise" in faults and off:
            line = wobble(line, off, chance)
        if "jitter" in faults and off and not straight:
            line = shake(line, off, chance)
        if "gap" in faults and off and not ("overshoot" in faults and chance.random() < 0.5):
            line = shorten(line, off, chance)
        elif "overshoot" in faults and off:
            line = lengthen(line, off, chance)
        drawn[name] = line
        if again is not None:
            drawn[f"{name}~"] = np.ascontiguousarray(again)
    return drawn


def draw_network(
    half: str, family: str, size: int, fault: str, level: float, seed: int
) -> DrawnCurves:
    """Draw a network of a family with a fault."""
    families = list(HALVES[half])
    faults = ("clean", "sparse", *FAULTS)
    keys = [list(HALVES).index(half), families.index(family), size, faults.index(fault)]
    chance = np.random.default_rng([seed, *keys, round(1e6 * level)])
    design = HALVES[half][family](chance, size)
    return DrawnCurves(
        f"{family} {size}, {fault} {level:g}",
        family,
        fault,
        level,
        draw_design(design, fault, level, chance),
        Counter(map(frozenset, design.meant)),
        Counter(map(frozenset, design.maybe)),
    )


def list_drawn_networks(half: str, seed: int = 1) -> Iterator[DrawnCurves]:
    """List all networks of a half: every family in every size with every fault at every level."""
    jobs = [("clean", 0.0), ("sparse", 0.0)]
    jobs += [(fault, level) for fault in FAULTS for level in LEVELS]
    for family in HALVES[half]:
        for size in range(SIZES):
            for fault, level in jobs:
                yield draw_network(half, family, size, fault, level, seed)
