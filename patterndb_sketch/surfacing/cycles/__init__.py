"""The cycles of a curve network that bound patches, found from the curves alone."""

from patterndb_sketch.surfacing.cycles.find import find_cycles
from patterndb_sketch.surfacing.cycles.found import FoundCycles

__all__ = ["FoundCycles", "find_cycles"]
