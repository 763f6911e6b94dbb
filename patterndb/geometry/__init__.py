"""Geometry that all parts share; topology and codes are in patterndb.core.

Read in this order: points (names of arrays, vectors), polyline, triangulation; adjacency and
surface (triangles and places on them, by the tree of rust/geometry: tree, proximity, casting);
neighbours and quadshape (placed quads); embedding (flat layouts of disks).
"""
