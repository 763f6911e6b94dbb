"""Drafts around random drawings on a ball.

    python benchmarks/draft_drawn.py [--drawings 40] [--seed 0]

Each drawing is one to four random loops, spines and strokes; then the rest is drafted with edges of
a tenth of the diameter. Counted are drawings of which the mesh came out whole (closed, nothing
tangled or without quads, all that was drawn where it was), those whose patches cover the ball, and
refusals by what they say. Prints Markdown.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np
import trimesh
from scipy.spatial import KDTree

import patterndb
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling.report import report_mesh
from patterndb_sketch.retopo.network import Network, check_network

EDGE = 0.2

#: What a refusal begins with, and what it is called in the table.
REASONS = {
    "patches cover": "patches all over",
    "no draft: curves would pass": "refused: lines would pass through each other",
    "no draft: a curve ends openly": "refused: an open end from which no line goes on",
    "no draft: the region": "refused: a region without corners",
    "no draft: quads would be": "refused: quads far off the surface",
    "no draft: there would be": "refused: quads more than 2 % off the surface",
    "curves are too close": "refused: curves too close for the edge",
    "what curves leave": "refused: regions smaller than an edge",
}


def make_call(rng: np.random.Generator) -> Call:
    """A random loop, spine or stroke on the unit ball."""
    at = rng.normal(size=3)
    at /= np.linalg.norm(at)
    if rng.random() < 0.3:
        return Call("loop", {"at": at.tolist(), "normal": rng.normal(size=3).tolist()})
    if rng.random() < 0.4:
        end = at + 0.3 * rng.normal(size=3)
        places = [at, 0.5 * (at + end), end]
        return Call("spine", {"points": [p.tolist() for p in places], "width": 0.4})
    middle = at + 0.7 * rng.normal(size=3)
    end = middle + 0.5 * rng.normal(size=3)
    places = [at, middle / np.linalg.norm(middle), end / np.linalg.norm(end)]
    return Call("stroke", {"points": [p.tolist() for p in places]})


def list_points(network: Network) -> np.ndarray:
    """(n, 3) the points of all curves."""
    return np.concatenate([np.empty((0, 3)), *(c.points for c in network.chains.values())])


def main() -> None:
    """Draw, draft, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--drawings", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    surface = Surface.of(trimesh.creation.icosphere(subdivisions=4)).orient()
    found: Counter[str] = Counter()
    flipped = quads = 0
    with patterndb.open() as database:
        for _ in range(options.drawings):
            editor = Retopology(surface, database)
            for _ in range(int(rng.integers(1, 5))):
                editor.do(make_call(rng))
                editor.fill()
            before = editor.network
            outcome = editor.do(Call("draft", {"edge": EDGE, "symmetry": False}))
            if outcome.refused is not None:
                known = [r for begin, r in REASONS.items() if outcome.refused.startswith(begin)]
                found[known[0] if known else outcome.refused] += 1
                continue
            check_network(editor.network, patches=False)
            filled = editor.fill()
            made = report_mesh(filled, surface)
            faults = made.unfilled + made.tangled + made.open_edges + abs(made.euler - 2)
            old = list_points(before)
            moved = len(old) and KDTree(list_points(editor.network)).query(old)[0].max()
            found["whole" if not faults and not moved else "spoiled"] += 1
            flipped += made.flipped
            quads += made.quads
    print("| what came of it | drawings |\n|---|---:|")
    for name, count in found.most_common():
        print(f"| {name} | {count} |")
    print(f"\n{flipped} of {quads:,} quads flipped")


if __name__ == "__main__":
    main()
