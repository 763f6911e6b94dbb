"""Nearest points and line hits on a surface: the own tree beside trimesh.

    python benchmarks/triangle_tree.py ../shared/data/surfaces/spot.obj

200 random points near the surface, medians of 7 runs; prints how far the answers differ too.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

from query.placing import Surface

POINTS, RUNS = 200, 7


def median(work: Callable[[], object]) -> float:
    """Milliseconds, after a first run that does not count."""
    work()
    taken: list[float] = []
    for _ in range(RUNS):
        begin = time.perf_counter()
        work()
        taken.append(1e3 * (time.perf_counter() - begin))
    return float(np.median(taken))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("surface", type=Path)
    given = parser.parse_args()
    mesh = trimesh.load(given.surface, force="mesh", process=False)
    surface = Surface.of(mesh)
    chance = np.random.default_rng(1)
    at = mesh.vertices[chance.choice(len(mesh.vertices), POINTS)]
    at = at + 0.01 * mesh.scale * chance.normal(size=at.shape)
    way = chance.normal(size=at.shape)
    way /= np.linalg.norm(way, axis=1)[:, None]
    theirs = trimesh.proximity.ProximityQuery(mesh)
    differ = theirs.on_surface(at)[1] - np.linalg.norm(surface.nearest(at).points - at, axis=1)
    print(f"{len(mesh.faces):,} triangles, {POINTS} points, ms: own tree, trimesh")
    nearest = median(lambda: surface.nearest(at)), median(lambda: theirs.on_surface(at))
    hits = (
        median(lambda: surface.along(at, way)),
        median(lambda: mesh.ray.intersects_location(at, way)),
    )
    print(f"nearest points: {nearest[0]:.1f}, {nearest[1]:.1f}")
    print(f"hits of lines: {hits[0]:.1f}, {hits[1]:.1f}")
    print(f"greatest difference of distances: {np.abs(differ).max() / mesh.scale:.0e} of the scale")


if __name__ == "__main__":
    main()
