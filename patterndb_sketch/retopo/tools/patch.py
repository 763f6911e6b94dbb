"""The patch tool: the loop around a place becomes a patch, or is none any more."""

from __future__ import annotations

from typing import Any

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.arguments import AT, Argument, Flag
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    Edit,
    HalfChain,
    Network,
    NetworkBuilder,
    remove_patch,
    trace_outline,
    walk_face,
)
from patterndb_sketch.retopo.network.flooding import (
    CLEAR,
    Wall,
    explain_no_disk,
    find_gap,
    flood_triangles,
    make_wall,
)
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.wording import format_place

#: A loop that fewer than this part of the triangles speak for, of those that speak for the first,
#: is none.
STRAY = 0.1


def make_patch(network: Network, surface: Surface, place: SurfacePoints) -> Edit:
    """Make a patch of the loop around a place, whatever it encloses.

    place: one foot. Raises RefusedError if no loop is around it, or several are; if the loop has
    an open end, a marked side or fewer than two corners, or goes around no disk of the surface; and
    if it is a patch already.
    """
    half = find_loop(network, surface, place)
    if half in network.patch_of():
        raise RefusedError("this is a patch already")
    loop, _ = walk_face(network.nodes, network.chains, half)
    why = explain_no_disk(surface, trace_outline(network, loop)[0])
    if why is not None:
        raise RefusedError(f"the loop around this place can be no patch: {why}")
    builder = NetworkBuilder(network, surface)
    try:
        return Edit.of(network, builder.finish(also=(half,)))
    except InvalidRetopoError as error:
        raise RefusedError(
            "the loop around this place can be no patch: it has an open end, a marked side or "
            "fewer than two corners; join its ends, or add corners"
        ) from error


def drop_patch(network: Network, surface: Surface, place: SurfacePoints) -> Edit:
    """Let the loop around a place be no patch; its curves stay.

    It stays so until one of its curves is cut, joined or given another corner: then the loop is
    looked at anew, as any. Raises RefusedError if there is no patch.
    """
    patch = network.patch_of().get(find_loop(network, surface, place))
    if patch is None:
        raise RefusedError("there is no patch here; point into one")
    return Edit.of(network, remove_patch(network, patch))


def find_loop(network: Network, surface: Surface, place: SurfacePoints) -> HalfChain:
    """A half-chain of the loop around a place, one foot: the surface is flooded from there up to
    the curves. Raises RefusedError if none is met, or more than one loop."""
    chains = sorted(network.chains)
    if not chains:
        raise RefusedError("there is no curve yet")
    lines = [network.chains[chain] for chain in chains]
    wall = make_wall(surface, [(line.points, line.is_closed_loop) for line in lines])
    at = place.triangles[:1]
    if wall.crossed[at[0]]:
        return _find_beside(network, wall, chains, place)
    found = flood_triangles(surface, wall.crossed, at, np.inf)
    assert found is not None
    inside = np.zeros(len(surface.triangles), np.bool_)
    inside[found[0]] = True
    gap = find_gap(surface, wall, inside)
    if gap is not None:
        raise RefusedError(
            f"a curve around this place leaves the surface at {format_place(gap.point)}, for "
            "another part of it: erase it, or redraw it along the surface; curves further away do "
            "not matter"
        )
    loops = _find_loops(network, surface, wall, chains, wall.beside[inside[wall.beside]])
    if not loops:
        raise RefusedError("no curve is around this place")
    if len(loops) > 1:
        raise RefusedError(
            "several loops are around this place: join them by a curve, or by a cylinder"
        )
    return loops[0]


def _find_loops(
    network: Network, surface: Surface, wall: Wall, chains: list[int], rim: Int32Array
) -> list[HalfChain]:
    """The lowest half-chain of each loop that triangles beside the curves are on the left of."""
    sample, side = wall.side_of(surface, rim)
    votes: dict[HalfChain, int] = {}
    for k in np.flatnonzero(np.abs(side) > CLEAR):
        half = 2 * chains[int(wall.curve[sample[k]])] + int(side[k] < 0.0)
        votes[half] = votes.get(half, 0) + 1
    loops: dict[HalfChain, int] = {}
    for half, count in votes.items():
        first = min(walk_face(network.nodes, network.chains, half)[0])
        loops[first] = loops.get(first, 0) + count
    # Next to a node a triangle may seem to be beside another face's curve.
    most = max(loops.values(), default=0)
    return sorted(first for first, count in loops.items() if count >= STRAY * most)


def _find_beside(
    network: Network, wall: Wall, chains: list[int], place: SurfacePoints
) -> HalfChain:
    """By the nearest curve: on a triangle that one crosses flooding tells nothing."""
    away = place.points[0] - wall.points
    k = int(np.argmin(np.linalg.norm(away, axis=1)))
    left = float(away[k] @ wall.lefts[k]) >= 0.0
    return 2 * chains[int(wall.curve[k])] + (0 if left else 1)


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    change = drop_patch if a["off"] else make_patch
    return work.keep_edit(change(work.network, work.surface, work.find_foot(a["at"])))


PATCH = Tool(
    "patch",
    "Make a patch of the loop around a point, or let it be none.",
    {"at": AT, "off": Argument(Flag(), "let it be none, until its curves change", False)},
    _act,
    position=90,
    control=Control(
        "P", "patch", "click in a loop: it becomes a patch    .: or none", target="patch"
    ),
)
