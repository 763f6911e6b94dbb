"""The cycles of a curve network that bound patches, found from the curves alone."""

from sketch.surfacing.cycles.find import find_cycles
from sketch.surfacing.cycles.found import FoundCycles

__all__ = ["FoundCycles", "find_cycles"]
