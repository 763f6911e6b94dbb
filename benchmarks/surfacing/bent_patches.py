"""Patches cut from artists' meshes: how near do the methods come to them, given the outline alone?

    pip install '.[benchmark]'
    python benchmarks/surfacing/bent_patches.py [--shared ../shared] [--count 100]

Grids of 4 to 12 by 4 to 12 quads whose outline is bent, at most PER_MESH from one mesh, drawn with
a seed. "Along" are outlines that follow the mesh's edges. "Across" are those of the squares that
stand on their tips within the same grids: they run across the flow of edges. Meshes are parted into
two halves by name, every other one. The weights of ours were chosen on other patches of some of
these meshes before this was written; whoever changes them may look at the first half alone.

Prints Markdown for RESULTS.md: the mean and the median over the patches of the mean distance both
ways, in thousandths of the outline's diagonal; how often a method is nearest, or within 2 % of it;
and how many answers have crossings. Peers need the extra ``benchmark``; without it they are left
out.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from synthetic_cycles import Answer, Fill, answer, methods

from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from tests.support.surfacing.intended import Intended, of_net

SIZES = (4, 12)
PER_MESH = 4
SEED = 19

#: Outlines whose points lie nearer to a plane than this, as the ratio of their least to their
#: greatest extent, are not bent.
LEAST_BEND = 0.08

#: Starts that are tried in one mesh.
TRIES = 400

#: Methods this near to the nearest count as nearest.
AS_NEAR = 1.02

#: Rows and columns of the net of a patch across the flow.
FINE = 48


def walk_grid(
    faces: np.ndarray, walking: dict[tuple[int, int], int], start: int, m: int, n: int
) -> np.ndarray | None:
    """(m + 1, n + 1) vertices of the grid of quads from one on, None if there is none.

    walking: which quad walks an edge from one vertex to another.
    """
    grid = np.full((m + 1, n + 1), -1)
    row = faces[start]
    used: set[int] = set()
    for i in range(m):
        quad = row
        for j in range(n):
            a, b, c, d = quad.tolist()  # a at (i, j), b at (i + 1, j), c across, d at (i, j + 1)
            for place, v in (((i, j), a), ((i + 1, j), b), ((i + 1, j + 1), c), ((i, j + 1), d)):
                if grid[place] not in (-1, v):
                    return None
                grid[place] = v
            found = walking.get((d, c))
            if j + 1 < n:
                if found is None:
                    return None
                quad = np.roll(faces[found], -faces[found].tolist().index(d))
                if quad[1] != c:
                    return None
        a, b = int(row[0]), int(row[1])
        c = int(row[2])
        if i + 1 < m:
            found = walking.get((c, b))
            if found is None or found in used:
                return None
            used.add(found)
            row = np.roll(faces[found], -faces[found].tolist().index(b))
            if row[3] != c:
                return None
    return grid if len(np.unique(grid)) == grid.size else None


def bend_of(points: Points) -> float:
    """The ratio of the least to the greatest extent."""
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(extents[2] / extents[0])


def outline_of(net: Points) -> Points:
    return np.concatenate([net[:, 0], net[-1], net[::-1, -1], net[0, ::-1]])


def cut_patches(path: Path, sizes: tuple[int, int] = SIZES) -> Iterator[tuple[str, Points]]:
    """Bent grids of a mesh, (m + 1, n + 1, 3) each, no two with the same middle."""
    mesh = read_mesh(path)
    quads = [face for face in np.split(mesh.corners, mesh.offsets[1:-1]) if len(face) == 4]
    if len(quads) < sizes[0] ** 2:
        return
    faces = np.array(quads)
    walking = {
        (int(face[k]), int(face[(k + 1) % 4])): i for i, face in enumerate(faces) for k in range(4)
    }
    rng = np.random.default_rng([SEED, *path.stem.encode()])
    taken: set[int] = set()
    for _ in range(TRIES):
        m, n = rng.integers(sizes[0], sizes[1] + 1, size=2).tolist()
        grid = walk_grid(faces, walking, int(rng.integers(len(faces))), m, n)
        if grid is None or not taken.isdisjoint(grid.ravel().tolist()):
            continue
        net = mesh.points[grid]
        steps = np.linalg.norm(np.diff(outline_of(net), axis=0), axis=1)
        if bend_of(outline_of(net)) < LEAST_BEND or np.ptp(steps) == 0.0:
            continue
        taken.update(grid.ravel().tolist())
        yield f"{path.stem} {m} x {n}", net


def turn_across(net: Points) -> Points:
    """(FINE + 1, FINE + 1, 3) the square on its tip within a net, on the net's quads."""
    m, n = net.shape[0] - 1, net.shape[1] - 1
    a, b = np.meshgrid(np.linspace(0, 1, FINE + 1), np.linspace(0, 1, FINE + 1), indexing="ij")
    x, y = m * (a + b) / 2, n * (1 + a - b) / 2
    i, j = np.minimum(x.astype(int), m - 1), np.minimum(y.astype(int), n - 1)
    s, t = (x - i)[..., None], (y - j)[..., None]
    low = (1 - t) * net[i, j] + t * net[i, j + 1]
    high = (1 - t) * net[i + 1, j] + t * net[i + 1, j + 1]
    return (1 - s) * low + s * high


def summarise(answers: list[dict[str, Answer]]) -> list[str]:
    """A row per method over some patches."""
    names = list(answers[0])
    far = {
        n: np.array([1000 * one[n].distance.mean if not one[n].why else np.nan for one in answers])
        for n in names
    }
    least = np.nanmin(np.stack(list(far.values())), axis=0)
    rows: list[str] = []
    for name in names:
        sound = far[name][~np.isnan(far[name])]
        near = int((far[name] <= AS_NEAR * least).sum())
        crossed = sum(one[name].crossings > 0 for one in answers)
        failed = int(np.isnan(far[name]).sum())
        ms = 1000 * float(np.median([one[name].seconds for one in answers if not one[name].why]))
        rows.append(
            f"| {name} | {sound.mean():.1f} | {np.median(sound):.1f} | {near} | {crossed} "
            f"| {failed} | {ms:.1f} |"
        )
    return rows


def measure_patches(patches: list[Intended], fills: dict[str, Fill]) -> list[str]:
    return summarise([{n: answer(patch, fill) for n, fill in fills.items()} for patch in patches])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--count", type=int, default=100, help="patches in both halves together")
    args = parser.parse_args()
    fills = methods()
    halves: tuple[list[tuple[str, Points]], ...] = ([], [])
    for k, path in enumerate(sorted((args.shared / "data" / "meshes").glob("*.obj"))):
        found = cut_patches(path)
        halves[k % 2].extend(patch for patch, _ in zip(found, range(PER_MESH), strict=False))
    for name, half in zip(("first half", "second half"), halves, strict=True):
        rng = np.random.default_rng(SEED)
        some = [half[i] for i in sorted(rng.permutation(len(half))[: args.count // 2].tolist())]
        for way, nets in (
            ("along", some),
            ("across", [(title, turn_across(net)) for title, net in some]),
        ):
            patches = [replace(of_net(title, "", net), name=title) for title, net in nets]
            print(f"\n{name}, {way} the flow: {len(patches)} patches of {len(half)}\n")
            print("| method | mean | median | nearest | crossed | failed | ms |")
            print("|---|---:|---:|---:|---:|---:|---:|")
            print("\n".join(measure_patches(patches, fills)), flush=True)


if __name__ == "__main__":
    main()
