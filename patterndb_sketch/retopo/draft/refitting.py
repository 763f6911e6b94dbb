"""Fit quads to the surface again where an edit filled patches of a draft anew.

A fill is laid within its curves, and knows nothing of the surface's tips and folds; a draft moved
its vertices to them (:mod:`.fitting`). Another fill, or other counts, lose that. What is fitted
again is what lost it: patches beside curves that a draft laid, and such curves between two of
these patches. Curves of the user stay where they are, and so does all else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.fitting import count_flipped, fit_quads
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    PlacedCache,
    fill_network,
    filling_of,
    has_suitable_fill,
    side_lengths,
    weld_patches,
)
from patterndb_sketch.retopo.filling.report import cut_quads
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.sizes import Sizes
from query.engine import PatternSource


def claim_curves(before: Network, after: Network) -> Network:
    """The network after an edit; curves of a draft that took another course are the user's."""
    claimed = {
        c: replace(chain, auto=False)
        for c, chain in after.chains.items()
        if chain.auto
        and (former := before.chains.get(c)) is not None
        and former.points is not chain.points
        and not np.array_equal(former.points, chain.points)
    }
    return replace(after, chains={**after.chains, **claimed}) if claimed else after


def refit_quads(
    before: Network,
    after: Network,
    surface: Surface,
    source: PatternSource,
    sizes: Sizes,
    sample: Callable[[], Points],
    cache: PlacedCache,
) -> Network:
    """The network after an edit with counts and fills, fitted where the edit lost that; itself
    where it lost nothing.

    sample: gives the points that quads are fitted to, when they are wanted.
    """
    if not list_unfitted(before, after):
        return after
    found = fill_network(after, surface, source, sizes.edge, cache)
    due = set(list_unfitted(before, found.network)) & found.placed.keys()
    if not due:
        return found.network
    network = found.network
    owner = network.patch_of()
    laid = {
        c
        for c, chain in network.chains.items()
        if chain.auto and owner.get(2 * c) in due and owner.get(2 * c + 1) in due
    }
    kept = network.patches.keys() - due
    near = _list_near(found, due, sample())
    fitted = fit_quads(found, surface, near, sizes, laid, kept)
    return min(fitted, found, key=count_flipped).network


def list_unfitted(before: Network, after: Network) -> list[int]:
    """The patches beside a draft's curves that have another fill than before, or are to get one,
    and hold none of its vertices, on borders or within."""
    found: list[int] = []
    for patch in after.patches.values():
        if not any(after.chains[half >> 1].auto for half in patch.loop):
            continue
        filling = filling_of(patch)
        suits = has_suitable_fill(after, patch)
        if suits and filling.moved[0]:
            continue
        former = before.patches.get(patch.id)
        if former is not None and former.choice == patch.choice and former.loop == patch.loop:
            sides = side_lengths(before, former), side_lengths(after, patch)
            if former.corners == patch.corners and sides[0] == sides[1]:
                continue
        found.append(patch.id)
    return found


def _list_near(found: FilledNetwork, due: set[int], samples: Points) -> Points:
    """Those of samples that are nearest to quads of some patches."""
    if due >= found.placed.keys():
        return samples
    mesh = weld_patches(found)
    triangles = cut_quads(mesh.vertices, mesh.quads)
    cover = Surface.from_arrays(mesh.vertices, triangles)
    nearest = cover.nearest(samples).triangles
    quad = np.arange(len(triangles)) % len(mesh.quads)
    return samples[np.isin(mesh.patch[quad[nearest]], sorted(due))]
