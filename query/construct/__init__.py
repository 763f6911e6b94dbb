"""Constructed fills: where no pattern fits, one is put together of parts.

Read plan (how an outline is cut up, and the mesh of its parts), parts (the pentagon and the
rectangle, which need no table), trim and prolong (where to cut), planner (which plans there are)
and constructed (what they come to, best first).
"""

from query.construct.constructed import construct_fills
from query.construct.plan import Lookup, MeshPart, PartFill, compose_parts

__all__ = ["Lookup", "MeshPart", "PartFill", "compose_parts", "construct_fills"]
