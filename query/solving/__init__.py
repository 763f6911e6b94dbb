"""Widths that make patterns meet lengths and strokes: kernels, and CP-SAT as second opinion.

Read systems (what is to be solved), sieve (what need not be), halves and matching (is there a
solution, and which are there), evenness (the best of them), strokes (what strokes make of a
system), feasibility and batch (all patterns of a class at once), solve (one pattern) and cpsat (the
same by a general solver).
"""
