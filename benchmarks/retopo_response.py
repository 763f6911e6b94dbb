"""How fast retopology answers, on a surface of some 100,000 triangles.

    OMP_NUM_THREADS=1 python benchmarks/retopo_response.py [--triangles 100000] [--times 20]

A hilly sheet with a network of 20 patches. Measured, each many times on the same state: a stroke
that closes another patch, until its quads lie on the surface; suggestions for a patch under the
cursor; a spine's preview; one count changed by 1 until all quads lie again; the list of fills of
a patch. Prints a table in Markdown: medians and the slowest, in milliseconds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np

import patterndb
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import change_counts, choose_counts, rank_fills
from patterndb_sketch.retopo.network import check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.autocomplete import find_completions
from patterndb_sketch.retopo.tools.spine import preview_spine
from patterndb_sketch.retopo.tracing import clean_stroke

#: Columns and rows of patches, and the sheet's side.
COLUMNS, ROWS, SIDE = 5, 4, 10.0

#: Columns and rows of a network of many patches.
MANY = 20, 10


def hills(triangles: int) -> Surface:
    """A hilly sheet."""
    n = round(np.sqrt(triangles / 2.0))
    x, y = np.meshgrid(np.linspace(0, SIDE, n + 1), np.linspace(0, SIDE, n + 1), indexing="ij")
    z = 0.4 * np.sin(1.3 * x) * np.cos(1.1 * y)
    k = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([k, k + n + 1, k + n + 2, k + 1], axis=1)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return Surface.from_arrays(np.stack([x, y, z], axis=-1).reshape(-1, 3), faces).orient()


def line(*points: tuple[float, float]) -> list[list[float]]:
    """A stroke over these places."""
    found: list[list[float]] = []
    for a, b in pairwise(points):
        for t in np.linspace(0, 1, 30):
            x, y = np.add(np.multiply(a, 1 - t), np.multiply(b, t))
            found.append([float(x), float(y), float(0.4 * np.sin(1.3 * x) * np.cos(1.1 * y))])
    return found


def drawn(
    surface: Surface, source: patterndb.Database, columns: int = COLUMNS, rows: int = ROWS
) -> Retopology:
    """An editor with columns x rows patches in the middle of the sheet."""
    editor = Retopology(surface, source, Sizes.of(surface.diagonal))
    xs, ys = np.linspace(1.5, 7.5, columns + 1), np.linspace(1.5, 7.5, rows + 1)
    corners = [(xs[0], ys[0]), (xs[-1], ys[0]), (xs[-1], ys[-1]), (xs[0], ys[-1]), (xs[0], ys[0])]
    for a, b in pairwise(corners):
        editor.do(Call("stroke", {"points": line(a, b)}))
    for x in xs[1:-1]:
        editor.do(Call("stroke", {"points": line((x, ys[0]), (x, ys[-1]))}))
    for y in ys[1:-1]:
        editor.do(Call("stroke", {"points": line((xs[0], y), (xs[-1], y))}))
    editor.fill()
    check_network(editor.network)
    return editor


def timed(act: Callable[[], object], reset: Callable[[], object], times: int) -> list[float]:
    """Milliseconds of an act, done and taken back many times; the first is not counted."""
    found: list[float] = []
    for _ in range(times + 1):
        begun = time.perf_counter()
        act()
        found.append(1000.0 * (time.perf_counter() - begun))
        reset()
    return found[1:]


def recounted(
    surface: Surface, source: patterndb.Database, times: int
) -> list[tuple[str, list[float]]]:
    """Counts of MANY patches, chosen anew and changed one by one."""
    editor = drawn(surface, source, *MANY)
    edge = editor.sizes.edge
    network, _ = choose_counts(editor.network, edge)
    name = f"{MANY[0] * MANY[1]} patches"
    anew = timed(lambda: choose_counts(network, edge), int, max(1, times // 4))
    chance = np.random.default_rng(1)
    steps: list[float] = []
    most = 0
    for chain in chance.choice(sorted(network.chains), times + 1):
        count = max(1, network.chains[chain].count + int(chance.choice([-2, -1, 1, 2])))
        begun = time.perf_counter()
        after, _ = change_counts(network, edge, {int(chain): count})
        steps.append(1000.0 * (time.perf_counter() - begun))
        others = sum(after.chains[c].count != network.chains[c].count for c in network.chains)
        most = max(most, others)
    return [
        (f"all counts of {name} chosen anew", anew),
        (f"one count of {name} changed, {most} chains at most", steps[1:]),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--triangles", type=int, default=100_000)
    parser.add_argument("--times", type=int, default=20)
    given = parser.parse_args()
    surface = hills(given.triangles)
    with patterndb.open() as source:
        editor = drawn(surface, source)
        inside = len(editor.network.patches)

        def stroke() -> None:
            outcome = editor.do(
                Call("stroke", {"points": line((7.5, 1.5), (9.0, 1.6), (9.0, 2.9), (7.5, 3.0))})
            )
            assert outcome.changed, outcome.refused
            editor.fill()
            assert len(editor.network.patches) == inside + 1

        def undo() -> None:
            editor.do(Call("undo"))
            editor.fill()

        at = surface.nearest([[7.5, 3.7, 0.0]])
        edge = next(iter(editor.network.patches.values()))

        def count() -> None:
            outcome = editor.do(Call("subdivide", {"at": line((4.5, 3.05), (5, 3))[0], "by": 1}))
            assert outcome.changed, outcome.refused
            editor.fill()

        def suggest() -> object:
            return find_completions(
                editor.network, surface, at.points[0], at.normals[0], editor.sizes
            )

        assert suggest()
        spine = clean_stroke(line((8.6, 3.2), (8.7, 6.0)), surface, editor.sizes, closed=False)
        rows = [
            ("stroke to filled patch", timed(stroke, undo, given.times)),
            ("suggestions under the cursor", timed(suggest, int, given.times)),
            (
                "a spine's preview",
                timed(
                    lambda: preview_spine(editor.network, surface, spine, editor.sizes),
                    int,
                    given.times,
                ),
            ),
            ("a count changed by 1", timed(count, undo, given.times)),
            (
                "list of 40 fills of a patch",
                timed(lambda: list(rank_fills(editor.network, edge, source)), int, given.times),
            ),
        ]
        rows += recounted(surface, source, given.times)
        print(f"{len(surface.triangles):,} triangles, {inside} patches\n")
    print("| what | median, ms | slowest, ms |")
    print("|---|---:|---:|")
    for name, times in rows:
        print(f"| {name} | {np.median(times):.1f} | {max(times):.1f} |")


if __name__ == "__main__":
    main()
