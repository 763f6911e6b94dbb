"""Find what of a network is near a point of the surface, and how a surface stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.network import (
    AtChain,
    AtNode,
    Network,
    Samples,
    find_nearest_node,
    find_nearest_place,
    take_samples,
)
from patterndb_sketch.retopo.tools.stroke import MOST_ENDS, find_end


@dataclass(slots=True)
class NetworkPicker:
    """Finds what of a network is near a point; samples are kept while it is the same."""

    _network: Network | None = None
    _samples: Samples | None = None

    def of(self, network: Network) -> Samples:
        """All samples of its curves."""
        if self._samples is None or network is not self._network:
            self._network, self._samples = network, take_samples(network)
        return self._samples

    def chain(
        self, network: Network, foot: SurfacePoints, reach: float
    ) -> tuple[int, Points] | None:
        """The curve within a reach of a foot, and its point (3,) that is nearest."""
        found = find_nearest_place(self.of(network), foot.points[0], foot.normals[0], reach)
        return (
            None
            if found is None
            else (found.chain, find_chain_point(network, found.chain, found.place))
        )

    def node(self, network: Network, foot: SurfacePoints, reach: float) -> Points | None:
        """(3,) the node within a reach of a foot that is nearest."""
        valences = range(1, MOST_ENDS)
        node = find_nearest_node(network, foot.points[0], foot.normals[0], reach, valences)
        return None if node is None else node.point

    def end(self, network: Network, foot: SurfacePoints, snap: float) -> Points | None:
        """(3,) where an end of a stroke at a foot snaps to."""
        point, normal = foot.points[0], foot.normals[0]
        found = find_end(network, self.of(network), point, normal, snap)
        if isinstance(found, AtNode):
            return network.nodes[found.node].point
        if isinstance(found, AtChain):
            return find_chain_point(network, found.chain, found.place)
        return None


def find_chain_point(network: Network, chain: int, place: float) -> Points:
    """Find (3,) the point at a place of a chain."""
    line = network.chains[chain].round
    first = min(int(place), len(line) - 2)
    return line[first] + (place - first) * (line[first + 1] - line[first])


#: What a surface stands on is at its lower end within this part of its height, and faces down by
#: this cosine.
FOOT, DOWN = 0.02, 0.95

#: It stands along z if it has that much of its box's base there, and that many times what it has
#: along y.
BASE, MORE = 0.05, 3.0


def find_upright(surface: Surface) -> str:
    """Find the axis, y or z, that a surface seems to stand along: z if it is flat at its lower end
    there and not along y. Most that were modelled stand along y, and some that were measured along
    z."""
    corners = surface.vertices[surface.triangles]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    size = np.linalg.norm(area, axis=1)

    def base(axis: int) -> float:
        """The part of the box's base that the surface stands on."""
        feet = (corners[..., axis] <= low[axis] + FOOT * (high - low)[axis]).all(axis=1)
        feet &= -area[:, axis] > DOWN * size
        whole = float(np.delete(high - low, axis).prod())
        return float(size[feet].sum()) / whole if whole > 0.0 else 0.0

    return "z" if base(2) >= BASE and base(2) > MORE * base(1) else "y"
