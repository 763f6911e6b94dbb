"""The knot tool: all that meets within a small circle meets in one corner."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import AT, optional_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.builder import AtNode, NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.structure import Chain, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tracing.curves import take_to_surface


def clean_knot(
    network: Network, surface: Surface, sizes: Sizes, point: ArrayLike, normal: ArrayLike
) -> Edit:
    """Replace everything within the snap radius by one corner at a point.

    point, normal: (3,) on the surface. Every chain that leaves the circle is led straight from
    there to the new node, all of whose wedges are corners; it keeps the count of its part
    outside. Chains on the other side of a sheet, whose normals disagree, are not touched.

    Raises RefusedError if nothing is within, if a border or the seam of symmetry is, or if no
    chain leaves the circle. Source: the program of Takayama et al. 2013.
    """
    at, up = np.array(point, np.float64), np.array(normal, np.float64)
    inside = {
        line.id: _is_within(line.points, line.normals, at, up, sizes.snap)
        for line in network.chains.values()
    }
    met = sorted(chain for chain, within in inside.items() if within.any())
    if not met:
        raise RefusedError("nothing is within the circle: press closer to the knot")
    if any(network.chains[chain].marked for chain in met):
        raise RefusedError("a border or the seam of symmetry is within the circle: it stays")
    builder = NetworkBuilder(network)
    rim: list[int] = []
    for chain in met:
        line = network.chains[chain]
        rim += [
            builder.cut_chain(chain, k) for k in _find_passages(line, inside[chain], at, sizes.snap)
        ]
    for chain in sorted(builder.pieces(met)):
        line = builder.chains[chain]
        middle = 0.5 * (line.points[(line.segments - 1) // 2] + line.round[line.segments // 2 + 1])
        if _is_within(middle[None], line.normals[line.segments // 2][None], at, up, sizes.snap)[0]:
            rim += builder.remove_chain(chain)
    rim = [node for node in dict.fromkeys(rim) if node in builder.nodes]
    if not rim:
        raise RefusedError("no curve leaves the circle: erase what is within instead")
    centre = builder.add_node(at, up)
    # None is joined to its lead before all leads are there: these alone tell the order.
    for node, chain in [(node, _add_lead(builder, surface, sizes, node, centre)) for node in rim]:
        (outer, *others) = [h >> 1 for h in builder.nodes[node].ends if h >> 1 != chain]
        if builder.nodes[node].cut and not others:
            kept = builder.chains[outer]
            merged = builder.merge(node)
            if merged is not None:
                builder.set_count(merged, kept.count, kept.pinned)
    return Edit.of(network, builder.finish())


def _is_within(
    points: Points, normals: Points, at: Points, up: Points, radius: float
) -> NDArray[np.bool_]:
    """(n,) which points are within a radius, on the same side of a sheet."""
    return (np.linalg.norm(points - at, axis=1) < radius) & (normals @ up > 0.0)


def _find_passages(
    line: Chain, within: NDArray[np.bool_], at: Points, radius: float
) -> list[float]:
    """Where a chain passes the circle, in samples."""
    inner = np.concatenate([within, within[:1]]) if line.is_closed_loop else within
    away = np.linalg.norm(line.round - at, axis=1) - radius
    found: list[float] = []
    for k in np.flatnonzero(inner[1:] != inner[:-1]):
        one, two = away[k], away[k + 1]
        # Without a change of sign it is the side of the sheet that changes.
        share = one / (one - two) if (one < 0.0) != (two < 0.0) else 0.5
        found.append(float(k + share))
    return found


def _add_lead(
    builder: NetworkBuilder, surface: Surface, sizes: Sizes, node: int, centre: int
) -> int:
    """A straight chain from a node on the circle to its centre."""
    rim, hub = builder.nodes[node], builder.nodes[centre]
    steps = max(2, round(float(np.linalg.norm(hub.point - rim.point)) / sizes.sampling))
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    line = (1.0 - share) * rim.point + share * hub.point
    up = (1.0 - share) * rim.normal + share * hub.normal
    line, up = take_to_surface(line, up, surface, sizes)
    return builder.add_chain(line, up, AtNode(node), AtNode(centre))


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    foot = work.find_foot(a["at"])
    sizes = work.state.sizes
    if a["radius"] is not None:
        sizes = replace(sizes, snap=work.check_length("knot: radius", a["radius"]))
    return work.keep_edit(
        clean_knot(work.network, work.surface, sizes, foot.points[0], foot.normals[0])
    )


KNOT = Tool(
    "knot",
    "Replace what is tangled around a point by one corner.",
    {"at": AT, "radius": optional_length("of the knot")},
    _act,
    position=70,
    control=Control(
        "k", "knot", "click a tangle: it becomes one corner", target="none", brush="snap"
    ),
)
