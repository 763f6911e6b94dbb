"""Joining drawn curves: where they meet, the nodes there, and the network that comes of it."""

from patterndb_sketch.surfacing.joining.junctions import Joined, joined, network_of_polylines

__all__ = ["Joined", "joined", "network_of_polylines"]
