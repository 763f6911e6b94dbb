"""Constructed fills: where no pattern fits, one is put together of parts."""

from query.construct.constructed import construct_fills
from query.construct.plan import Lookup, MeshPart, PartFill, compose_parts, split_loop

__all__ = ["Lookup", "MeshPart", "PartFill", "compose_parts", "construct_fills", "split_loop"]
