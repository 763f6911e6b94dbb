"""Constructed fills: where no pattern fits, one is put together of parts.

Read plan (how an outline is cut up, what fills its parts, and the mesh that they make),
pentagon_cuts and reflex_cuts (where to cut), planner (which plans there are) and constructed (their
fills, best first).
"""

from query.construct.constructed import construct_fills
from query.construct.plan import Lookup, MeshPart, PartFill, compose_parts

__all__ = ["Lookup", "MeshPart", "PartFill", "compose_parts", "construct_fills"]
