"""The tool that moves a pair of irregular vertices within a patch, its border staying."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import Argument, Vector
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.edgecounts import complete_counts
from patterndb_sketch.retopo.filling.expansion import Expansion
from patterndb_sketch.retopo.filling.fills import fill_patch, filling_of
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.filling.placing import trace_border
from patterndb_sketch.retopo.network import Edit, Network, set_choice
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from query.engine import PatternSource
from query.placing.laplace import HeldQuads
from query.recognition import is_mesh
from query.solving.problem import Labels, WidthProblem
from query.solving.widths import WidthSolver

#: One step changes the width of a polychord by this much at most. Circuits of a graph, which the
#: least changes are, pass an edge twice at most.
REACH = 2

#: So many changes of widths are looked at, the least ones first.
MOST_CHANGES = 1000

#: A pair moves along the drag if it does by this part of the quads' mean edge: below is rounding.
LEAST = 1e-3


def move_pair(
    network: Network,
    surface: Surface,
    source: PatternSource,
    sizes: Sizes,
    patch: int,
    point: ArrayLike,
    drag: ArrayLike,
) -> Edit:
    """Move the two irregular vertices of a patch that are nearest to a point along a drag.

    point: (3,) on the surface; drag: (3,) in the surface's unit. In steps of the least changes
    of the widths of the pattern's polychords under which its sides stay as long: each step takes
    the change, of either sign, that brings the pair furthest along the drag, until the next would
    lead further past its end than this one is short of it. Counts and the pattern stay;
    where the vertices lie is measured between cheap placings, at the means of their neighbours.

    Raises RefusedError if the patch has no irregular vertices, cannot be filled, or none of the
    changes leads along the drag. Source: Takayama et al. 2013, "moving a pair of singularities".
    Differs from the paper: any pattern with room to change, where theirs are those of four sides
    and one parameter; all signs are tried.
    """
    before = network
    by = np.asarray(drag, np.float64)
    way = float(np.linalg.norm(by))
    if way == 0.0:
        return Edit.of(before, before)
    network, told = complete_counts(network, sizes.edge)
    network, _ = fill_patch(network, surface, source, patch)
    at = network.patches[patch]
    former = filling_of(at)
    assert former.choice is not None
    points, _ = trace_border(network, at)
    moving = _MovingPair.of(Expansion.of(former.choice), points, np.asarray(point, np.float64), by)
    best: _TriedMove | None = None
    widths, along = moving.start, 0.0
    while True:
        tried = moving.step(widths, along)
        if tried is None or (best is not None and abs(way - tried.along) >= abs(way - along)):
            break
        best, widths, along = tried, tried.widths, tried.along
    if best is None:
        raise RefusedError(
            f"no irregular vertices of patch {patch} can move this way while its border stays; "
            "drag another way, or give the patch's curves more edges"
        )
    notes = list(told)
    if len(former.moved_vertices[0]):
        notes.append(f"vertices of patch {patch} that were moved by hand are placed anew")
    after = set_choice(network, patch, former.with_choice(moving.expansion.resize(widths.tolist())))
    return Edit.of(before, after, notes)


@dataclass(frozen=True, slots=True, eq=False)
class _TriedMove:
    """widths: of the open polychords. along: how far along the drag the pair is."""

    widths: Int32Array
    along: float


@dataclass(frozen=True, slots=True, eq=False)
class _MovingPair:
    """A pair, and what can be done with it.

    expansion: of the fill as it was. points: (P, 3) of the boundary. pair: (1 or 2,) numbers of
    the vertices, whatever the widths. origin: (k, 3) where they were. direction: (3,) of the
    drag. changes: (c, n) of the widths, the least first. least: a length; less is no move.
    """

    expansion: Expansion
    points: Points
    pair: Int32Array
    origin: Points
    direction: NDArray[np.float64]
    changes: Int32Array
    least: float

    @classmethod
    def of(
        cls, expansion: Expansion, points: Points, at: Points, drag: NDArray[np.float64]
    ) -> _MovingPair:
        pattern = expansion.pattern
        # Expanded anew, the pattern's own interior vertices come first after the boundary; their
        # number is by Euler's formula for a disk.
        quads, vertices = _lay(expansion, np.array(expansion.widths), points)
        edges = sum(len(side) for side in pattern.label)
        own = len(points) + np.arange(pattern.n_quads + 1 - edges // 2)
        valence = np.bincount(quads.ravel(), minlength=len(vertices))
        irregular = own[valence[own] != 4]
        if not len(irregular):
            raise RefusedError(
                "the patch here has no irregular vertices inside; point into one that has"
            )
        away = np.linalg.norm(vertices[irregular] - at, axis=1)
        pair = irregular[np.argsort(away, kind="stable")[:2]]
        edge = vertices[np.roll(quads, -1, axis=1).ravel()] - vertices[quads.ravel()]
        return cls(
            expansion,
            points,
            pair.astype(np.int32),
            vertices[pair],
            drag / np.linalg.norm(drag),
            find_least_changes(pattern.label),
            LEAST * float(np.linalg.norm(edge, axis=1).mean()),
        )

    @property
    def start(self) -> Int32Array:
        """Widths of the open polychords of the fill as it was."""
        return np.array(self.expansion.widths[: self.expansion.pattern.n_chords], np.int32)

    def step(self, widths: Int32Array, along: float) -> _TriedMove | None:
        """The change that leads furthest along the drag, None if none leads on."""
        best: _TriedMove | None = None
        for change in self.changes[(widths + self.changes >= 1).all(axis=1)]:
            quads, vertices = _lay(self.expansion, widths + change, self.points)
            there = float(((vertices[self.pair] - self.origin) @ self.direction).mean())
            if there > (along if best is None else best.along) + self.least and is_mesh(quads):
                best = _TriedMove(widths + change, there)
        return best


def find_least_changes(label: Sequence[Sequence[int]]) -> Int32Array:
    """(c, n) changes of open polychords' widths that leave all sides as long, least squares first.

    label: per side, the polychord that crosses each edge. No sum of two of the same signs is among
    them: it is made by one after the other. They are sought among the MOST_CHANGES least ones that
    change no width by more than REACH.
    """
    room = REACH + 1
    lengths = np.array([room * len(side) for side in label], np.int32)
    solver = WidthSolver(WidthProblem.of_lengths(lengths))
    one = np.zeros(1, np.int64)
    best = solver.find_best(Labels.of_pattern(label), one, np.ones((1, 1), np.bool_), MOST_CHANGES)
    found = best.widths - room
    kept: list[Int32Array] = []
    for change in found[(np.abs(found) <= REACH).all(axis=1) & found.any(axis=1)]:
        parts = (
            one
            for one in kept
            if (one * change >= 0).all() and (np.abs(one) <= np.abs(change)).all()
        )
        if next(parts, None) is None:
            kept.append(change)
    return np.array(kept, np.int32).reshape(-1, found.shape[1])


def _lay(
    expansion: Expansion, widths: NDArray[np.integer], points: Points
) -> tuple[Int32Array, Points]:
    """Quads and vertices of the pattern with these widths, cheaply placed."""
    quads, n_vertices = expansion.quads(widths.tolist())
    return quads, HeldQuads.of(quads, n_vertices, len(points)).place_harmonic(points)


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    start, end = work.find_foot(a["at"]), work.find_foot(a["to"])
    patch = find_patch(work.network, work.surface, a["at"])
    point, drag = start.points[0], end.points[0] - start.points[0]
    return work.keep_edit(
        move_pair(work.network, work.surface, work.source, work.state.sizes, patch, point, drag)
    )


MOVE_PAIR = Tool(
    "movepair",
    "Move the two irregular vertices of a patch that are nearest, its border staying.",
    {
        "at": Argument(Vector(), "a point of the patch, near the pair"),
        "to": Argument(Vector(), "where it is dragged to"),
    },
    _act,
    position=200,
    control=Control("5", "move pair", "drag irregular vertices within a patch", target="patch"),
)
