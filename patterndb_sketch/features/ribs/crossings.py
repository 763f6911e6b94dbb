"""Where edges of segments cross and touch, how far they hang over there, and which segments belong
together: they cross, touch, or leave a small gap between them."""

from __future__ import annotations

#: How many times as long the longer of two overhangs may be at a crossing. Surfaces that were
#: drawn out to meet go on beyond by much the same; one that ends against a lip does not.
ALIKE = 5.0
