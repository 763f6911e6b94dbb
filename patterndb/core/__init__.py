"""Quad disks and their patterns. No files, no database.

Read in this order: halfedge and disk (connectivity), code and packing (a disk as numbers), label
and description (what follows from a code), pattern and patternclass, polychord, bundles and
reduction; quadmesh and polygonmesh are meshes of any topology. showing is how a pattern is drawn
in a notebook, by what stands above.
"""
