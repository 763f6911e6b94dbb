"""Loops of quad meshes: how many cross themselves, charts of the base complex, irregular vertices.

    python benchmarks/loops.py MESH ...

MESH is any mesh file with quads, such as those that `benchmarks/draft.py --meshes FOLDER` keeps.

- face loops: the share of quads, by area and counted once for each of their two strips, whose strip
  of quads through opposite edges passes no quad twice
- edge loops: the share of edges, weighted by the area of their quads, whose loop, which goes
  straight on through regular vertices, passes no vertex twice
- charts: regions between the edge loops that leave irregular vertices (the base complex)
- irregular: vertices with other than 4 quads inside, or other than 2 on a border, corners left out
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ingest.formats import read_mesh
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Loops:
    """The measures of a mesh; see the module."""

    quads: int
    face_loops: float
    edge_loops: float
    charts: int
    irregular: int


class QuadEdges:
    """The half-edges 4 f + e of quads: opposite ones, and the next ones straight on."""

    def __init__(self, quads: Int32Array) -> None:
        self.tail = quads.ravel().astype(np.int64)
        self.head = np.roll(quads, -1, axis=1).ravel().astype(np.int64)
        key = (np.minimum(self.tail, self.head) << 32) | np.maximum(self.tail, self.head)
        order = np.argsort(key, kind="stable")
        self.edge = np.unique(key, return_inverse=True)[1].reshape(-1)
        self.opposite = np.full(len(key), -1)
        same = np.flatnonzero(key[order][1:] == key[order][:-1])
        self.opposite[order[same]] = order[same + 1]
        self.opposite[order[same + 1]] = order[same]
        valence = np.bincount(self.tail, minlength=int(self.tail.max()) + 1)
        self.border = np.zeros(len(valence), np.bool_)
        lone = self.opposite < 0
        self.border[self.tail[lone]] = self.border[self.head[lone]] = True
        regular = np.where(self.border, (valence == 2) | (valence == 1), valence == 4)
        self.irregular = ~regular & (valence > 0)
        # Straight on across a regular inner vertex: around it by two quads.
        h = np.arange(len(key))
        ahead = 4 * (h // 4) + (h + 1) % 4
        across = self.opposite[ahead]
        straight = np.where(across >= 0, 4 * (across // 4) + (across + 1) % 4, -1)
        inner = (valence == 4) & ~self.border
        self.straight = np.where(inner[self.head], straight, -1)


def follow(first: int, after: Ints) -> list[int]:
    """List what follows, until the end or around."""
    found = [first]
    while (ahead := int(after[found[-1]])) >= 0 and ahead != first:
        found.append(ahead)
    return found


def measure_loops(points: Points, quads: Int32Array) -> Loops:
    """Measure the loops of a mesh of quads (q, 4)."""
    edges = QuadEdges(quads)
    corner = points[quads]
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1
    )
    h = np.arange(4 * len(quads))
    # Out of a quad by the side opposite to where the strip came in.
    out = 4 * (h // 4) + (h + 2) % 4
    return Loops(
        quads=len(quads),
        face_loops=share_without_crossing(h // 4, edges.opposite[out], area[h // 4], out),
        edge_loops=share_without_crossing(edges.tail, edges.straight, area[h // 4], edges.opposite),
        charts=count_charts(edges, len(quads)),
        irregular=int(edges.irregular.sum()),
    )


def share_without_crossing(place: Ints, after: Ints, weight: Points, reverse: Ints) -> float:
    """Return the share of half-edges, by weight, whose loop passes no place twice.

    place: (h,) what a half-edge passes. after: (h,) the next one, -1 at an end. reverse: (h,) the
    same loop's half-edge the other way; -1 where there is none.
    """
    before = np.full(len(after), -1)
    before[after[after >= 0]] = np.flatnonzero(after >= 0)
    seen = np.zeros(len(after), np.bool_)
    good = total = 0.0
    for first in range(len(after)):
        if seen[first]:
            continue
        back = follow(first, before)
        loop = follow(back[-1], after)
        seen[loop] = True
        other = reverse[loop]
        seen[other[other >= 0]] = True
        own = float(weight[loop].sum())
        total += own
        if len(np.unique(place[loop])) == len(loop):
            good += own
    return good / total if total else 1.0


def count_charts(edges: QuadEdges, n_quads: int) -> int:
    """Count the charts: quads joined across edges that no loop from an irregular vertex passes."""
    cut = np.zeros(int(edges.edge.max()) + 1, np.bool_)
    for first in np.flatnonzero(edges.irregular[edges.tail]).tolist():
        cut[edges.edge[follow(first, edges.straight)]] = True
    # Along borders loops arrive backwards: those half-edges have no quad on their left.
    for first in np.flatnonzero(edges.irregular[edges.head] & (edges.opposite < 0)).tolist():
        cut[edges.edge[first]] = True
    side = np.flatnonzero((edges.opposite >= 0) & ~cut[edges.edge])
    links = coo_array(
        (np.ones(len(side), np.int8), (side // 4, edges.opposite[side] // 4)), (n_quads, n_quads)
    )
    return int(connected_components(links, directed=False)[0])


def main() -> None:
    """Measure meshes, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("meshes", nargs="+", type=Path)
    options = parser.parse_args()
    print("| mesh | quads | face loops | edge loops | charts | irregular |\n|---|" + "---:|" * 5)
    for path in options.meshes:
        mesh = read_mesh(path)
        found = measure_loops(mesh.points, mesh.quads()[0])
        print(
            f"| {path.stem} | {found.quads:,} | {found.face_loops:.2f} | {found.edge_loops:.2f} | "
            f"{found.charts} | {found.irregular} |"
        )


if __name__ == "__main__":
    main()
