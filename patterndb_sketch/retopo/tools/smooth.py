"""The smoothing tool: the jitter of a hand goes from a chain, its ends stay."""

from __future__ import annotations

from typing import Any

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import NEAR_CURVE
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.structure import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.course import note_crossings
from patterndb_sketch.retopo.tracing import smooth_polyline
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: Rounds of smoothing at one call. Source: the released program of Takayama et al. 2013.
ROUNDS = 25

#: Fewest points of an open chain and of a closed one.
FEWEST_OPEN, FEWEST_CLOSED = 5, 3


def smooth_chain(network: Network, surface: Surface, sizes: Sizes, chain: int) -> Edit:
    """ROUNDS of smoothing as strokes get it, each projected; the ends of an open chain stay, and
    patches stay patches.

    Raises RefusedError for a border or the seam of symmetry and for an open chain of fewer than
    5 points, InvalidRetopoError for a chain that is not there.
    Source: the program of Takayama et al. 2013.
    """
    line = network.chain(chain)
    if line.marked:
        raise RefusedError("a border or the seam of symmetry stays as it is")
    least = FEWEST_CLOSED if line.is_closed_loop else FEWEST_OPEN
    if len(line.points) < least:
        raise RefusedError(f"the curve has fewer than {least} points: it is as smooth as can be")
    points, normals = line.points, line.normals
    for _ in range(ROUNDS):
        points, normals = take_to_surface(
            smooth_polyline(points, 1, line.is_closed_loop), normals, surface, sizes
        )
    builder = NetworkBuilder(network)
    builder.reshape_chain(chain, points, normals)
    after = builder.finish()
    return Edit.of(network, after, note_crossings(network, after, [chain], sizes))


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    chain = work.find_chain(a["at"])
    return work.keep_edit(smooth_chain(work.network, work.surface, work.state.sizes, chain))


SMOOTH = Tool(
    "smooth",
    "Smooth a curve between its ends.",
    {"at": NEAR_CURVE},
    _act,
    position=160,
    snaps=True,
    control=Control("f", "smooth", "click a curve: it becomes smooth", target="chain"),
)
