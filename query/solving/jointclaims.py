"""What several sides ask of their neighbours together: claims that refuse systems without a flow.

Sides of which no two are joined, and none to itself, can be no wider together than all sides that
any of them is joined to:

    sum of need_i over a set S <= sum of need_j over its neighbours N(S)

where need is by how much a length exceeds the base length. A single side's claim is the sieve's
(:mod:`query.solving.sieve`); those of all sets together say exactly whether halves would do, as
the flow of :mod:`query.solving.halves` does: a set that breaks its claim is a cut. Of a graph of 12
sides there are some 50 sets that no others imply. Those likeliest to be broken are listed for each
graph, and refuse nine in ten of the systems that the flow would, at a twentieth of its price. What
they let pass is not known to fit.

A claim is one number, the set's bits below those of its neighbours. Sums over sets are looked up:
of every five sides the 32 sums of needs.
"""

from __future__ import annotations

#: Sides of the largest graphs with joint claims: a set and its neighbours are 30 bits of a number.
MOST_SIDES = 15

#: Claims of a graph: of what all, some 48 of 12 sides, would refuse 24 refuse 90 %, 32 refuse 93 %
#: (2,489 systems that passed the sieve); a line of the processor's cache holds 16.
MOST_CLAIMS = 32


TABLES = 3
SUMS = 32
