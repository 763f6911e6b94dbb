"""The cycles of a curve network that bound patches, found from the curves alone."""

from sketch.surfacing.cycles.find import FoundCycles, find_cycles

__all__ = ["FoundCycles", "find_cycles"]
