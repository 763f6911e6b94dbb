"""The picture of a slice, one bit to the pixel: dilation, erosion that keeps its topology, and the
outer contours, of which one passes the backbone.

A picture is (rows, columns) uint64, a number to every cell of 8 x 8 pixels: bit 8 y + x of it is
the pixel at x, y in the cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint64]


#: Pixels left free at every side, so that dilation never meets the border. ``MARGIN`` in
#: rust/features/src/ribs/walking.rs is the same.
MARGIN = 12


def _ring_rules() -> NDArray[np.bool_]:
    """(256,) may a pixel go whose neighbours, counter-clockwise from the right, are these bits?

    Yes if the ring switches once each way, and one of the four that share a side is background.
    """
    rules = np.zeros(256, np.bool_)
    for ring in range(256):
        bits = [(ring >> k) & 1 for k in range(8)]
        switches = sum(bits[k] != bits[(k + 1) % 8] for k in range(8))
        rules[ring] = switches == 2 and not all(bits[::2])
    return rules


#: Differs from the paper: it has "at most one switch" alone, which lets interior pixels go (no
#: switch at all); and a pixel whose one background neighbour is across a corner would become a
#: hole. Sides, not corners, join background; corners join foreground. ``MAY_GO`` in
#: rust/features/src/ribs/raster.rs is the same table.
MAY_GO = _ring_rules()
