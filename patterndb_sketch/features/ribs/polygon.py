"""The polygon of a rib in its plane: put together from runs, made simple, sampled with normals.

Polygons run so that the outside is on their right.
"""

from __future__ import annotations

#: The share of its last edge that a polygon loses where its two ends would meet.
SHORTER = 0.02
