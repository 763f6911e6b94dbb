"""Retopology: quad meshes sketched on a surface of triangles, without any window.

After Takayama, Panozzo, Sorkine-Hornung and Sorkine-Hornung, "Sketch-Based Generation and
Editing of Quad Meshes" (2013). Strokes on a :class:`~patterndb.geometry.surface.Surface` make a
network of curves, whose loops are filled with patterns.

Read :mod:`.tracing`, :mod:`.network`, :mod:`.counts` and :mod:`.filling`, then :mod:`.symmetry` and
:mod:`.draft` (a first network by the machine); then :mod:`.tool` (what a tool is, with
:mod:`.arguments`), :mod:`.tools`, :mod:`.table` (all of them) and :mod:`.editor`, which obeys calls
of them on a state. :mod:`.script`,
:mod:`.session` and :mod:`patterndb_sketch.recovery` keep its work; :mod:`.quadimport` begins
it from quads.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from patterndb_sketch.retopo.editor import Call, Outcome
    from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
    from patterndb_sketch.retopo.filling import FilledNetwork, RetopoMesh
    from patterndb_sketch.retopo.filling.report import Report, report_mesh
    from patterndb_sketch.retopo.quadimport import QuadImport, import_quads
    from patterndb_sketch.retopo.script import play_script, read_script
    from patterndb_sketch.retopo.sizes import Sizes

__all__ = [
    "Call",
    "FilledNetwork",
    "InvalidRetopoError",
    "Outcome",
    "QuadImport",
    "RefusedError",
    "Report",
    "RetopoMesh",
    "Sizes",
    "import_quads",
    "play_script",
    "read_script",
    "report_mesh",
]

#: The module that defines each public name.
_HOMES = {
    "Call": "patterndb_sketch.retopo.editor",
    "FilledNetwork": "patterndb_sketch.retopo.filling",
    "InvalidRetopoError": "patterndb_sketch.retopo.errors",
    "Outcome": "patterndb_sketch.retopo.editor",
    "QuadImport": "patterndb_sketch.retopo.quadimport",
    "RefusedError": "patterndb_sketch.retopo.errors",
    "Report": "patterndb_sketch.retopo.filling.report",
    "RetopoMesh": "patterndb_sketch.retopo.filling",
    "Sizes": "patterndb_sketch.retopo.sizes",
    "import_quads": "patterndb_sketch.retopo.quadimport",
    "play_script": "patterndb_sketch.retopo.script",
    "read_script": "patterndb_sketch.retopo.script",
    "report_mesh": "patterndb_sketch.retopo.filling.report",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
