"""Candidate chords: from every end to the nearest corner and to the closest point across."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.chords.candidates import candidates, endpoints
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop

#: Two lengths, angles or coordinates count as equal below this share of their scale. A curve
#: sampled from its other end gives points that differ in the 16th digit; 1e-9 is far above
#: that, and far below what can be seen.
#: The same as in rust/surfacing/src/chords/candidates.rs.
SAME = 1e-9

#: A smooth stretch that turns by more than this gets an end inside, in radians: 45 degrees. The
#: paper bounds the turning without saying by what. The bend of an eighth of a circle rises 1/10
#: of its chord above it, little enough for one nearly flat piece.
TURNING_BOUND = math.radians(45)


#: A chord hugs the loop where the shorter way along the loop is no longer than this many times
#: the chord: it would cut off a sliver. Spec: 1.15; an arc of a circle reaches it at 104 degrees.
#: The same as in rust/surfacing/src/chords/candidates.rs.
HUGGING = 1.15

#: Points are near each other within two edges of the loop, or this share of the chord's length.
#: The same as in rust/surfacing/src/chords/candidates.rs.
NEAR_EDGES = 2.0
NEAR_SHARE = 0.25


def find_endpoints(loop: Loop, turning_bound: float = TURNING_BOUND) -> NDArray[np.int64]:
    """(e,) positions in the loop, ascending, from which chords start.

    All corners; then, wherever the loop turns between two ends by more than ``turning_bound``
    (radians, above 0), a local maximum of curvature if there is one, else samples that part the
    turning evenly. Strictly between neighbouring ends the loop turns by no more than the bound.
    The answer does not depend on where the loop starts and which way it runs.

    Raises InvalidNetworkError for a bound that is not above 0 and finite.
    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it walks along the
    cycle and places samples as it goes, which would depend on start and sense; here the
    turning between two ends is parted evenly.
    """
    if not (math.isfinite(turning_bound) and turning_bound > 0):
        raise InvalidNetworkError(
            f"the turning bound is {turning_bound}; give an angle in radians above 0"
        )
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    return np.flatnonzero(endpoints(points, corners, float(turning_bound)))


@dataclass(frozen=True, slots=True)
class Candidates:
    """The chords that a search may choose from.

    chords:      (c, 2) int64 positions i < j in the loop, ascending, no two alike.
    ends:        (e,) int64 positions of the ends that were given, ascending.
    n_made:      how many of the chords' ends are none of those: closest points of their own.
    n_unmatched: how many of the given ends no chord has.
    """

    chords: NDArray[np.int64] = field(repr=False)
    ends: NDArray[np.int64] = field(repr=False)
    n_made: int
    n_unmatched: int


def find_candidates(loop: Loop, ends: NDArray[np.int64]) -> Candidates:
    """Chords from the ends (e,), positions in the loop, nearly perpendicular to it there.

    Each end has up to two: one to the nearest corner within 40 degrees of the normal plane, one
    to the closest point within 30. The latter ends at another end near the closest point, if one
    qualifies. If the corner is near the closest point, only the chord to the corner is kept.
    At a corner, the curve's tangent is the incoming or the outgoing edge's or half between. No
    chord joins neighbours or hugs the loop (HUGGING). The answer does not depend on where the
    loop starts and which way it runs.

    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it asks in one sentence
    to drop the chord of an end without a corner, and promises in another at least one chord for
    every end; here the chord to the closest point stays, an end may have none, and
    ``n_unmatched`` counts those. The paper's "close together" is NEAR_EDGES and NEAR_SHARE here.
    """
    given = np.unique(np.asarray(ends, np.int64))
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    pairs = np.sort(candidates(points, corners, given), axis=1)
    n = len(points)
    chords = np.stack(np.divmod(np.unique(pairs[:, 0] * n + pairs[:, 1]), n), axis=1)
    used = np.unique(chords)
    matched = int(np.isin(given, used, assume_unique=True).sum())
    return Candidates(chords, given, len(used) - matched, len(given) - matched)
