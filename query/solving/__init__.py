"""Widths that make patterns meet lengths and strokes: an integer program for each pattern.

:class:`query.solving.widths.WidthSolver` solves it. Below it, feasibility answers for whole classes
of patterns by their lengths alone, on the linear systems of systems, and cpsat is a second, general
solver that the compiled core is held to.
"""
