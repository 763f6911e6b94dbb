"""Find doublets: inner vertices of the mesh with two quads, which lie over or beside each other.

They come where two patches have a corner and nothing else has: a bend in a curve that no other
curve leads to. Smoothing cannot open them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.filling.placing import PlacedPatch, name_border_vertices
from patterndb_sketch.retopo.network import FACE, SYMMETRY, HalfChain, Network

#: Quads around a doublet.
QUADS = 2


def find_doublets(network: Network, placed: Mapping[int, PlacedPatch]) -> Points:
    """(k, 3) the inner vertices with two quads, patch by patch.

    What is on the plane of symmetry has as many quads again beyond it. Corners of faces that were
    given are as they were given.
    """
    covered = {half for patch in placed for half in network.patches[patch].loop}

    def is_closed(half: HalfChain) -> bool:
        return half in covered or network.mark(half) == SYMMETRY

    uses: dict[tuple[int, int], int] = {}
    points: dict[tuple[int, int], Points] = {}
    found: list[Points] = []
    for patch in sorted(placed):
        one = placed[patch]
        valence = np.bincount(one.quads.ravel(), minlength=len(one.vertices))
        inner = np.flatnonzero(valence[one.perimeter :] == QUADS) + one.perimeter
        found += list(one.vertices[inner])
        for k, key in enumerate(name_border_vertices(network, network.patches[patch])):
            uses[key] = uses.get(key, 0) + int(valence[k])
            points[key] = one.vertices[k]
    for (number, along), quads in uses.items():
        if quads > QUADS:
            continue
        around = (2 * number,) if along >= 0 else network.nodes[number].ends
        if any(FACE in network.chains[half >> 1].marks for half in around):
            continue
        whole = all(is_closed(half) and is_closed(half ^ 1) for half in around)
        seam = any(SYMMETRY in network.chains[half >> 1].marks for half in around)
        if whole and quads * (2 if seam else 1) == QUADS:
            found.append(points[number, along])
    return np.array(found).reshape(-1, 3)
