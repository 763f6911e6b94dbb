"""Fills placed on regions of real surfaces: are quads flipped, and how long does it take?

    python benchmarks/placing.py --surfaces ../shared/data/surfaces --db all.db

Cuts regions out of every OBJ file of the folder: from a random place corners are reached by
walking straight ahead on the surface in N directions, and joined by elastic strings on the
surface; N is 3 to 8, a side has 2 to 8 edges. The first fill of every boundary is placed.
Regions are drawn anew where strings cross, or where they do not bound a disk on the surface.
Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import statistics
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from query import Boundary, Fill, fills
from query.placing import Placement, Surface, lay_flat, measure_flow_distance, place, quality
from query.placing.region import enclose_region
from query.stroke import Stroke

#: Points on an elastic string, and rounds in which it is drawn tight.
STRING = 49
TIGHTENED = 200

#: Steps of a walk.
STEPS = 40


def walk(surface: Surface, start: Points, direction: Points, length: float) -> Points:
    """Where one arrives who walks straight ahead on the surface."""
    at = surface.nearest(start[None])
    for _ in range(STEPS):
        ahead = direction - (direction @ at.normals[0]) * at.normals[0]
        direction = ahead / np.linalg.norm(ahead)
        at = surface.nearest(at.points + direction * length / STEPS)
    return at.points[0]


def string(surface: Surface, a: Points, b: Points) -> Points:
    """A tight string on the surface from a to b."""
    line = surface.nearest(np.linspace(a, b, STRING)).points
    for _ in range(TIGHTENED):
        line[1:-1] = surface.nearest((line[:-2] + line[2:]) / 2.0).points
    line[0], line[-1] = a, b
    return line


def crossing(loop: Points) -> bool:
    """Does a closed polygon come nearer to itself than a quarter of its edges?"""
    n = len(loop)
    gap = np.linalg.norm(loop[:, None] - loop, axis=2)
    around = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    far = np.minimum(around, n - around) > 1
    edge = np.linalg.norm(loop - np.roll(loop, -1, axis=0), axis=1)
    return bool((gap[far] < 0.5 * edge.min()).any()) or edge.min() < 0.2 * edge.mean()


def region(surface: Surface, chance: np.random.Generator) -> Boundary | None:
    """A boundary on the surface; None if it came out crossed or around no disk."""
    n = int(chance.integers(3, 9))
    at = surface.nearest(surface.vertices[[chance.choice(surface.triangles.ravel())]])
    normal = at.normals[0]
    helper = np.eye(3)[np.abs(normal).argmin()]
    u = np.cross(helper, normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    radius = surface.diagonal * chance.uniform(0.03, 0.2)
    turn = 2.0 * np.pi * (np.arange(n) + chance.uniform(-0.2, 0.2, n)) / n + chance.uniform(0, 7)
    corners = [
        walk(surface, at.points[0], np.cos(t) * u + np.sin(t) * v, radius * r)
        for t, r in zip(turn, chance.uniform(0.8, 1.0, n), strict=True)
    ]
    lengths = chance.integers(2, 9, n).tolist()
    lengths[0] += 1 if sum(lengths) % 2 and lengths[0] < 8 else -(sum(lengths) % 2)
    sides = [string(surface, corners[i], corners[(i + 1) % n]) for i in range(n)]
    boundary = Boundary.from_polylines(sides, lengths=lengths)
    assert boundary.points is not None
    points = surface.nearest(boundary.points).points
    if crossing(points):
        return None
    enclosing = enclose_region(surface, points)
    if not enclosing.is_disk or enclosing.share > 0.6:
        return None
    return Boundary(lengths, points=points)


@dataclass(frozen=True, slots=True)
class Case:
    """One placed fill."""

    boundary: Boundary
    fill: Fill
    placement: Placement
    seconds: float


def cases(
    surface: Surface, db: patterndb.Database, count: int, chance: np.random.Generator
) -> tuple[list[Case], int]:
    """So many placed fills, and how many regions were drawn anew."""
    found: list[Case] = []
    anew = 0
    while len(found) < count:
        boundary = region(surface, chance)
        if boundary is None:
            anew += 1
            continue
        fill = next(iter(fills(db, boundary, limit=1)), None)
        if boundary.points is None or fill is None:
            anew += 1
            continue
        started = time.perf_counter()
        placement = place(fill, boundary.points, surface)
        seconds = time.perf_counter() - started
        assert (placement.vertices[: boundary.perimeter] == boundary.points).all()
        found.append(Case(boundary, fill, placement, seconds))
    return found, anew


def row(name: str, surface: Surface, found: list[Case], anew: int) -> str:
    flips = sum(len(case.placement.flipped) for case in found)
    wrong = sum(len(case.placement.flipped) > 0 for case in found)
    off = max(case.placement.off_surface for case in found) / surface.diagonal
    rounds = [case.placement.rounds for case in found]
    unsettled = sum(not case.placement.at_rest for case in found)
    ms = sorted(1000.0 * case.seconds for case in found)
    quads = sum(case.fill.n_quads for case in found)
    return (
        f"| {name} | {len(surface.triangles):,} | {len(found)} | {anew} | {quads:,} | {flips} | "
        f"{wrong} | {statistics.median(rounds):.0f} / {max(rounds)} | {unsettled} | {off:.0e} | "
        f"{statistics.median(ms):.0f} / {ms[-1]:.0f} |"
    )


def fast_path(db: patterndb.Database) -> str:
    """What ranking one boundary's fills costs a fill."""
    turn = 2.0 * np.pi * np.arange(48) / 48
    points = np.stack([np.cos(turn), np.sin(turn), 0.1 * np.cos(2.0 * turn)], axis=1)
    boundary = Boundary((8,) * 6, points=points)
    listed = list(fills(db, boundary, limit=300))
    stroke = Stroke((0, 4), (3, 3), points[[4, 28]])
    took = np.zeros((len(listed), 3))
    for _ in range(2):
        for k, fill in enumerate(listed):
            start = time.perf_counter()
            vertices = lay_flat(fill, points)
            laid_at = time.perf_counter()
            quality(fill.quads, vertices)
            squared_at = time.perf_counter()
            measure_flow_distance(fill, vertices, [stroke])
            took[k] = np.diff([start, laid_at, squared_at, time.perf_counter()])
    vertices = statistics.median(fill.n_vertices for fill in listed)
    lay, square, flow = (1e6 * np.median(took, axis=0)).tolist()
    return (
        f"{len(listed)} fills of a hexagon of 48 edges, median {vertices:.0f} vertices: laid out "
        f"in {lay:.0f} µs, quality {square:.0f} µs, flow distance of one stroke {flow:.0f} µs "
        "(medians)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--surfaces", type=Path, required=True, help="a folder of OBJ files")
    parser.add_argument("--db", type=Path, help="the starter database if not given")
    parser.add_argument("--count", type=int, default=10, help="regions a surface")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with patterndb.open(arguments.db) as db:
        print(
            "| surface | triangles | regions | drawn anew | quads | flipped | fills with flipped"
            " | rounds median / most | not at rest | off surface | ms median / most |"
        )
        print("|---|" + "---:|" * 10)
        paths = sorted(arguments.surfaces.glob("*.obj"))
        for path in paths:
            surface = Surface.from_polygons(read_mesh(path))
            chance = np.random.default_rng(arguments.seed)
            if path == paths[0]:
                cases(surface, db, 1, chance)  # the database is read
            found, anew = cases(surface, db, arguments.count, chance)
            print(row(path.stem, surface, found, anew), flush=True)
        print("\n" + fast_path(db))


if __name__ == "__main__":
    main()
