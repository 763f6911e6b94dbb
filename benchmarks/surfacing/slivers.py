"""How well shaped are the faces of patches, and do their edges follow the samples of the curves?

    python benchmarks/surfacing/slivers.py [--shared ../shared] [--count 100]

Of the patches of bent_patches.py, along and across the flow, and of all cycles found in the CASSIE
sketches, by every method. Of each patch the least angle of every triangle in degrees (of least
area, which has no vertices inside, too), and how long edges inside are, as a ratio to the mean edge

Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from bent_patches import PER_MESH, SEED, cut_patches, turn_across
from ours import OURS
from synthetic_cycles import spacing_of

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.cycles import find_cycles
from patterndb_sketch.surfacing.networkfile import read_network
from patterndb_sketch.surfacing.sampling import (
    Loop,
    default_spacing,
    loop_of,
    sample,
)
from tests.support.surfacing.intended import of_net

#: Triangles with a smaller angle, in degrees, are slivers.
SLIVER = 10.0

METHODS = ("smooth", "chords", "one piece", "area")


@dataclass(frozen=True, slots=True)
class Shape:
    """Least angles (t,) of triangles, in degrees, and inner edges (e,) as ratios to the loop's."""

    angles: Floats
    edges: Floats


def least_angles(points: Points, triangles: np.ndarray) -> Floats:
    """(t,) the least angle of every triangle in degrees; 0 of those without area."""
    sides = np.stack(
        [
            np.linalg.norm(points[triangles[:, k - 1]] - points[triangles[:, k - 2]], axis=1)
            for k in range(3)
        ]
    )
    short, middle, long = np.sort(sides, axis=0)
    cosine = (middle**2 + long**2 - short**2) / np.maximum(2 * middle * long, 1e-300)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def measure_shape(loop: Loop, points: Points, triangles: np.ndarray) -> Shape:
    n = len(loop.points)
    edges = np.unique(
        np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1), axis=0
    )
    after = (edges[:, 1] - edges[:, 0]) % n
    on_loop = (edges < n).all(axis=1) & ((after == 1) | (after == n - 1))
    a, b = points[edges[~on_loop]].transpose(1, 0, 2)
    return Shape(least_angles(points, triangles), np.linalg.norm(a - b, axis=1) / spacing_of(loop))


def row(name: str, shapes: list[Shape]) -> str:
    angles = np.concatenate([one.angles for one in shapes])
    edges = np.concatenate([one.edges for one in shapes])
    worst = np.array([one.angles.min() for one in shapes])
    cells = [
        name,
        f"{len(angles):,}",
        f"{np.median(angles):.0f}",
        f"{np.percentile(angles, 5):.0f}",
        f"{100 * (angles < SLIVER).mean():.1f}%",
        f"{np.median(worst):.0f}",
        *(f"{value:.2f}" for value in np.percentile(edges, [5, 50, 95])),
    ]
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| method | triangles | least angle: median | 5 % | slivers | least of a patch: median | "
    "edges: 5 % | median | 95 % |\n|---|" + "---:|" * 8
)


def report(title: str, loops: list[Loop]) -> None:
    print(f"\n{title}: {len(loops)} loops\n\n{HEAD}")
    for name in METHODS:
        fillings = [(loop, OURS[name](loop, spacing_of(loop))) for loop in loops]
        shapes = [measure_shape(loop, one.vertices, one.triangles) for loop, one in fillings]
        print(row(name, shapes), flush=True)


def sketched(folder: Path) -> Iterator[Loop]:
    """The loops of all cycles of the sketches."""
    for path in sorted(folder.glob("*.json")):
        network = read_network(path)
        sampling = sample(network, default_spacing(network))
        for cycle in find_cycles(network).cycles:
            try:
                yield loop_of(network, sampling, cycle)
            except InvalidNetworkError:
                continue


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--count", type=int, default=100, help="patches")
    args = parser.parse_args()
    data = args.shared / "data"
    nets: list[tuple[str, Points]] = []
    for k in (0, 1):
        half = [
            patch
            for path in sorted((data / "meshes").glob("*.obj"))[k::2]
            for patch, _ in zip(cut_patches(path), range(PER_MESH), strict=False)
        ]
        rng = np.random.default_rng(SEED)
        nets += [half[i] for i in sorted(rng.permutation(len(half))[: args.count // 2].tolist())]
    for way, some in (("along", nets), ("across", [(t, turn_across(net)) for t, net in nets])):
        loops = [replace(of_net(title, "", net), name=title).loop for title, net in some]
        report(f"Bent patches, {way} the flow", loops)
    report("CASSIE sketches", list(sketched(data / "curves" / "cassie" / "graph")))


if __name__ == "__main__":
    main()
