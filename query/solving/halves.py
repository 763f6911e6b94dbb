"""Can the sides' slack be met with halves? The relaxation of the matching, by flow.

Doubled, a half-integral matching is an integral flow from every side to a copy of every
side: slack_i units leave i and arrive at its copy, and class (i, j) carries any number
of units from i to the copy of j and from j to the copy of i. Where there is no such flow
there is no matching.

Two kernels find one. :func:`meet_slack` is for many thousand systems a query, as lists of
neighbours: each begins with a guess that is often right, and where there is no flow the sides that
ask for too much are named, which answers other orientations of the system as well.
:func:`find_transport` is for one system whose classes are decided one after another: the values
that one class takes in all flows are an interval (:func:`tighten_bounds`), which cuts the search
where it would try in vain value by value.

scipy's maximum_flow gives the same answers, takes some 250 times as long for one system
(benchmarks/feasibility.py), and cannot be called within a kernel.
"""

from __future__ import annotations

COPY_BY = 3
QUEUE = 4
