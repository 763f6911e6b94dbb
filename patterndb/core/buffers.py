"""Small operations on arrays for kernels, which numba's own would make slow to compile.

The first assignment of one slice to another costs every process that compiles four seconds, for
the text of an error of unequal shapes; ``np.sort`` and ``np.argsort`` cost two each. These cost a
tenth, and do the same.
"""

from __future__ import annotations
