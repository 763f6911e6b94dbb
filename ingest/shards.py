"""Cutting a mesh into shards of neighbouring quads, so that several cores can share it."""

from __future__ import annotations

import numpy as np

from patterndb._native.ingest.shards import breadth_first
from patterndb.core.halfedge import Int32Array


def cut_into_shards(twin: Int32Array, component: Int32Array, largest: int) -> Int32Array:
    """(q,) int32 shard of every quad; no shard has more than ``largest`` quads.

    Small components share a shard. A larger one is halved by breadth-first distance from
    an end of it, and each half again, which keeps shards compact: few patches then reach
    into two of them.
    """
    n = len(component)
    shard = np.zeros(n, np.int32)
    order = np.argsort(component, kind="stable").astype(np.int32)
    sizes = np.bincount(component, minlength=1)
    ends = np.cumsum(sizes)
    count = 0
    room = 0
    for end, size in zip(ends.tolist(), sizes.tolist(), strict=True):
        quads = order[end - size : end]
        if size > largest:
            for part in _halves(twin, quads, largest):
                shard[part] = count
                count += 1
            room = 0
        else:
            if size > room:
                count += 1
                room = largest
            shard[quads] = count - 1
            room -= size
    return shard


def _halves(twin: Int32Array, quads: Int32Array, largest: int) -> list[Int32Array]:
    parts: list[Int32Array] = []
    stack = [quads]
    while stack:
        part = stack.pop()
        if len(part) <= largest:
            parts.append(part)
            continue
        inside = np.zeros(len(twin) // 4, np.bool_)
        inside[part] = True
        far = breadth_first(twin, part[0], inside, part)[-1]
        ordered = breadth_first(twin, far, inside, part)
        stack.append(ordered[len(ordered) // 2 :])
        stack.append(ordered[: len(ordered) // 2])
    return parts
