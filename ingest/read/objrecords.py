"""What an OBJ file says line by line, before its indices are resolved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Statements over numbers: they may be continued over lines with a backslash.
SKIPPED_NUMERIC = frozenset(
    b"vt vn vp l p s mg lod bevel c_interp d_interp "
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con "
    b"ctech stech res bsp bzp cdc cdp".split()
)
# Statements over names, in which a backslash is a character: a Windows path that ends in one
# must not swallow the face on the next line.
SKIPPED_TEXT = frozenset(b"g o usemtl mtllib usemap maplib shadow_obj trace_obj".split())


@dataclass(frozen=True, slots=True)
class ObjRecords:
    """The vertices and faces of a run of lines.

    points:  (v, 3) float64.
    indices: (c,) int64, as written: from 1, or negative and relative.
    arities: (f,) int64, corners of every face.
    seen:    (f,) int64, vertices of this run read before the face.
    starts:  (f,) int64, byte offset in this run of the line the face starts on.
    """

    points: NDArray[np.float64]
    indices: NDArray[np.int64]
    arities: NDArray[np.int64]
    seen: NDArray[np.int64]
    starts: NDArray[np.int64]
