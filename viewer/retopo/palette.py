"""Colours of the window of retopology."""

from __future__ import annotations

#: Quads by the number of their patch's sides; the last are all others.
SIDES = {2: "#f3bfd0", 3: "#a9cdee", 4: "#f7efdc", 5: "#f0c9a0", 6: "#b9dcb4"}
MORE_SIDES = "#d5c2e8"

#: Quads that are flipped, and patches that have no quads.
WRONG = "#e0362c"

#: Edges of quads, curves, curves that are the surface's border or lie on the plane of symmetry.
EDGE = "#79828f"
CURVE = "#27364a"
MARKED = "#7c5cbf"

#: Curves that are images of others.
IMAGE = "#8b96a8"

#: Nodes: corners, and the rim of what is hollow.
CORNER = "#14202e"

#: What is drawn just now, what it snaps to, what would be made, and its quads.
INK = "#d8237a"
SNAP = "#10a37f"
PREVIEW = "#10a37f"
REMADE = "#eaf7f2"
FLOW = "#8a3ffc"
BRUSH = "#5f6b7a"

#: Irregular vertices of 3, of 5, and of any other number of quads.
VALENCES = {3: "#0072b2", 5: "#d55e00"}
OTHER_VALENCE = "#7a1fa2"


def side_colour(sides: int) -> str:
    """The colour of a patch with so many sides."""
    return SIDES.get(sides, MORE_SIDES)


def valence_colour(valence: int) -> str:
    """The colour of an irregular vertex."""
    return VALENCES.get(valence, OTHER_VALENCE)
