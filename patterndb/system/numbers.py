"""The largest numbers that options may have, and defaults that several packages share."""

from __future__ import annotations

#: Whole numbers that count something (fills, quads, edges) are at most this large: arrays and
#: the compiled core holds them in 32 bits, and no list is as long.
MOST_COUNT = 2**31 - 1

#: The most edges around a boundary, see :mod:`patterndb.geometry.polyline`, and so the most that an
#: end of a strand can be off.
MOST_EDGES = 2_000

#: Edges that a strand's end may miss the stroke's end by, by default (Marcias et al. 2015, section
#: 4: "in all our experiments, we use K = 1").
TOLERANCE = 1
