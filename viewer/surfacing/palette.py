"""Which tint each piece of a surface gets: neighbours differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from patterndb.core.halfedge import Int64Array
from viewer.style import TINTS

#: What a tint costs a piece beside one that has it, and two steps from one that has it; each
#: piece that has it anywhere costs 1.
BESIDE, NEARBY = 1_000_000, 50


def piece_tints(
    pieces: Sequence[Int64Array], owners: Sequence[int], kept: Mapping[int, int] | None = None
) -> Int64Array:
    """(p,) the tint of every piece, an index of style.TINTS.

    pieces: the faces (f, 3) or (f, 4) of each, of common vertices. owners: the patch of each;
    the first piece of every patch is served before the others. kept: tints that pieces have
    already: they are kept as far as neighbours allow, so that a picture keeps its colours when
    it changes.
    """
    beside = neighbours(pieces)
    before = {} if kept is None else kept
    seen: set[int] = set()
    firsts = [piece for piece, own in enumerate(owners) if own not in seen and not seen.add(own)]
    order = sorted(range(len(pieces)), key=lambda piece: (piece not in before, piece not in firsts))
    tint = np.full(len(pieces), -1, np.int64)
    used = np.zeros(len(TINTS), np.int64)
    for piece in order:
        cost = used.copy()
        for near in beside[piece]:
            if tint[near] >= 0:
                cost[tint[near]] += BESIDE
            for far in beside[near]:
                if tint[far] >= 0:
                    cost[tint[far]] += NEARBY
        best = int(cost.argmin())
        wanted = before.get(piece, best)
        tint[piece] = wanted if cost[wanted] < BESIDE else best
        used[tint[piece]] += 1
    return tint


def neighbours(pieces: Sequence[Int64Array]) -> list[set[int]]:
    """For every piece those that share an edge with it, chords and curves alike."""
    keys: list[Int64Array] = [np.zeros((0, 2), np.int64)]
    names: list[Int64Array] = [np.zeros(0, np.int64)]
    for name, faces in enumerate(pieces):
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        around = np.unique(np.sort(ends, axis=1), axis=0)
        keys.append(around)
        names.append(np.full(len(around), name))
    key, name = np.concatenate(keys), np.concatenate(names)
    order = np.lexsort((name, key[:, 1], key[:, 0]))
    key, name = key[order], name[order]
    beside: list[set[int]] = [set() for _ in pieces]
    # More than two patches may meet along a curve.
    start = 0
    cuts = np.flatnonzero((key[1:] != key[:-1]).any(axis=1)) + 1
    for end in (*cuts.tolist(), len(key)):
        meeting = name[start:end].tolist()
        for one in meeting:
            beside[one].update(other for other in meeting if other != one)
        start = end
    return beside
