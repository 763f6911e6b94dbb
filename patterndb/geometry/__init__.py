"""Geometry that all parts share; topology and codes are in patterndb.core.

Read in this order: points (names of arrays, vectors), polyline, triangulation; trianglemesh
(triangles that answer, by the tree of rust/geometry: tree, proximity, casting), surface (what
fills are placed on); neighbours and quadshape (placed quads); embedding (flat layouts of disks).
"""
