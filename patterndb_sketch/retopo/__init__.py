"""Retopology: quad meshes sketched on a surface of triangles, without any window.

After Takayama, Panozzo, Sorkine-Hornung and Sorkine-Hornung, "Sketch-Based Generation and
Editing of Quad Meshes" (2013). A surface becomes a :class:`~patterndb_sketch.retopo.ground.Ground`;
strokes on it make a network of curves, whose loops are filled with patterns.
"""

from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.sizes import Sizes

__all__ = ["InvalidRetopoError", "RefusedError", "Sizes"]
