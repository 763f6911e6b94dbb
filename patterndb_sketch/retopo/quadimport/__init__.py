"""Quad mesh import: a mesh becomes a network whose patches are its regular grids.

:func:`imported` checks the mesh (:mod:`.connectivity`), cuts it along its separatrices
(:mod:`.separatrices`, :mod:`.curves`), and makes every grid between them a patch with a regular
fill (:mod:`.grids`) that holds the vertices where they were.
"""

from patterndb_sketch.retopo.quadimport.connectivity import Quads, quads_of
from patterndb_sketch.retopo.quadimport.importing import Imported, imported
from patterndb_sketch.retopo.quadimport.separatrices import separatrices

__all__ = ["Imported", "Quads", "imported", "quads_of", "separatrices"]
