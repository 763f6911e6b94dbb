"""Widths that make patterns meet lengths and strokes: kernels, and CP-SAT as second opinion."""
