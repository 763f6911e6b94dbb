"""Writes boot.jsonl: a boot with its laces, in three parts between two rings.

    python examples/retopo/make_boot.py ../shared/data/surfaces/boot.obj

The toe points to +x, y is up, the left side is +z.
"""

from __future__ import annotations

from boot_low import low
from boot_mid import mid
from boot_rings import rings
from boot_top import top
from making import made
from sketching import Sketch

#: Length of edges in the end, in metres: the treads, which have no curves, are 4 mm deep.
EDGE = 0.0095


def draw(s: Sketch) -> None:
    """All curves, part by part."""
    s.once("sizes", snap=0.0008, sampling=0.0005)
    s.spacing, s.fine = 0.002, 0.001
    rings(s)
    low(s)
    mid(s)
    top(s)
    s.once("recount", edge=EDGE)


if __name__ == "__main__":
    made("boot.jsonl", draw)
