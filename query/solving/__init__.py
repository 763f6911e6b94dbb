"""Widths that make patterns meet lengths and strokes: an integer program for each pattern.

:mod:`query.solving.problem` states it, and :class:`query.solving.widths.WidthSolver` solves it.
Below that, feasibility answers for whole classes of patterns by their lengths alone, on the linear
systems of systems, and cpsat is a second, general solver that the compiled core is held to.
"""
