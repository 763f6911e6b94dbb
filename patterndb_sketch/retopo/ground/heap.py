"""Keep numbers in a heap by key on flat arrays, for kernels that visit the nearest first.

Not ``heapq``, which takes the other of two equal keys: on regular meshes many are equal, and maps
would not stay what they are, bit for bit.
"""

from __future__ import annotations
