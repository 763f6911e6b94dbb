"""Constructed fills: where no pattern fits, one is put together of parts."""

from query.construct.constructed import constructed
from query.construct.plan import Lookup, Part, PartFill, compose, split

__all__ = ["Lookup", "Part", "PartFill", "compose", "constructed", "split"]
