"""Geometry that all parts share; topology and codes are in patterndb.core.

Read in this order: points (names of arrays, vectors), polyline, triangulation; tree (the one tree
of boxes and the walk down it), proximity and casting (what is asked of it), trianglemesh
(triangles that answer), surface (what fills are placed on); neighbours and quadshape (placed
quads); embedding with relaxation (flat layouts of disks).
"""
