"""The uncapacitated b-matching on the sides of one pattern: is there one, and which are there?

Given slack_i >= 0 for every side and classes that join sides (i, j), find integers
y_ij >= 0 with sum_j y_ij + 2 y_ii = slack_i: how much wider than 1 the polychords of each
class are in sum.

:func:`search_matchings` lists solutions depth-first; :func:`choose_class` says where it branches
and within which bounds, and :func:`query.solving.systems.is_balanced` rejects by parity. Source:
the integer program of Marcias et al. 2015, section 4. Differs from the paper: an own search instead
of a general solver, over classes instead of single polychords, since one class is one variable to
the sides.

:func:`is_matchable` decides whether there is a solution at all. A flow (:mod:`.halves`) gives a
matching with halves. Rounding the halves down leaves some sides short by a few units. The rest is
a matching problem in an ordinary graph, solved by augmenting paths (Edmonds, "Paths, trees, and
flowers", 1965), so that the decision is exact and takes polynomial time.

Give each side as many *copies* as it has slack, and join two copies wherever a class joins
their sides (two copies of one side if that side is joined to itself). A matching of the
sides is a perfect matching of the copies; one that leaves sides short leaves copies single.
If a perfect matching exists, then from every single copy there leads an augmenting path:
the difference of the two matchings. So one search from one single copy either shortens the
deficit or proves that there is no matching at all.

The copies need not all be made: two pairs of each class are enough, and one of a class
that joins a side to itself. Let a shortest augmenting path walk through two pairs of one
class in the same direction, (i', j') first and (i'', j'') later, and let x be the copy
before i'. Then x is joined to i'' as well, since copies of one side have the same
neighbours, and the path that goes from x to i'' at once is shorter. So each direction
occurs at most once; a class of a side with itself has only one.
"""

from __future__ import annotations

#: Pairs of a class that a shortest augmenting path may use: one in each direction.
PAIRS = 2


#: ``choose`` found every class decided, or that no solution is left.
DONE = -1


#: Dead ends after which a search no longer trusts its cheap bounds and asks, wherever it
#: branches, whether there is a solution at all. Most searches meet none; those that do may
#: meet millions. From then on the time between two solutions is polynomial.
PATIENCE = 30

#: Counting stops here, far above what a caller asks for; a product of two still fits.
MANY = 1 << 30
