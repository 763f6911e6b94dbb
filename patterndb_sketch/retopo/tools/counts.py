"""The tools for how many edges there are, and how long: subdivide, recount and sizes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from patterndb_sketch.retopo.arguments import Argument, Flag, Number, Vector, optional_length
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import (
    change_counts,
    choose_counts,
    complete_counts,
    find_strip,
    free_counts,
)
from patterndb_sketch.retopo.tool import LEAST_LENGTH, Control, Result, Tool, ToolWork

#: Edges along a chain, at most, that a call may ask for.
MOST_EDGES = 500

#: The least of two sizes, as parts of the diagonal: finer ones make millions of quads and samples.
LEAST = {"edge": 1e-3, "sampling": 1e-4}


def _subdivide(work: ToolWork, a: dict[str, Any]) -> Result:
    edge = work.state.sizes.edge
    given = [name for name in ("count", "by", "free") if a[name] not in (None, False)]
    if len(given) != 1:
        raise InvalidRetopoError("subdivide needs one of count, by and free")
    if a["at"] is None:
        raise InvalidRetopoError("subdivide needs at: a point of the surface near a curve")
    chain = work.find_chain(a["at"])
    chains = find_strip(work.network, chain) if a["strip"] else (chain,)
    if given == ["free"]:
        return work.keep_network(free_counts(work.network, chains))
    network, _ = complete_counts(work.network, edge)
    now = {c: network.chains[c].count for c in chains}
    wanted = {c: a["count"] if a["by"] is None else n + a["by"] for c, n in now.items()}
    network, notes = change_counts(network, edge, wanted, pin=a["pin"])
    return work.keep_network(network, notes)


SUBDIVIDE = Tool(
    "subdivide",
    "Change how many edges a curve has; others follow where they must.",
    {
        "at": Argument(Vector(), "a point near the curve", None, option=False),
        "count": Argument(Number(1, MOST_EDGES, whole=True), "edges", None, option=False),
        "by": Argument(
            Number(-MOST_EDGES, MOST_EDGES, whole=True), "edges more", None, option=False
        ),
        "strip": Argument(Flag(), "all curves across the strip of quads", False),
        "pin": Argument(Flag(), "keep this count from now on", True),
        "free": Argument(Flag(), "no longer keep the count", False, option=False),
    },
    _subdivide,
    position=100,
    snaps=True,
    control=Control(
        "t", "count", "wheel over a curve: edges; with Shift: of its strip", "count", "chain"
    ),
)


def _recount(work: ToolWork, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["edge"] is not None:
        sizes = replace(sizes, edge=work.check_length("recount: edge", a["edge"], LEAST["edge"]))
    network, notes = choose_counts(work.network, sizes.edge)
    return Result(replace(work.state, network=network, sizes=sizes), notes)


RECOUNT = Tool(
    "recount",
    "Choose all counts again that are not pinned.",
    {"edge": optional_length("of an edge, from now on")},
    _recount,
    position=110,
    control=Control(mode=False),
)


def _sizes(work: ToolWork, a: dict[str, Any]) -> Result:
    given = {name: value for name, value in a.items() if value is not None}
    if not given:
        raise InvalidRetopoError(f"sizes needs one or more of {', '.join(a)}")
    for name, value in given.items():
        work.check_length(f"sizes: {name}", value, LEAST.get(name, LEAST_LENGTH))
    return Result(replace(work.state, sizes=replace(work.state.sizes, **given)))


SIZES = Tool(
    "sizes",
    "Change the radii of brushes and the length of edges.",
    {
        "snap": optional_length("radius within which ends find targets"),
        "spine": optional_length("half the width of a spine's patch"),
        "autocompletion": optional_length("radius of suggestions"),
        "brush": optional_length("radius of the vertex brush"),
        "edge": optional_length("target length of an edge"),
        "sampling": optional_length("distance of a curve's points"),
    },
    _sizes,
    position=140,
    control=Control(mode=False),
)
