"""Loops that are their own mirror image: fills of them are, too.

A hole across the plane of a face's or a body's symmetry has a loop that a reflection maps onto
itself. Artists' fills follow it all but always (205 of 207 such holes of 28 meshes), so corners and
fills that do not are hardly likely.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.identity import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.identity import hash_quads

#: How far a vertex may lie from the image of its partner, in mean edges of the loop.
NEAR = 0.1

#: What a fill loses in score, which is a logarithm of odds, by a mirror that it does not follow:
#: log(206 / 3), by the artists' fills counted above.
ASYMMETRIC = 4.2

#: Distances that differ by less than this part of NEAR edges are rounding: the mirrors are equally
#: exact, and stand in the order of their numbers.
ROUNDING = 1e-6

#: Mirrors of a loop that are looked at, the most exact ones: a flat circle has one at each edge.
MOST_MIRRORS = 8


#: Mirrors of a loop of which a fill is to follow each.
BOTH = 2


def find_mirrors(points: Floats, due: Int32Array) -> Int32Array:
    """(m,) int32, most exact first: s, where a reflection takes each vertex i of a loop to s - i.

    points: (L, 3). due: (L,) quads that make the loop regular, which a reflection has to keep.
    """
    n = len(points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    near = NEAR * float(lengths.mean())
    centred = points - points.mean(axis=0)
    radius = np.linalg.norm(centred, axis=1)
    found: list[tuple[int, int]] = []
    at = np.arange(n)
    for s in range(n):
        image = (s - at) % n
        if (due != due[image]).any() or (np.abs(radius - radius[image]) > near).any():
            continue
        # The plane's normal is that along which partners differ most: the least eigenvector of
        # the sum of what they have in common.
        common = centred.T @ centred[image]
        normal = np.linalg.eigh(common + common.T)[1][:, 0]
        across = centred[image] - 2 * np.outer(centred[image] @ normal, normal)
        off = float(np.linalg.norm(centred - across, axis=1).max())
        if off <= near:
            # A loop whose vertices all lie at one place has no mean edge to measure by.
            found.append((round(off / (near * ROUNDING)) if near > 0.0 else 0, s))
    return np.array([s for _, s in sorted(found)[:MOST_MIRRORS]], np.int32)


def follow_mirrors(quads_at: Int32Array, mirrors: Int32Array) -> NDArray[np.bool_]:
    """(c,) bool, does a mirror keep the numbers (c, L) at a loop's vertices? True without any."""
    n = quads_at.shape[1]
    kept = np.full(len(quads_at), not len(mirrors))
    for s in mirrors.tolist():
        kept |= (quads_at == quads_at[:, (s - np.arange(n)) % n]).all(axis=1)
    return kept


def count_followed(
    quads: Int32Array, n_vertices: int, n: int, key: bytes, mirrors: Int32Array
) -> int:
    """Count the mirrors that map a fill with n loop vertices, whose key is given, onto itself."""
    at_loop = np.bincount(quads.ravel(), minlength=n)[None, :n].astype(np.int32)
    count = 0
    for s in mirrors.tolist():
        if not follow_mirrors(at_loop, np.array([s], np.int32))[0]:
            continue
        image = np.where(quads < n, (s - quads) % n, quads)[:, ::-1].astype(np.int32)
        image = np.ascontiguousarray(image)
        twin, _ = weld_quads(image, n_vertices, n)
        count += hash_quads(image, twin, False) == key
    return count


def lose_by_mirrors(n_mirrors: int, followed: int) -> float:
    """Return what a fill loses in score that follows some of its loop's mirrors.

    A loop with two, such as a slot's, is symmetric across two planes, and each counts. With more it
    is round or a regular polygon; no fill follows all, and one is enough.
    """
    missed = n_mirrors - followed if n_mirrors <= BOTH else int(followed == 0)
    return ASYMMETRIC * missed
