"""A whole patch as a mesh: its boundary, its chords, and one disk of triangles per piece."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop
from patterndb_sketch.surfacing.tessellation.piece import (
    PieceMethod,
    check_spacing,
    minimal_area,
    tessellate,
)


@dataclass(frozen=True, slots=True)
class PatchMesh:
    """A loop of n vertices filled with triangles, piece by piece.

    points:  (k, 3) float64, the vertices beyond the loop's: those along chords, then those
             inside pieces.
    faces:   for every piece its triangles (f, 3) int64: below n a position of the loop, n + i
             point i. All turn as the loop does; pieces share the vertices along their chords.
    methods: for every piece how it was made.
    notes:   what was given up, naming the piece; empty if nothing was.
    """

    points: Points = field(repr=False)
    faces: tuple[NDArray[np.int64], ...] = field(repr=False)
    methods: tuple[PieceMethod, ...]
    notes: tuple[str, ...] = ()

    @property
    def triangles(self) -> NDArray[np.int64]:
        """(f, 3) the triangles of all pieces, in the pieces' order."""
        return np.concatenate(self.faces)

    def vertices(self, loop: Loop) -> Points:
        """(n + k, 3) all vertices that the faces name; loop: the one it was made of."""
        return np.concatenate([loop.points, self.points])


def tessellate_patch(
    loop: Loop, chords: ArrayLike, pieces: Sequence[ArrayLike], spacing: float
) -> PatchMesh:
    """Fill a loop that chords cut into pieces; see :func:`tessellate` for one piece.

    chords: (m, 2) positions of the loop, no two chords alike and none between neighbours.
    pieces: the positions around each piece, in the loop's sense: from one to the next lies an
    edge of the loop or a chord. With no chords there is one piece, the whole loop. spacing:
    about how far new vertices are apart, in the units of the points. Chords stay straight, in
    edges of equal length, at least one; both pieces beside a chord have the same vertices
    along it.

    Raises InvalidNetworkError for chords and pieces that do not fit: every edge of the loop
    must be in one piece, every chord in two, once in each direction. And as
    :func:`tessellate` does.
    """
    check_spacing(spacing)
    n = len(loop.points)
    ends = _checked_chords(chords, n)
    inside, along = _sampled_chords(loop, ends, spacing)
    points = [np.empty((0, 3)), *inside]
    outline = np.concatenate([loop.points, *points])
    count = len(outline)
    faces: list[NDArray[np.int64]] = []
    methods: list[PieceMethod] = []
    notes: list[str] = []
    for number, (around, barred) in enumerate(_outlines(pieces, along, n)):
        made = tessellate(outline[around], spacing, barred)
        names = np.concatenate([around, count + np.arange(len(made.inner))])
        faces.append(names[made.triangles])
        methods.append(made.method)
        if made.note:
            notes.append(f"piece {number}: {made.note}")
        points.append(made.inner)
        count += len(made.inner)
    return PatchMesh(np.concatenate(points), tuple(faces), tuple(methods), tuple(notes))


def patch_of_least_area(loop: Loop) -> PatchMesh:
    """Fill a loop with its triangulation of least area, in one piece without new vertices.

    Raises InvalidNetworkError as :func:`minimal_area` does.
    """
    return PatchMesh(np.empty((0, 3)), (minimal_area(loop.points)[0],), ("area",))


def _checked_chords(chords: ArrayLike, n: int) -> NDArray[np.int64]:
    given = np.asarray(chords)
    if not given.size:
        return np.empty((0, 2), np.int64)
    if given.ndim != 2 or given.shape[1] != 2 or not np.issubdtype(given.dtype, np.integer):
        raise InvalidNetworkError(
            f"chords are pairs of positions (m, 2), not {given.dtype} of shape {given.shape}"
        )
    seen: set[tuple[int, int]] = set()
    for number, (a, b) in enumerate(given.tolist()):
        if not (0 <= a < n and 0 <= b < n):
            raise InvalidNetworkError(
                f"chord {number} joins positions {a} and {b}; the loop has 0 to {n - 1}"
            )
        if (a - b) % n in (0, 1, n - 1):
            raise InvalidNetworkError(
                f"chord {number} joins the positions {a} and {b}, which are one or neighbours; "
                "leave it out"
            )
        key = (min(a, b), max(a, b))
        if key in seen:
            raise InvalidNetworkError(f"the chord from {a} to {b} is given twice")
        seen.add(key)
    return given.astype(np.int64)


def _sampled_chords(
    loop: Loop, chords: NDArray[np.int64], spacing: float
) -> tuple[list[Points], dict[tuple[int, int], list[int]]]:
    """The points within every chord, and per direction of a chord the vertices along it, the
    first included and the last not."""
    inside: list[Points] = []
    along: dict[tuple[int, int], list[int]] = {}
    count = len(loop.points)
    for a, b in chords.tolist():
        ends = loop.points[[a, b]]
        edges = max(1, round(float(np.linalg.norm(ends[1] - ends[0])) / spacing))
        within = list(range(count, count + edges - 1))
        inside.append(sample_polyline(ends, edges)[1:-1])
        along[a, b] = [a, *within]
        along[b, a] = [b, *reversed(within)]
        count += len(within)
    return inside, along


def _outlines(
    pieces: Sequence[ArrayLike], along: dict[tuple[int, int], list[int]], n: int
) -> list[tuple[NDArray[np.int64], NDArray[np.bool_] | None]]:
    """Around every piece the vertices (m,), those of chords included, and the pairs of them
    (m, m) that lie on one chord; checks that pieces fit.

    No triangle may join such a pair: the one on the chord's other side might join it too, and
    four triangles would meet there.
    """
    free = set(along) | {(i, (i + 1) % n) for i in range(n)}
    outlines: list[tuple[NDArray[np.int64], NDArray[np.bool_] | None]] = []
    for number, piece in enumerate(pieces):
        around = np.asarray(piece, np.int64).tolist()
        vertices: list[int] = []
        straight: list[tuple[int, int]] = []
        for a, b in zip(around, around[1:] + around[:1], strict=True):
            if (a, b) not in free:
                raise InvalidNetworkError(
                    f"piece {number} goes from position {a} to {b}, where there is neither an "
                    "edge of the loop nor a chord, or another piece goes too; list the "
                    "positions of pieces in the loop's sense"
                )
            free.remove((a, b))
            part = along.get((a, b), [a])
            if len(part) > 1:
                straight.append((len(vertices), len(part)))
            vertices += part
        barred = np.zeros((len(vertices),) * 2, np.bool_) if straight else None
        for first, edges in straight:
            on_chord = (first + np.arange(edges + 1)) % len(vertices)
            if barred is not None:
                barred[np.ix_(on_chord, on_chord)] = True
        outlines.append((np.array(vertices), barred))
    if free:
        a, b = min(free)
        raise InvalidNetworkError(f"no piece goes from position {a} to {b}; a piece is missing")
    return outlines
