"""The density brush: quads become finer, or coarser, where it is drawn."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.arguments import (
    Argument,
    Flag,
    Number,
    PointList,
    Vector,
    Word,
    optional_length,
)
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import choose_counts
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.network import EVEN, Density, Edit, Network, Paint
from patterndb_sketch.retopo.network.density import MOST
from patterndb_sketch.retopo.symmetry import mirror_paint
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tracing import SurfaceCurve

#: Points of a brush stroke are this part of its radius apart.
SPACING = 0.125

#: Brush strokes that a network keeps, at most: counts are measured over all of them.
MOST_STROKES = 1000

#: A chain is painted on if what it asks for changes by more than this part.
CHANGED = 1e-3

HOW = ("finer", "coarser", "even")


def make_paint(stroke: SurfaceCurve, radius: float, factor: float, *, sets: bool = False) -> Paint:
    """A brush stroke along a line on the surface, of points no nearer than its radius asks for."""
    points, normals = stroke.points, stroke.normals
    if stroke.closed:
        points, normals = (np.concatenate([one, one[:1]]) for one in (points, normals))
    step = np.floor(arc_length(points) / (SPACING * radius))
    keep = np.concatenate([[True], step[1:] > step[:-1]])
    keep[-1] = True
    points, normals = points[keep], normals[keep]
    if len(points) == 1:
        points, normals = np.repeat(points, 2, axis=0), np.repeat(normals, 2, axis=0)
    return Paint(points[:-1].copy(), points[1:].copy(), normals[:-1].copy(), radius, factor, sets)


def paint_density(network: Network, edge: float, density: Density) -> Edit:
    """The network with another density, and its counts chosen anew where that says something.

    edge: target length of an edge, where nothing is painted. Counts that are pinned stay, and so
    do those of chains beside no other patches than ones whose fills the user has chosen, unless
    the density on them changes.
    """
    after = replace(network, density=density)
    painted: set[int] = set()
    for chain in network.chains.values():
        old, new = (
            one.measure(chain.round, chain.round_normals)[1][-1]
            for one in (network.density, density)
        )
        if abs(new - old) > CHANGED * old:
            painted.add(chain.id)
    chosen: dict[int, bool] = {}
    for patch in network.patches.values():
        choice = filling_of(patch).choice
        for half in patch.loop:
            by_user = choice is not None and choice.by == "user"
            chosen[half >> 1] = chosen.get(half >> 1, True) and by_user
    notes: tuple[str, ...] = ()
    if painted & chosen.keys():
        held = [chain for chain, by_user in chosen.items() if by_user and chain not in painted]
        after, notes = choose_counts(after, edge, held)
        if all(network.chains[c].pinned for c in painted & chosen.keys()):
            notes += ("the counts of all curves under the brush are pinned: they stay",)
    elif not painted and network.chains and density.strokes:
        notes = ("no curve is under the brush: those that are drawn there will heed it",)
    return Edit.of(network, after, notes)


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    edge, network = work.state.sizes.edge, work.network
    given = [name for name in ("points", "at") if a[name] is not None]
    if len(given) + a["anew"] == 0 or len(given) == 2:
        raise InvalidRetopoError("density needs one of points and at, or anew: true")
    if not given:
        return work.keep_edit(paint_density(network, edge, EVEN))
    painted = EVEN if a["anew"] else network.density
    if len(painted.strokes) >= MOST_STROKES:
        raise InvalidRetopoError(
            f"density: {MOST_STROKES} brush strokes are the most; begin again with anew: true"
        )
    radius = work.state.sizes.brush
    if a["radius"] is not None:
        radius = work.check_length("density: radius", a["radius"])
    factor = {"finer": a["times"], "coarser": 1.0 / a["times"], "even": 1.0}[a["how"]]
    stroke = make_paint(_draw(work, a), radius, factor, sets=a["how"] == "even")
    if work.half is not None:
        stroke = mirror_paint(stroke, work.half.plane)
    return work.keep_edit(paint_density(network, edge, painted.painted(stroke)))


def _draw(work: ToolWork, a: dict[str, Any]) -> SurfaceCurve:
    """What is given, on the whole surface: both sides of a plane of symmetry are painted."""
    if a["at"] is None:
        return work.clean_stroke(a["points"], False)
    # What is far off is refused there.
    work.find_foot(a["at"])
    foot = work.whole.nearest(a["at"][None])
    return SurfaceCurve(foot.points, foot.normals, False)


DENSITY = Tool(
    "density",
    "Paint where quads are finer or coarser; counts follow.",
    {
        "points": Argument(PointList(), "the brush's way, on the surface", None),
        "at": Argument(Vector(), "a point of the surface, for a single dab", None),
        "how": Argument(Word(HOW), "finer or coarser than now, or as if never painted", "finer"),
        "times": Argument(Number(1.0, MOST), "edges for each one in the middle of the brush", 2.0),
        "radius": optional_length("of the brush"),
        "anew": Argument(Flag(), "take all paint away first", False, option=False),
    },
    _act,
    position=225,
    control=Control(
        "9",
        "density",
        "paint: quads become finer; how: coarser, or even again",
        "scribble",
        "none",
        "brush",
    ),
)
