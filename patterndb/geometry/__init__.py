"""Geometry that all parts share: points, polylines, triangles and the tree over them, surfaces."""
