"""Retopology: quad meshes sketched on a surface of triangles, without any window.

After Takayama, Panozzo, Sorkine-Hornung and Sorkine-Hornung, "Sketch-Based Generation and
Editing of Quad Meshes" (2013). Strokes on a :class:`~patterndb.geometry.surface.Surface` make a
network of curves, whose loops are filled with patterns.

Read :mod:`.tracing`, :mod:`.network`, :mod:`.counts` and :mod:`.filling`, then :mod:`.symmetry` and
:mod:`.draft` (a first network by the machine); then :mod:`.tool` (what a tool is, with
:mod:`.arguments`), :mod:`.tools`, :mod:`.table` (all of them) and :mod:`.editor`, which obeys calls
of them on a :mod:`.state`. :mod:`.script`,
:mod:`.session` and :mod:`patterndb_sketch.sessions` keep its work; :mod:`.quadimport` begins
it from quads.
"""

from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.sizes import Sizes

__all__ = ["InvalidRetopoError", "RefusedError", "Sizes"]
