"""Widths that make patterns meet lengths and strokes: by the compiled core, or by CP-SAT.

Read systems (what is to be solved), sieve (what need not be), strokes (what strokes make of
a system), feasibility and batch (all patterns of a class at once), solve (one pattern) and cpsat
(the same by a general solver). The matching itself is in rust/query/src/solving: halves and
matching (is there a solution, and which are there) and evenness (the best of them).
"""
