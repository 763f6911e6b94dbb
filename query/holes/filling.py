"""Fill a hole of a mesh: likely corners, candidates, placing, ranking."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import msgspec
import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.system.requests import make_request
from query.boundary import MIN_PERIMETER, Boundary
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.holes.candidates import HoleSearch
from query.holes.caps import FlatCap, list_cap_quads
from query.holes.corners import MOST_QUADS
from query.holes.fills import HoleFill, HoleFills, number_fill
from query.holes.loops import Hole, choose_hole, hole_on_loop
from query.holes.models import HoleModels, shipped_models
from query.holes.neighbourhood import (
    HoleRim,
    Neighbourhood,
    extract_neighbourhood,
    find_border_places,
    list_faces_near,
)
from query.holes.options import HoleOptions
from query.holes.parity import refuse_unfillable
from query.holes.projection import HoleProjector
from query.holes.ranking import Shortlist, rank_candidates
from query.holes.symmetry import TwinFinder, find_rest, prepare_twins
from query.holes.topology import MeshTopology
from query.recognition import read_fill

#: Fills of a hole of which the other side shows a part; and what their score, which is that of the
#: rest, is raised by: they come before all that do not follow the other side.
CONTINUED, AHEAD = 12, 100.0

#: Rings of faces around a hole that are looked at, and one more.
SEEN = 4


def fill_holes(
    db: PatternSource,
    mesh: PolygonMesh | MeshTopology | Hole,
    options: HoleOptions | None = None,
    *,
    loop: int | Sequence[int] | None = None,
    faces: Iterable[int] | None = None,
    models: HoleModels | None = None,
    **choices: Any,
) -> HoleFills:
    """List the fills of one hole of a mesh, placed, best first, as an iterator.

    db: a database. mesh: a polygon mesh, its topology, or one of its holes.
    options: how the hole is to be filled. loop: one or more vertices of a border loop; without it,
    and without faces, the mesh must have exactly one. faces: quads, triangles or n-gons to be
    replaced. models: of what artists do; by default those that come with the package.
    choices: entries of the options, in place of options or of some of their entries.

    Every even loop of 4 to 2,000 edges has fills; with corners that the caller fixes the list is
    empty where no fill is found that has them. Raises InvalidMeshError for what is no loop, for a
    hole with an island and for a fill of another mesh, InvalidQueryError for an odd loop
    (:func:`list_parity_fixes` lists the nearest remedies), corners that are none, and for options
    that contradict each other or the rest.
    """
    asked = make_request(HoleOptions, options, choices)
    hole = choose_hole(mesh, loop=loop, faces=faces)
    if asked.ngon:
        found: Iterator[HoleFill] = iter([_make_ngon_fill(hole)])
    else:
        refuse_unfillable(hole)
        fixed = _locate_corners(hole, asked.corners)
        if any(fill.hole.topology is not hole.topology for fill in asked.like):
            raise InvalidMeshError(
                "like has a fill of another mesh; give fills of this one's holes"
            )
        found = _list_fills(db, hole, asked, fixed, models or shipped_models())
    return HoleFills(hole, found, asked.limit, asked.time_limit)


def _locate_corners(hole: Hole, corners: Mapping[int, int]) -> dict[int, int]:
    """Return the quads that the caller fixes, by places in the loop."""
    place = {int(v): i for i, v in enumerate(hole.loop)}
    fixed: dict[int, int] = {}
    for vertex, quads in corners.items():
        if vertex not in place:
            raise InvalidQueryError(f"vertex {vertex} is not on the loop")
        if not 1 <= quads <= MOST_QUADS:
            raise InvalidQueryError(
                f"{quads} quads at vertex {vertex}; a loop vertex has 1 to {MOST_QUADS} within"
            )
        fixed[place[vertex]] = quads
    return fixed


def _list_fills(
    db: PatternSource, hole: Hole, options: HoleOptions, fixed: dict[int, int], models: HoleModels
) -> Iterator[HoleFill]:
    around = extract_neighbourhood(hole)
    search = HoleSearch.begin(db, hole, around, models, options, fixed)
    made = _FillMaker(hole, around, HoleProjector.of(hole, around, options), models)
    if options.twins and not options.strokes and not fixed:
        for fill in _list_mirrored(db, made, options):
            if search.take_new(fill.local, len(hole) + len(fill.points)) is not None:
                yield fill
    cap = made.projector.cap
    if cap is not None and cap.apart and not options.strokes:
        yield from _list_cap_fills(made, cap, search)
    yield from _list_ranked(search, Shortlist(made.projector, models.facts, models.whole), made)


@dataclass(frozen=True, slots=True, eq=False)
class _FillMaker:
    """Makes the fills of one hole from quads in the loop's numbering.

    models: for the fills of a part of it.
    """

    hole: Hole
    around: Neighbourhood
    projector: HoleProjector
    models: HoleModels

    def make(
        self, local: Int32Array, points: Points, *, score: float = np.inf, **entries: Any
    ) -> HoleFill:
        """Number a fill's vertices as those of the mesh.

        local: (q, 4) int32. points: (k, 3) the inner vertices. entries: others of the fill.
        """
        return number_fill(
            self.hole, self.around.regular_valence, local, points, score=score, **entries
        )

    def mirror(
        self, local: Int32Array, points: Points, *, flat: bool = False, **entries: Any
    ) -> HoleFill:
        """Make a fill that lies as the other side does, or as the caller chose."""
        points, flipped, flat = self.projector.place_mirrored(local, points, flat)
        return self.make(local, points, flipped=flipped, flat=flat, **entries)


def _make_ngon_fill(hole: Hole) -> HoleFill:
    """Make a fill of one face with all vertices of a loop."""
    n = len(hole)
    if len(set(hole.loop.tolist())) < n:
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} runs through a vertex twice, and a face "
            "cannot; leave ngon out"
        )
    regular_valence = extract_neighbourhood(hole).regular_valence
    none = np.zeros((0, 4), np.int32)
    fill = number_fill(hole, regular_valence, none, np.zeros((0, 3)), score=np.inf)
    valences = np.where(find_border_places(hole), 0, fill.valences + 1).astype(np.int32)
    return replace(fill, corners=np.ones(n, np.int32), valences=valences, ngon=hole.loop)


def _list_mirrored(db: PatternSource, made: _FillMaker, options: HoleOptions) -> Iterator[HoleFill]:
    """List mirror images: of the other side, of a fill that is given, or of a part of the hole."""
    twins = prepare_twins(made.hole.topology)
    twin = twins.find(made.hole)
    if twin is not None:
        yield made.mirror(*twin, twin=True)
    elif (same := _mirror_fill(made, options.like, twins)) is not None:
        yield same
    elif (part := twins.find_part(made.hole)) is not None:
        yield from _continue_part(db, made, options, *part)


def _mirror_fill(made: _FillMaker, like: Sequence[HoleFill], twins: TwinFinder) -> HoleFill | None:
    """Turn the fill of a hole of which this one is the mirror image, and place it."""
    for other in like:
        if other.ngon is not None:
            continue
        match = twins.match(made.hole, other.hole)
        if match is None:
            continue
        # The same fill fits only where the same valences are regular.
        there = extract_neighbourhood(other.hole).regular_valence[match.places]
        if (there != made.around.regular_valence).any():
            continue
        n_vertices = len(made.hole) + len(other.points)
        quads = match.mirror_quads(other.local, n_vertices)
        if match.exact:
            points = match.mirror_points(other.points)
            return made.mirror(quads, points, flat=other.flat, twin=True)
        points, flipped = made.projector.place(quads, n_vertices)
        if flipped <= other.flipped:
            return made.mirror(quads, points, flat=made.projector.is_flat, twin=True)
    return None


def _continue_part(
    db: PatternSource,
    made: _FillMaker,
    options: HoleOptions,
    mirrored: Int32Array,
    points: Points,
) -> Iterator[HoleFill]:
    """Fill a hole across the plane of symmetry: what the other side shows of it is mirrored, and
    the rest, which is its own mirror image, is a hole to be filled."""
    hole = made.hole
    rest = find_rest(mirrored, len(hole))
    if rest is None or len(rest) % 2 or len(rest) < MIN_PERIMETER:
        return
    if not HoleRim.of(hole).admits(mirrored):
        return
    part = made.make(mirrored, points)
    n, n_old = len(hole), len(hole.topology.mesh.points)
    vertices = [int(hole.loop[v]) if v < n else v - n + n_old for v in rest]
    # The mesh near the hole is enough, all faces turned as the hole is.
    t = hole.topology
    faces = part.quads.tolist()
    for f in list_faces_near(hole, SEEN):
        face = t.tail[t.start[f] : t.start[f + 1]].tolist()
        faces.append(face[::-1] if t.flipped[f] else face)
    near = PolygonMesh.from_faces(np.concatenate([t.mesh.points, part.points]), faces)
    smaller = hole_on_loop(MeshTopology.of(near), vertices)
    alone = msgspec.structs.replace(
        options, corners={}, strokes=(), tolerance=0, twins=False, like=()
    )
    place = {int(v): i for i, v in enumerate(hole.loop)}
    for fill in islice(_list_fills(db, smaller, alone, {}, made.models), CONTINUED):
        quads = [[place.get(v, v - n_old + n) for v in quad] for quad in fill.quads.tolist()]
        local = np.array([*mirrored.tolist(), *quads], np.int32)
        inner = np.concatenate([points, fill.points])
        yield made.mirror(local, inner, score=fill.score + AHEAD, fill=fill.fill)


def _list_cap_fills(made: _FillMaker, cap: FlatCap, search: HoleSearch) -> Iterator[HoleFill]:
    """List the quads that artists put into a flat cap; they come before the ranked ones."""
    hole = made.hole
    for rank, quads in enumerate(list_cap_quads(hole.points, cap.plane, search.mirrors)):
        counts = np.bincount(quads.ravel())
        if any(counts[at] != asked for at, asked in search.fixed.items()):
            continue
        points, flipped = made.projector.place(quads, len(counts))
        if flipped or search.take_new(quads, len(counts)) is None:
            continue
        fill = read_fill(quads, Boundary.closed(len(hole)), "constructed")
        yield made.make(quads, points, score=AHEAD - rank, fill=fill, flat=True)


def _list_ranked(search: HoleSearch, shortlist: Shortlist, made: _FillMaker) -> Iterator[HoleFill]:
    """List the candidates of a search by their scores."""
    for candidate, placed, score in rank_candidates(search.early(), search.late(), shortlist):
        yield made.make(
            candidate.quads,
            placed.points,
            score=score,
            flipped=placed.flipped,
            fill=candidate.fill,
            flat=made.projector.is_flat,
        )
