"""Patches side by side on bent surfaces: what does fairing across their curves change?

    python benchmarks/surfacing/fairing.py [--shared ../shared] [--count 60] [--half first]

Grids of 8 to 16 by 8 to 16 quads cut from artists' meshes as in bent_patches.py, halves of meshes
likewise. A grid is parted along its lines into BLOCKS by BLOCKS blocks; the lines between and
around are the network, each block a cycle. The surface that is meant is the mesh's own, or the
cubic spline through its vertices ("splined"): artists' meshes are coarse models of smooth ones.
Constants of fairing were chosen on the first half alone.

Prints Markdown for RESULTS.md, means over the networks: the mean distance both ways in thousandths
of the network's diagonal; on how many networks it is less after fairing; the angle between the
faces beside the curves within, in degrees, by length, and the greatest of each network. "Meant" is
the mean angle of the spline itself, cut into CUTS quads from line to line.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import bent_patches
import numpy as np
from scipy.interpolate import make_interp_spline

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing import surface
from query.placing import Surface
from tests.support.surfacing.surfacedistance import distance

SIZES = (8, 16)
BLOCKS = 2

#: About the edges of a curve by default, see patterndb_sketch.surfacing.sampling.
CUTS = 12

SEED = 19

#: Points of the spline between two vertices of the mesh.
FINE = 6


def spline_net(net: Points) -> Points:
    """The cubic spline through a net of points (m, n, 3), FINE times as fine."""
    for axis in (0, 1):
        n = net.shape[axis]
        fine = np.linspace(0, n - 1, FINE * (n - 1) + 1)
        spline = make_interp_spline(np.arange(n), net, k=3, axis=axis)
        new = spline(fine)
        new[(slice(None),) * axis + (slice(None, None, FINE),)] = net
        net = new
    return net


def network_of(net: Points, lines: tuple[np.ndarray, np.ndarray]) -> CurveNetwork:
    """The network of some rows and columns of a net, a cycle for each block between."""
    rows, columns = lines
    nodes = net[np.ix_(rows, columns)].reshape(-1, 3)
    w = len(columns)
    curves: list[Curve] = []
    along: dict[tuple[int, int], int] = {}

    def join(a: int, b: int, points: Points) -> None:
        along[a, b] = len(curves)
        curves.append(Curve(points, (a, b), len(curves), len(curves)))

    for i, row in enumerate(rows):
        for j in range(w - 1):
            join(i * w + j, i * w + j + 1, net[row, columns[j] : columns[j + 1] + 1])
    for j, column in enumerate(columns):
        for i in range(len(rows) - 1):
            join(i * w + j, (i + 1) * w + j, net[rows[i] : rows[i + 1] + 1, column])
    cycles: list[Cycle] = []
    for i in range(len(rows) - 1):
        for j in range(w - 1):
            a, b, c, d = i * w + j, i * w + j + 1, (i + 1) * w + j + 1, (i + 1) * w + j
            steps = ((along[a, b], False), (along[b, c], False), (along[d, c], True))
            cycles.append(Cycle((*steps, (along[a, d], True))))
    return CurveNetwork(tuple(curves), nodes, tuple(cycles))


def average_angles(
    points: Points, triangles: Int64Array, lines: Sequence[Int64Array]
) -> tuple[float, float]:
    """Degrees between the two faces beside edges along lines: the mean by length, the most."""
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    walking = {
        (int(t[k]), int(t[(k + 1) % 3])): f for f, t in enumerate(triangles) for k in range(3)
    }
    angles: list[float] = []
    lengths: list[float] = []
    for along in lines:
        for a, b in zip(along[:-1].tolist(), along[1:].tolist(), strict=True):
            if (a, b) in walking and (b, a) in walking:
                one, other = normals[walking[a, b]], normals[walking[b, a]]
                angles.append(
                    float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)))
                )
                lengths.append(float(np.linalg.norm(points[b] - points[a])))
    return float(np.average(angles, weights=lengths)), max(angles)


def measure_meant(net: Points) -> float:
    """The mean angle across the lines within of a net's spline."""
    fine = spline_net(net)
    cuts = [np.round(np.linspace(0, n - 1, BLOCKS * CUTS + 1)).astype(int) for n in fine.shape[:2]]
    cut = fine[np.ix_(cuts[0], cuts[1])]
    surface = triangulate(cut)
    at = np.arange(cut.shape[0] * cut.shape[1]).reshape(cut.shape[:2])
    along = [line for k in range(1, BLOCKS) for line in (at[k * CUTS], at[:, k * CUTS])]
    return average_angles(surface.vertices, surface.triangles.astype(np.int64), along)[0]


def triangulate(net: Points) -> Surface:
    m, n = net.shape[:2]
    at = np.arange(m * n).reshape(m, n)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    halves = [np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]
    return Surface.from_arrays(
        net.reshape(-1, 3), np.concatenate([h.reshape(-1, 3) for h in halves])
    )


def measure(net: Points, splined: bool) -> list[float]:
    """Distance and angles, before and after."""
    lines = tuple(np.round(np.linspace(0, n - 1, BLOCKS + 1)).astype(int) for n in net.shape[:2])
    if splined:
        net, lines = spline_net(net), tuple(FINE * one for one in lines)
    network = network_of(net, (lines[0], lines[1]))
    truth = triangulate(net)
    row: list[float] = []
    for fair in (False, True):
        made = surface(network, fair=fair)
        far = (
            distance(Surface.from_arrays(made.points, made.triangles), truth).mean
            / network.diagonal
        )
        row += [1000 * far, *average_angles(made.points, made.triangles, made.sampling.along)]
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--count", type=int, default=60, help="networks in both halves together")
    parser.add_argument("--half", choices=("first", "second"))
    args = parser.parse_args()
    halves: tuple[list[tuple[str, Points]], ...] = ([], [])
    for k, path in enumerate(sorted((args.shared / "data" / "meshes").glob("*.obj"))):
        found = bent_patches.cut_patches(path, SIZES)
        patches = (patch for patch, _ in zip(found, range(bent_patches.PER_MESH), strict=False))
        halves[k % 2].extend(patches)
    heads = "half | surface | networks | distance | faired | nearer | angle | faired | meant | most"
    print(f"| {heads} | faired |")
    print("|---|---|" + "---:|" * 9)
    for name, half in zip(("first", "second"), halves, strict=True):
        if args.half not in (None, name):
            continue
        rng = np.random.default_rng(SEED)
        some = [half[i] for i in sorted(rng.permutation(len(half))[: args.count // 2].tolist())]
        for splined in (True, False):
            rows = np.array([measure(net, splined) for _, net in some])
            meant = f"{np.mean([measure_meant(net) for _, net in some]):.1f}" if splined else ""
            far, angle, most, far2, angle2, most2 = rows.mean(axis=0)
            nearer = int((rows[:, 3] < rows[:, 0]).sum())
            print(
                f"| {name} | {'splined' if splined else 'mesh'} | {len(rows)} of {len(half)} "
                f"| {far:.2f} | {far2:.2f} | {nearer} | {angle:.1f} | {angle2:.1f} | {meant} "
                f"| {most:.0f} | {most2:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
