"""Strips: chains across 4-sided patches from one another, tied to one count."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.counts.problem import CountsProblem


def strips(problem: CountsProblem) -> Int32Array:
    """(c,) int32: of every chain the strip it is in, named by its smallest chain.

    Opposite sides of a 4-sided patch are tied where each is a single chain: a strip ends where a
    side has more of them. Nor are chains tied that the user has pinned to different counts, or to
    one below what the other needs at least.
    """
    least = np.where(problem.pinned > 0, 1, problem.least).astype(np.int32)
    return _tied(problem.first_side, problem.first_chain, problem.chains, problem.pinned, least)


@kernel
def _tied(
    first_side: Int32Array,
    first_chain: Int32Array,
    chains: Int32Array,
    pinned: Int32Array,
    least: Int32Array,
) -> Int32Array:
    strip = np.arange(len(pinned)).astype(np.int32)
    pin = pinned.copy()
    low_end = least.copy()
    for f in range(len(first_side) - 1):
        low = first_side[f]
        if first_side[f + 1] - low != 4:
            continue
        for k in range(low, low + 2):
            if first_chain[k + 1] - first_chain[k] != 1:
                continue
            if first_chain[k + 3] - first_chain[k + 2] != 1:
                continue
            a = chains[first_chain[k]]
            b = chains[first_chain[k + 2]]
            while strip[a] != a:
                strip[a] = strip[strip[a]]
                a = strip[a]
            while strip[b] != b:
                strip[b] = strip[strip[b]]
                b = strip[b]
            if pin[a] and pin[b] and pin[a] != pin[b]:
                continue
            both = max(pin[a], pin[b])
            most = max(low_end[a], low_end[b])
            if both and both < most:
                continue
            strip[max(a, b)] = min(a, b)
            pin[min(a, b)] = both
            low_end[min(a, b)] = most
    for c in range(len(strip)):
        # Names are smaller than the chains they stand for, and done before.
        strip[c] = strip[strip[c]]
    return strip
