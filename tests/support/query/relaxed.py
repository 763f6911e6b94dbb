"""What the tests of marked patterns share: their fills, looked at quad by quad."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from patterndb.core.code import canonical_code
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from query import Boundary
from query.expand import ExpandedPattern, expand_marked
from query.relaxed import bestmarked, corner_placement, family
from query.relaxed.bestmarked import BestMarked, MarkedIndex, load_family_index


@contextmanager
def own_cache(folder: Path) -> Iterator[Path]:
    """Tables are made again, and kept in a folder that is not the user's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATTERNDB_CACHE", str(folder))
        forget_families()
        yield folder


def forget_families() -> None:
    """Families and their tables are read from the cache folder, or made, again."""
    for module in (family, corner_placement, bestmarked):
        module.LOADED.clear()


def index_for(boundary: Boundary) -> MarkedIndex:
    return load_family_index(max(boundary.n_sides, 1), free=boundary.n_sides == 0)


def targets(boundary: Boundary) -> NDArray[np.int64]:
    """Quads asked for at every boundary vertex."""
    asked = np.full(boundary.perimeter, 2)
    if boundary.n_sides:
        asked[np.r_[0, np.cumsum(boundary.lengths)[:-1]]] = boundary.corner_counts
    return asked


def irregular(boundary: Boundary, quads: NDArray[np.int32], n_vertices: int) -> tuple[int, int]:
    """Irregular vertices inside and on the boundary of what must be a disk within it."""
    p = boundary.perimeter
    tails, heads = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    assert (np.sort(quads, axis=1)[:, 1:] != np.sort(quads, axis=1)[:, :-1]).all()
    edges = set(zip(tails.tolist(), heads.tolist(), strict=True))
    assert len(edges) == quads.size
    border = {(a, b) for a, b in edges if (b, a) not in edges}
    assert border == {(i, (i + 1) % p) for i in range(p)}
    assert set(tails.tolist()) == set(range(n_vertices))
    assert n_vertices - (quads.size + p) // 2 + len(quads) == 1
    mesh = QuadMesh.from_quads(quads)
    assert mesh.n_vertices == n_vertices
    assert not mesh.components().any()
    valence = np.bincount(tails)
    return int((valence[p:] != 4).sum()), int((valence[:p] != targets(boundary)).sum())


def checked(boundary: Boundary, found: BestMarked, index: MarkedIndex) -> ExpandedPattern:
    """The fill, after a look at all that was foretold of it."""
    fill = expand_marked(index.marked, found.row, found.strand_widths, found.orientation)
    assert fill.lengths == boundary.lengths
    inside, on_boundary = irregular(boundary, fill.quads, fill.n_vertices)
    assert (inside + on_boundary, on_boundary) == (found.n_irregular, found.n_irregular_boundary)
    assert inside == len(fill.pattern.valences)
    if not fill.pattern.self_crossing:
        code = canonical_code(reduce_disk(QuadMesh.from_quads(fill.quads).twin))[0]
        assert np.array_equal(code, fill.pattern.code)
    return fill
