"""Constructed fills: where no pattern fits, one is put together of parts."""

from query.construct.compose import Part, compose, split
from query.construct.constructed import constructed
from query.construct.lookup import Lookup, PartFill

__all__ = ["Lookup", "Part", "PartFill", "compose", "constructed", "split"]
