"""The table of tools: what calls there are, and what each does.

A new tool is an entry here: its name, its arguments, and a function that takes its work to a
result. Places are points of the surface, near enough: they are taken to it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from patterndb_sketch.retopo.arguments import Argument, Flag, Line, Number, Vector, Word
from patterndb_sketch.retopo.editor.mirroring import MIRRORING
from patterndb_sketch.retopo.editor.shaping import SHAPING
from patterndb_sketch.retopo.editor.topology import TOPOLOGY
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import (
    changed,
    chosen_anew,
    counted,
    freed,
    stepped,
    strip,
    taken,
    with_flow,
    without_flows,
)
from patterndb_sketch.retopo.filling.location import patch_at
from patterndb_sketch.retopo.tool import LEAST_LENGTH, Result, Tool, Work, snapping
from patterndb_sketch.retopo.tools.autocomplete import autocomplete
from patterndb_sketch.retopo.tools.corners import flip_wedge, toggle
from patterndb_sketch.retopo.tools.cylinder import CAPS, DIVISION, cylinder
from patterndb_sketch.retopo.tools.erase import erase, erase_crossed, erase_open
from patterndb_sketch.retopo.tools.knot import clean_knot
from patterndb_sketch.retopo.tools.loop import loop
from patterndb_sketch.retopo.tools.patch import drop_patch, make_patch
from patterndb_sketch.retopo.tools.spine import spine
from patterndb_sketch.retopo.tools.stroke import insert, insert_on_half

#: Edges along a chain, at most, that a call may ask for.
MOST_EDGES = 500

#: The least of two sizes, as parts of the diagonal: finer ones make millions of quads and samples.
LEAST = {"edge": 1e-3, "sampling": 1e-4}

AT = Argument(Vector(), "a point of the surface")
POINTS = Argument(Line(), "the stroke, on the surface")


def _stroke(work: Work, a: dict[str, Any]) -> Result:
    drawn = work.stroke(a["points"], a["closed"])
    smooth = (a["smooth"], a["smooth"])
    if work.half is not None:
        return work.edited(insert_on_half(work.network, work.half, work.state.sizes, drawn, smooth))
    return work.edited(insert(work.network, work.ground, work.state.sizes, drawn, smooth=smooth))


def _spine(work: Work, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["width"] is not None:
        sizes = replace(sizes, spine=work.length("spine: width", a["width"]) / 2.0)
    drawn = work.stroke_here(a["points"], "the spine", False)
    return work.edited(spine(work.network, work.ground, drawn, sizes))


def _autocomplete(work: Work, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["radius"] is not None:
        radius = work.length("autocomplete: radius", a["radius"])
        sizes = replace(sizes, autocompletion=radius)
    foot = work.foot(a["at"])
    point, normal = foot.points[0], foot.normals[0]
    found = autocomplete(work.network, work.ground, point, normal, sizes, a["choice"])
    return work.edited(found)


def _cylinder(work: Work, a: dict[str, Any]) -> Result:
    drawn = work.stroke_here(a["points"], "the stroke", False)
    return work.edited(
        cylinder(work.network, work.ground, work.state.sizes, drawn, a["division"], a["caps"])
    )


def _loop(work: Work, a: dict[str, Any]) -> Result:
    start = work.foot(a["at"])
    found = loop(work.network, work.ground, work.state.sizes, start, a["normal"], a["limit"])
    return work.edited(found)


def _erase(work: Work, a: dict[str, Any]) -> Result:
    ways = [
        name for name in ("points", "at", "open") if a[name] is not None and a[name] is not False
    ]
    if len(ways) != 1:
        raise InvalidRetopoError("erase needs one of points, at and open")
    if ways == ["open"]:
        return work.edited(erase_open(work.network))
    if ways == ["at"]:
        return work.edited(erase(work.network, [work.chain_at(a["at"])]))
    return work.edited(erase_crossed(work.network, work.stroke(a["points"], False)))


def _knot(work: Work, a: dict[str, Any]) -> Result:
    foot = work.foot(a["at"])
    sizes = work.state.sizes
    if a["radius"] is not None:
        sizes = replace(sizes, snap=work.length("knot: radius", a["radius"]))
    return work.edited(
        clean_knot(work.network, work.ground, sizes, foot.points[0], foot.normals[0])
    )


def _corner(work: Work, a: dict[str, Any]) -> Result:
    foot = work.foot(a["at"])
    point, normal = foot.points[0], foot.normals[0]
    if a["wedge"] is None:
        return work.edited(toggle(work.network, work.state.sizes, point, normal))
    pressed = work.foot(a["wedge"]).points[0]
    return work.edited(flip_wedge(work.network, work.state.sizes, pressed, point, normal))


def _patch(work: Work, a: dict[str, Any]) -> Result:
    change = drop_patch if a["off"] else make_patch
    return work.edited(change(work.network, work.ground, work.foot(a["at"])))


def _subdivide(work: Work, a: dict[str, Any]) -> Result:
    edge = work.state.sizes.edge
    given = [name for name in ("count", "by", "free") if a[name] not in (None, False)]
    if len(given) != 1:
        raise InvalidRetopoError("subdivide needs one of count, by and free")
    if a["at"] is None:
        raise InvalidRetopoError("subdivide needs at: a point of the surface near a curve")
    chain = work.chain_at(a["at"])
    chains = strip(work.network, chain) if a["strip"] else (chain,)
    if given == ["free"]:
        return work.with_network(freed(work.network, chains))
    network, _ = counted(work.network, edge)
    now = {c: network.chains[c].count for c in chains}
    wanted = {c: a["count"] if a["by"] is None else n + a["by"] for c, n in now.items()}
    network, notes = changed(network, edge, wanted, pin=a["pin"])
    return work.with_network(network, notes)


def _recount(work: Work, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["edge"] is not None:
        sizes = replace(sizes, edge=work.length("recount: edge", a["edge"], LEAST["edge"]))
    network, notes = chosen_anew(work.network, sizes.edge)
    return Result(replace(work.state, network=network, sizes=sizes), notes)


def _flow(work: Work, a: dict[str, Any]) -> Result:
    if (a["points"] is None) == (a["clear"] is None):
        raise InvalidRetopoError("flow needs one of points, and clear: a point in the patch")
    if a["points"] is not None:
        drawn = work.stroke_here(a["points"], "the line")
        patch = patch_at(work.network, work.ground, drawn.points[len(drawn.points) // 2])
        line = drawn.points
        if drawn.closed:
            line = np.concatenate([line, line[:1]])
        return work.with_network(with_flow(work.network, patch, line))
    return work.with_network(
        without_flows(work.network, patch_at(work.network, work.ground, a["clear"]))
    )


def _choose(work: Work, a: dict[str, Any]) -> Result:
    if (a["by"] is None) == (a["number"] is None):
        raise InvalidRetopoError("choose needs by, how many on in the list, or number")
    network, notes = counted(work.network, work.state.sizes.edge)
    patch = patch_at(network, work.ground, a["at"])
    if a["by"] is not None:
        return work.with_network(stepped(network, patch, work.source, a["by"]), notes)
    return work.with_network(taken(network, patch, work.source, a["number"]), notes)


def _sizes(work: Work, a: dict[str, Any]) -> Result:
    given = {name: value for name, value in a.items() if value is not None}
    if not given:
        raise InvalidRetopoError(f"sizes needs one or more of {', '.join(a)}")
    for name, value in given.items():
        work.length(f"sizes: {name}", value, LEAST.get(name, LEAST_LENGTH))
    return Result(replace(work.state, sizes=replace(work.state.sizes, **given)))


def _length(what: str) -> Argument:
    return Argument(Number(1e-12), f"{what}, in the surface's unit", None)


_ALL = (
    Tool(
        "stroke",
        "Draw a curve; its ends snap, and where it crosses others both are cut.",
        {
            "points": POINTS,
            "closed": Argument(Flag(), "is it closed? By itself if its ends are near", None),
            "smooth": Argument(Flag(), "no corner where it goes on from an open end", False),
        },
        _stroke,
    ),
    Tool(
        "spine",
        "Draw the midline of a four-sided patch.",
        {"points": POINTS, "width": _length("of the patch")},
        _spine,
    ),
    Tool(
        "autocomplete",
        "Take a patch suggested around a point beside others.",
        {
            "at": AT,
            "choice": Argument(Number(0, 1000, whole=True), "0 for the largest quad", 0),
            "radius": _length("that is looked at"),
        },
        _autocomplete,
    ),
    Tool(
        "cylinder",
        "Join two closed loops by a row of patches.",
        {
            "points": POINTS,
            "division": Argument(
                Number(2, 64, whole=True), "patches between loops without corners", DIVISION
            ),
            "caps": Argument(Word(CAPS), "patches beyond the loops", "auto"),
        },
        _cylinder,
    ),
    Tool(
        "loop",
        "Cut the surface by a plane: the cut is a curve.",
        {
            "at": AT,
            "normal": Argument(Vector(direction=True), "of the plane"),
            "limit": _length("at which it is given up"),
        },
        _loop,
    ),
    Tool(
        "erase",
        "Erase the curves that a scribble crosses, the one at a point, or all with open ends.",
        {
            "points": Argument(Line(), "the scribble", None),
            "at": Argument(Vector(), "a point near the curve", None),
            "open": Argument(Flag(), "all with open ends", False),
        },
        _erase,
    ),
    Tool(
        "knot",
        "Replace what is tangled around a point by one corner.",
        {"at": AT, "radius": _length("of the knot")},
        _knot,
    ),
    Tool(
        "corner",
        "Add or delete a corner; with wedge, switch that wedge between corner and T-junction.",
        {"at": AT, "wedge": Argument(Vector(), "a point in the wedge", None)},
        _corner,
    ),
    Tool(
        "patch",
        "Make a patch of the loop around a point, or let it be none.",
        {"at": AT, "off": Argument(Flag(), "let it be none, until its curves change", False)},
        _patch,
    ),
    Tool(
        "subdivide",
        "Change how many edges a curve has; others follow where they must.",
        {
            "at": Argument(Vector(), "a point near the curve", None),
            "count": Argument(Number(1, MOST_EDGES, whole=True), "edges", None),
            "by": Argument(Number(-MOST_EDGES, MOST_EDGES, whole=True), "edges more", None),
            "strip": Argument(Flag(), "all curves across the strip of quads", False),
            "pin": Argument(Flag(), "keep this count from now on", True),
            "free": Argument(Flag(), "no longer keep the count", False),
        },
        _subdivide,
    ),
    Tool(
        "recount",
        "Choose all counts that are not pinned anew.",
        {"edge": _length("of an edge, from now on")},
        _recount,
    ),
    Tool(
        "flow",
        "Draw a line within a patch that its edges are to follow, or clear a patch's lines.",
        {
            "points": Argument(Line(), "the line", None),
            "clear": Argument(Vector(), "a point in the patch", None),
        },
        _flow,
    ),
    Tool(
        "choose",
        "Take another fill of a patch's list.",
        {
            "at": AT,
            "by": Argument(Number(-1000, 1000, whole=True), "how many on in the list", None),
            "number": Argument(Number(0, 1000, whole=True), "its number in the list", None),
        },
        _choose,
    ),
    Tool(
        "sizes",
        "Change the radii of brushes and the length of edges.",
        {
            name: _length(what)
            for name, what in (
                ("snap", "radius within which ends find targets"),
                ("spine", "half the width of a spine's patch"),
                ("autocompletion", "radius of suggestions"),
                ("brush", "radius of the vertex brush"),
                ("edge", "target length of an edge"),
                ("sampling", "distance of a curve's points"),
            )
        },
        _sizes,
    ),
)

#: The tools by name; "undo" and "redo" are the editor's own.
TOOLS = {tool.name: snapping(tool) for tool in (*_ALL, *SHAPING, *TOPOLOGY, MIRRORING)}
