"""The most even widths: the K best solutions of one system, without listing them all.

The key of a solution is the sum of w_p x_p**2 over the open polychords, where w_p is 1, or,
where the boundary has geometry, grows with the squares of the edge lengths at p's two ends.
The strands' ends cover the boundary whichever the solution, so among all solutions of one
pattern, in any orientation, this sum and the squared deviation from the mean differ by a
constant: the smallest sum is the most even solution, in edges or in length, and the key is
an exact integer. Strokes come first: every edge by which a strand's end is off its stroke's
counts more than all widths together. Ties go to the lexicographically smaller widths, in
label order.

Branch and bound over classes. A price u_s on the slack of every side turns the key into a
constant plus one *excess* >= 0 per class (Lagrangian duality), so that a partial solution
is dropped as soon as the excesses of its decided classes exceed what the K-th best
leaves. Any prices give a valid bound; those of the continuous problem give a tight one.
Prices are integers in units of 1/SCALE: nothing is lost to rounding.

A polychord that strokes divide is several variables to the search, its *parts*. Squares
being convex, the parts' own squares bound the polychord's from below, so the same bound
holds; whole keys are computed where a solution is complete. Last, :func:`spread_slack` splits each
class's slack among its polychords, most evenly first.
"""

from __future__ import annotations

#: Units of price per unit of the key; finer prices no longer tighten the bound.
SCALE = 64

#: Rounds of coordinate ascent on the prices. Fewer give a weaker bound, never a wrong one.
ROUNDS = 60


#: What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most
#: 2,000, so the squares add up to at most 1,000**2, each times a weight of at most MAX_WEIGHT.
OFF = 1 << 28

#: The weight of a square stays within 1..MAX_WEIGHT.
MAX_WEIGHT = 255
