"""Modelling operations on quad meshes, in a modeller's words: bridge, cap, extrude, mirror."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Quads = NDArray[np.int64]

ON_PLANE = 1e-9
"""How far from the mirror plane a point may lie and still count as on it."""

DECIMALS = 4
"""Decimals of a written coordinate: far coarser than rounding noise, so that platforms agree."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """A quad mesh: ``points`` (n, 3) float, ``quads`` (m, 4) int, counter-clockwise."""

    points: Points
    quads: Quads


class Model:
    """A quad mesh being modelled: points and quads are added, taken out and replaced by index."""

    def __init__(self) -> None:
        self._points: list[Points] = []
        self._quads: list[tuple[int, int, int, int]] = []

    @property
    def points(self) -> Points:
        """The coordinates, shape (n, 3); assign to move the points."""
        return np.array(self._points, dtype=np.float64).reshape(-1, 3)

    @points.setter
    def points(self, points: Points) -> None:
        self._points = [np.array(p, dtype=np.float64) for p in points]

    @property
    def quads(self) -> Quads:
        """The quads, shape (m, 4)."""
        return np.array(self._quads, dtype=np.int64).reshape(-1, 4)

    def add(self, *coordinates: Sequence[float] | Points) -> list[int]:
        """Adds points, each (3,), and returns their indices."""
        first = len(self._points)
        self._points += [np.array(c, dtype=np.float64) for c in coordinates]
        return list(range(first, len(self._points)))

    def at(self, indices: int | Iterable[int]) -> Points:
        """The coordinates of one point, (3,), or of several, (k, 3)."""
        if isinstance(indices, int):
            return self._points[indices].copy()
        return np.array([self._points[i] for i in indices])

    def move(self, indices: Sequence[int], coordinates: Points) -> None:
        """Moves points to new coordinates (k, 3)."""
        for i, c in zip(indices, coordinates, strict=True):
            self._points[i] = np.array(c, dtype=np.float64)

    def quad(self, a: int, b: int, c: int, d: int) -> None:
        """Adds one quad, counter-clockwise from outside."""
        self._quads.append((a, b, c, d))

    def bridge(self, lower: Sequence[int], upper: Sequence[int], *, closed: bool = False) -> None:
        """Joins two chains of equal length by a strip of quads.

        Seen from outside, with ``lower`` running to the right, ``upper`` lies above it.
        """
        if len(lower) != len(upper):
            raise ValueError(
                f"a bridge needs chains of one length, not {len(lower)} and {len(upper)}"
            )
        count = len(lower)
        for i in range(count if closed else count - 1):
            j = (i + 1) % count
            self.quad(lower[i], lower[j], upper[j], upper[i])

    def grid(self, rows: Sequence[Sequence[int]]) -> None:
        """Joins each row to the next: the lowest first, each running to the right from outside."""
        for lower, upper in pairwise(rows):
            self.bridge(lower, upper)

    def cap(self, loop: Sequence[int], across: int) -> list[list[int]]:
        """Fills a closed loop by a grid ``across`` quads wide; returns the grid's rows.

        The loop runs counter-clockwise seen from outside; its first ``across`` edges are the grid's
        lowest row. Inner points are placed by transfinite interpolation.
        """
        count = len(loop)
        up = count // 2 - across
        if count % 2 or up < 1:
            raise ValueError(f"a loop of {count} edges has no grid {across} quads wide")
        bottom = list(loop[: across + 1])
        right = list(loop[across : across + up + 1])
        top = list(loop[across + up : 2 * across + up + 1])[::-1]
        left = [loop[0], *loop[: 2 * across + up - 1 : -1]]
        rows = self.patch(bottom, top, left, right)
        self.grid(rows)
        return rows

    def patch(
        self, bottom: Sequence[int], top: Sequence[int], left: Sequence[int], right: Sequence[int]
    ) -> list[list[int]]:
        """Adds the inner points of a four-sided patch (Coons); returns all its rows, no quads."""
        pb, pt, pl, pr = (self.at(side) for side in (bottom, top, left, right))
        nu, nv = len(bottom) - 1, len(left) - 1
        rows = [list(bottom)]
        for j in range(1, nv):
            v = j / nv
            row = [left[j]]
            for i in range(1, nu):
                u = i / nu
                ruled = (1 - v) * pb[i] + v * pt[i] + (1 - u) * pl[j] + u * pr[j]
                corners = (1 - v) * ((1 - u) * pb[0] + u * pb[-1])
                corners = corners + v * ((1 - u) * pt[0] + u * pt[-1])
                row += self.add(ruled - corners)
            rows.append([*row, right[j]])
        rows.append(list(top))
        return rows

    def extrude(self, region: Iterable[int], move: Callable[[Points], Points]) -> None:
        """Extrudes the quads of the given indices; ``move`` maps old points (k, 3) to new.

        ``move`` gets the points in the order of their indices; where it stays within the surface,
        this is an inset. The quads keep their indices. Rim edges in the mirror plane x = 0 get no
        wall.
        """
        region = list(region)
        quads = [self._quads[f] for f in region]
        old = sorted({v for quad in quads for v in quad})
        new = dict(zip(old, self.add(*move(self.at(old))), strict=True))
        directed = {e for q in quads for e in zip(q, (*q[1:], q[0]), strict=True)}
        rim = [
            e for q in quads for e in zip(q, (*q[1:], q[0]), strict=True) if e[::-1] not in directed
        ]
        for f, (a, b, c, d) in zip(region, quads, strict=True):
            self._quads[f] = (new[a], new[b], new[c], new[d])
        for a, b in rim:
            if np.abs(self.at((a, b))[:, 0]).max() > ON_PLANE:
                self.quad(a, b, new[b], new[a])

    def remove(self, region: Iterable[int]) -> None:
        """Takes quads out by index; the points stay until `finish`."""
        gone = set(region)
        self._quads = [q for f, q in enumerate(self._quads) if f not in gone]

    def find(self, corners: Iterable[int]) -> int:
        """The index of the quad with these corners."""
        wanted = set(corners)
        return next(f for f, quad in enumerate(self._quads) if set(quad) == wanted)

    def inside(self, points: Iterable[int]) -> list[int]:
        """The quads all of whose corners are among ``points``."""
        chosen = set(points)
        return [f for f, quad in enumerate(self._quads) if chosen.issuperset(quad)]

    def finish(self, scale: float = 1.0) -> Mesh:
        """The mesh without unused points, scaled."""
        used, quads = np.unique(self.quads, return_inverse=True)
        return Mesh(self.points[used] * scale, quads.reshape(-1, 4).astype(np.int64))


def mirror(mesh: Mesh, tolerance: float = ON_PLANE) -> Mesh:
    """Adds the image in the plane x = 0; points within ``tolerance`` of it are welded."""
    on_plane = np.abs(mesh.points[:, 0]) <= tolerance
    points = mesh.points.copy()
    points[on_plane, 0] = 0.0
    image = np.arange(len(points))
    image[~on_plane] = len(points) + np.arange(int((~on_plane).sum()))
    flipped = points[~on_plane] * (-1.0, 1.0, 1.0)
    return Mesh(np.vstack([points, flipped]), np.vstack([mesh.quads, image[mesh.quads][:, ::-1]]))


def write_obj(path: Path, mesh: Mesh, comment: str) -> None:
    """Writes an OBJ file: the comment's lines, vertices to `DECIMALS` places, faces."""
    lines = [f"# {line}" for line in comment.splitlines()]
    rounded = np.round(mesh.points, DECIMALS) + 0.0  # the sum turns -0.0 into 0.0
    lines += ["v " + " ".join(f"{c:.{DECIMALS}f}" for c in p) for p in rounded]
    lines += ["f " + " ".join(str(i + 1) for i in quad) for quad in mesh.quads]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
