"""Moves the vertices of a flat disk until every quad is well shaped and none is flipped.

Every corner of every quad is a triangle with a wanted angle and size. Its energy blows up
as its area falls to zero; while some triangle is still flipped the blow-up is smoothed, and
sharpened step by step as the drawing untangles, so that no valid start is needed.

Source: Garanzha et al. 2021, "Foldover-free maps in 50 lines of code", for the energy and
its smoothing. Differs from the paper: L-BFGS runs in one kernel, and the outline may move
by its handles (see :mod:`patterndb.geometry.embedding`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


#: Steps that L-BFGS remembers.
MEMORY = 10
