"""What two databases have in common, and what only one of them holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.store.database import Database
from patterndb.store.records import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class DatabaseComparison:
    """The difference of two databases, the first and the second.

    alike:    do they answer every question alike? Their content hashes are equal then, and so are
              the patterns that they have seen, with their frequencies.
    meshes:   those that only the first, and only the second holds, by name. A mesh is known by the
              hash of its file.
    retaught: meshes of both that were learned with different options, as the first has them.
    ids:      two ascending (k,) int64 arrays of patterns' ids that only one of them holds.
    both:     how many patterns both hold.
    recounted: (k,) int64 ids of those of both that were seen in different numbers of patches.
    """

    alike: bool
    meshes: tuple[list[Mesh], list[Mesh]]
    retaught: list[Mesh]
    ids: tuple[NDArray[np.int64], NDArray[np.int64]]
    both: int
    recounted: NDArray[np.int64]


def compare_databases(first: Database, second: Database) -> DatabaseComparison:
    """Compare two databases, mesh by mesh and pattern by pattern.

    Example: ``compare_databases(patterndb.open("a.db"), patterndb.open("b.db")).alike``
    """
    of_first = {mesh.sha256: mesh for mesh in first.meshes()}
    of_second = {mesh.sha256: mesh for mesh in second.meshes()}
    ids, frequencies = _patterns_of(first)
    other_ids, other_frequencies = _patterns_of(second)
    _, here, there = np.intersect1d(ids, other_ids, assume_unique=True, return_indices=True)
    changed = frequencies[here] != other_frequencies[there]
    same_content = first.content_hash() == second.content_hash()
    return DatabaseComparison(
        # The hash is of meshes and sums that were stored: a damaged table may not agree with it.
        alike=same_content
        and np.array_equal(ids[frequencies > 0], other_ids[other_frequencies > 0])
        and not changed.any(),
        meshes=(
            [mesh for sha256, mesh in of_first.items() if sha256 not in of_second],
            [mesh for sha256, mesh in of_second.items() if sha256 not in of_first],
        ),
        retaught=[
            mesh
            for sha256, mesh in of_first.items()
            if sha256 in of_second and of_second[sha256].options != mesh.options
        ],
        ids=(
            np.setdiff1d(ids, other_ids, assume_unique=True),
            np.setdiff1d(other_ids, ids, assume_unique=True),
        ),
        both=len(here),
        recounted=ids[here][changed],
    )


def _patterns_of(database: Database) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(p,) int64 ids, ascending, and (p,) int64 frequencies of all patterns."""
    classes = [database.pattern_class(n) for n in database.sides_histogram()]
    ids = np.concatenate([np.zeros(0, np.int64), *(held.ids for held in classes)])
    seen = np.concatenate([np.zeros(0, np.int64), *(held.frequency for held in classes)])
    order = np.argsort(ids)
    return ids[order], seen[order]
