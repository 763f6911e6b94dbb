"""Pairs of border loops of artists' meshes that are mirror images of each other, both filled.

    python benchmarks/mirrored_holes.py --shared ../shared

Each pair is filled once hole by hole, and once the second with what fills the first. Counted are
the pairs whose best fills are the same, mirrored, flipped quads of the second, and seconds of work
for it. Meshes of more than 30 even loops are left out, and pairs with an island within.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import patterndb
from ingest.formats import read_mesh
from patterndb._native.query.recognition import weld_quads
from patterndb.errors import InvalidMeshError
from query.holes import Hole, HoleFill, MeshTopology, fill_holes, find_holes
from query.holes.symmetry import prepare_twins
from query.recognition import hash_quads

MOST_LOOPS = 30


def list_pairs(path: Path) -> Iterator[tuple[Hole, Hole]]:
    """Pairs of loops of a mesh that a plane mirrors onto each other, nearly."""
    topology = MeshTopology.of(read_mesh(path))
    loops = [hole for hole in find_holes(topology) if len(hole) % 2 == 0]
    if len(loops) <= MOST_LOOPS:
        finder = prepare_twins(topology)
        for one, two in combinations(loops, 2):
            if finder.match(two, one) is not None:
                yield one, two


def is_mirrored(one: HoleFill, two: HoleFill) -> bool:
    """Is the second fill the mirror image of the first, quad by quad?"""
    match = prepare_twins(one.hole.topology).match(two.hole, one.hole)
    assert match is not None
    n, n_vertices = len(one.hole), len(one.hole) + len(one.points)
    if one.local.shape != two.local.shape or len(one.points) != len(two.points):
        return False
    keys = [
        hash_quads(quads, weld_quads(quads, n_vertices, n)[0], False)
        for quads in (match.mirror_quads(one.local, n_vertices), two.local)
    ]
    return keys[0] == keys[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    arguments = parser.parse_args()
    pairs = 0
    ways = ("by itself", "like the other")
    same, flipped, seconds = (dict.fromkeys(ways, 0.0) for _ in range(3))
    with patterndb.open() as database:
        for path in sorted((arguments.shared / "data" / "meshes").glob("*.obj")):
            for one, two in list_pairs(path):
                try:
                    first = next(fill_holes(database, one))
                    asked = [fill_holes(database, two, like=like) for like in ((), (first,))]
                    filled = [next(found) for found in asked]
                except InvalidMeshError as error:
                    print(f"{path.name}: {error}")
                    continue
                pairs += 1
                for way, fill, found in zip(ways, filled, asked, strict=True):
                    same[way] += is_mirrored(first, fill)
                    flipped[way] += fill.flipped
                    seconds[way] += found.seconds
    print(f"\n{pairs} pairs\n\n| the second | the same, mirrored | flipped quads | s |")
    print("|---|---:|---:|---:|")
    for way in ways:
        print(f"| {way} | {same[way]:.0f} | {flipped[way]:.0f} | {seconds[way]:.2f} |")


if __name__ == "__main__":
    main()
