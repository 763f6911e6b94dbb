"""Fill a hole of a mesh: likely corners, candidates, placing, ranking."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.system.deadline import is_late
from query.boundary import MAX_PERIMETER, MIN_PERIMETER, Boundary
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.holes.candidates import HoleSearch
from query.holes.caps import list_cap_quads
from query.holes.corners import MOST_QUADS
from query.holes.fills import HoleFill, HoleFills
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
from query.holes.parity import list_parity_fixes
from query.holes.projection import HoleProjector
from query.holes.ranking import HoleCandidate, list_facts
from query.holes.shape import PlacedFill, count_flipped, mend_fill, place_fill
from query.holes.symmetry import find_rest, prepare_twins
from query.holes.topology import MeshTopology
from query.recognise import as_fill

#: Candidates that are placed before they are ranked by the whole: for the first fill, and then.
PLACED_FIRST, PLACED = 48, 96

#: The most new vertices that these have together, beyond the first candidate.
PLACED_VERTICES = 12_000

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
    loop: Sequence[int] | None = None,
    faces: Iterable[int] | None = None,
    **choices: Any,
) -> HoleFills:
    """List the fills of one hole of a mesh, placed, best first, as an iterator.

    db: a database. mesh: a polygon mesh, its topology, or one of its holes.
    options: how the hole is to be filled. loop: one or more vertices of a border loop; without it,
    and without faces, the mesh must have exactly one. faces: quads, triangles or n-gons to be
    replaced. choices: entries of the options, in place of options or of some of their entries.

    Every even loop of 4 to 2,000 edges has fills; with corners that the caller fixes the list is
    empty where no fill is found that has them. Raises InvalidMeshError for what is no loop, for a
    hole with an island and for a fill of another mesh, InvalidQueryError for an odd loop
    (:func:`list_parity_fixes` lists the nearest remedies), corners that are none, and for options
    that contradict each other or the rest.
    """
    asked = replace(options or HoleOptions(), **choices)
    hole = choose_hole(mesh, loop=loop, faces=faces)
    if asked.ngon:
        found: Iterator[HoleFill] = iter([_make_ngon_fill(hole)])
    else:
        _refuse_loop(hole)
        fixed = _locate_corners(hole, asked.corners)
        if any(fill.hole.topology is not hole.topology for fill in asked.like):
            raise InvalidMeshError(
                "like has a fill of another mesh; give fills of this one's holes"
            )
        found = _list_fills(db, hole, asked, fixed)
    return HoleFills(hole, found, asked.limit, asked.time_limit)


def _refuse_loop(hole: Hole) -> None:
    n = len(hole)
    if n % 2:
        fixes = [f"{fix.kind}: {fix.description}" for fix in list_parity_fixes(hole)]
        remedy = "nearest ways: " + "; ".join(fixes)
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} has {n} edges, an odd number, and quads alone "
            f"cannot fill it; {remedy if fixes else 'nor is there a way to change it by one edge'}"
            "; ngon fills it with one face"
        )
    if not MIN_PERIMETER <= n <= MAX_PERIMETER:
        raise InvalidQueryError(
            f"the loop has {n} edges; loops of {MIN_PERIMETER} to {MAX_PERIMETER} can be filled"
        )


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
    db: PatternSource, hole: Hole, options: HoleOptions, fixed: dict[int, int]
) -> Iterator[HoleFill]:
    around = extract_neighbourhood(hole)
    models = options.models or shipped_models()
    projector = HoleProjector.of(hole, around, options)
    search = HoleSearch.begin(db, hole, around, models, options, fixed)
    made = _FillMaker(hole, around, projector)
    if options.twins and not options.strokes and not fixed:
        chosen = made if options.is_laid else replace(made, projector=None)
        for fill in _list_mirrored(db, chosen, options, projector):
            if search.take_new(fill.local, len(hole) + len(fill.points)) is not None:
                yield fill
    if projector.cap is not None and projector.cap.apart and not options.strokes:
        yield from _list_cap_fills(made, search)
    yield from _list_ranked(search, Shortlist(projector, models), made)


@dataclass(frozen=True, slots=True, eq=False)
class _FillMaker:
    """Makes the fills of one hole from quads in the loop's numbering.

    projector: where mirrored fills are laid; None where they lie as the other side does.
    """

    hole: Hole
    around: Neighbourhood
    projector: HoleProjector | None

    def make(
        self, local: Int32Array, points: Points, *, score: float = np.inf, **entries: Any
    ) -> HoleFill:
        """Number a fill's vertices as those of the mesh.

        local: (q, 4) int32. points: (k, 3) the inner vertices. entries: others of the fill, a twin
        without flipped quads by default.
        """
        n, first_new = len(self.hole), len(self.hole.topology.mesh.points)
        loop = self.hole.loop
        quads = np.where(local < n, loop[np.minimum(local, n - 1)], local - n + first_new)
        counts = np.bincount(local.ravel(), minlength=n + len(points))
        valences = counts.copy()
        on_border = find_border_places(self.hole)
        valences[:n] = np.where(on_border, 0, counts[:n] - self.around.regular_valence + 4)
        return HoleFill(
            hole=self.hole,
            quads=quads.astype(np.int32),
            points=points,
            local=local,
            corners=counts[:n].astype(np.int32),
            score=score,
            valences=valences.astype(np.int32),
            **entries,
        )

    def mirror(
        self, local: Int32Array, points: Points, *, flat: bool = False, **entries: Any
    ) -> HoleFill:
        """Make a fill that lies as the other side does, or as the caller chose."""
        if self.projector is None:
            flipped = count_flipped(self.around, local, points)
        else:
            points, flipped = self.projector.place(local, len(self.hole) + len(points))
            flat = self.projector.cap is not None
        return self.make(local, points, flipped=flipped, flat=flat, **entries)


def _make_ngon_fill(hole: Hole) -> HoleFill:
    """Make a fill of one face with all vertices of a loop."""
    n = len(hole)
    if len(set(hole.loop.tolist())) < n:
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} runs through a vertex twice, and a face "
            "cannot; leave ngon out"
        )
    made = _FillMaker(hole, extract_neighbourhood(hole), None)
    fill = made.make(np.zeros((0, 4), np.int32), np.zeros((0, 3)))
    valences = np.where(find_border_places(hole), 0, fill.valences + 1).astype(np.int32)
    return replace(fill, corners=np.ones(n, np.int32), valences=valences, ngon=hole.loop)


def _list_mirrored(
    db: PatternSource, made: _FillMaker, options: HoleOptions, projector: HoleProjector
) -> Iterator[HoleFill]:
    """List mirror images: of the other side, of a fill that is given, or of a part of the hole."""
    twin = prepare_twins(made.hole.topology).find(made.hole)
    if twin is not None:
        yield made.mirror(*twin, twin=True)
    elif (same := _mirror_fill(made, options.like, projector)) is not None:
        yield same
    else:
        yield from _continue_part(db, made, options)


def _mirror_fill(
    made: _FillMaker, like: Sequence[HoleFill], projector: HoleProjector
) -> HoleFill | None:
    """Turn the fill of a hole of which this one is the mirror image, and place it."""
    for other in like:
        if other.ngon is not None:
            continue
        match = prepare_twins(made.hole.topology).match(made.hole, other.hole)
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
        points, flipped = projector.place(quads, n_vertices)
        if flipped <= other.flipped:
            return made.mirror(quads, points, flat=projector.cap is not None, twin=True)
    return None


def _continue_part(db: PatternSource, made: _FillMaker, options: HoleOptions) -> Iterator[HoleFill]:
    """Fill a hole across the plane of symmetry: what the other side shows of it is mirrored, and
    the rest, which is its own mirror image, is a hole to be filled."""
    hole = made.hole
    found = prepare_twins(hole.topology).find_part(hole)
    rest = find_rest(found[0], len(hole)) if found is not None else None
    if found is None or rest is None or len(rest) % 2 or len(rest) < MIN_PERIMETER:
        return
    if not HoleRim.of(hole).admits(found[0]):
        return
    part = made.make(*found)
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
    alone = replace(options, corners={}, strokes=(), tolerance=0, twins=False, like=())
    place = {int(v): i for i, v in enumerate(hole.loop)}
    for fill in islice(_list_fills(db, smaller, alone, {}), CONTINUED):
        quads = [[place.get(v, v - n_old + n) for v in quad] for quad in fill.quads.tolist()]
        local = np.array([*found[0].tolist(), *quads], np.int32)
        points = np.concatenate([found[1], fill.points])
        yield made.mirror(local, points, score=fill.score + AHEAD, fill=fill.fill)


def _list_cap_fills(made: _FillMaker, search: HoleSearch) -> Iterator[HoleFill]:
    """List the quads that artists put into a flat cap; they come before the ranked ones."""
    hole, projector = made.hole, made.projector
    assert projector is not None and projector.cap is not None
    cap_quads = list_cap_quads(hole.points, projector.cap.plane, search.mirrors)
    for rank, quads in enumerate(cap_quads):
        counts = np.bincount(quads.ravel())
        if any(counts[at] != asked for at, asked in search.fixed.items()):
            continue
        points, flipped = projector.place(quads, len(counts))
        if flipped or search.take_new(quads, len(counts)) is None:
            continue
        fill = as_fill(quads, Boundary.closed(len(hole)), "constructed")
        yield made.make(quads, points, score=AHEAD - rank, fill=fill, flat=True)


def _list_ranked(search: HoleSearch, board: Shortlist, made: _FillMaker) -> Iterator[HoleFill]:
    """List the candidates of a search by their scores."""
    known: list[HoleCandidate] = []
    late = search.late()
    for candidate in search.early():
        known.append(candidate)
        if is_late():
            break
    if not known:
        known += islice(late, 1)
    if not known:
        return
    board.add(known, PLACED_FIRST)
    rest = takewhile(lambda _: not is_late(), late)
    whole = board.find_sound()
    if not whole:
        # The first fill has flipped quads only where all have.
        board.add(list(rest), PLACED - PLACED_FIRST)
        board.place_until_sound()
    yield board.take_best(made, sound=True)
    if whole:
        board.add(list(rest), PLACED - PLACED_FIRST)
    while board and not is_late():
        yield board.take_best(made)


@dataclass(slots=True, eq=False)
class _Placed:
    """A candidate that is placed.

    row: of its numbers among those of all that ever were, for the score compares them.
    is_final: are quads untangled, and does it lie as the caller wants it?
    """

    row: int
    candidate: HoleCandidate
    placed: PlacedFill
    is_final: bool = False


class Shortlist:
    """Candidates, of which those that look best are placed and ranked by the whole."""

    def __init__(self, projector: HoleProjector, models: HoleModels) -> None:
        self._projector, self._around = projector, projector.around
        self._models = models
        # Those that wait, by their facts; those that are placed.
        self._waiting: list[tuple[float, int, HoleCandidate, NDArray[np.float64]]] = []
        self._placed: list[_Placed] = []
        self._numbers: list[NDArray[np.float64]] = []
        self._losses: list[float] = []
        self._scores = np.zeros(0)
        self._serial = 0

    def __bool__(self) -> bool:
        return bool(self._placed or self._waiting)

    def add(self, candidates: list[HoleCandidate], most: int) -> None:
        """Place the best by their facts, at most so many, those that wait already among them."""
        facts = list_facts(candidates, self._around)
        losses = np.array([one.loss for one in candidates])
        scores = self._models.facts.score_facts(facts) - losses
        for score, candidate, row in zip(scores.tolist(), candidates, facts, strict=True):
            self._waiting.append((-score, self._serial, candidate, row))
            self._serial += 1
        self._waiting.sort(key=lambda one: one[:2])
        self._place_next(most)

    def find_sound(self) -> bool:
        """Is a candidate placed that has no flipped quad where it comes to lie? Of those that have
        none the one that scores most is final, and all that score more are."""
        return any(not self._finish(one).flipped for one in self._by_score())

    def place_until_sound(self) -> None:
        """Place more until one has no flipped quad, or none waits."""
        while not self.find_sound() and self._waiting and not is_late():
            self._place_next(PLACED)

    def take_best(self, made: _FillMaker, *, sound: bool = False) -> HoleFill:
        """Take the best off the list; where none is placed any more, place more.

        sound: one with flipped quads only where all that are placed have some.
        """
        if not self._placed:
            self._place_next(PLACED)
        best, *others = self._by_score()
        if sound and best.placed.flipped:
            whole = (one for one in others if one.is_final and not one.placed.flipped)
            best = next(whole, best)
        self._placed.remove(best)
        placed = self._finish(best)
        return made.make(
            best.candidate.quads,
            placed.points,
            score=float(self._scores[best.row]),
            flipped=placed.flipped,
            fill=best.candidate.fill,
            flat=self._projector.cap is not None,
        )

    def _by_score(self) -> list[_Placed]:
        """Those that are placed, greatest score first."""
        return sorted(self._placed, key=lambda one: -float(self._scores[one.row]))

    def _finish(self, one: _Placed) -> PlacedFill:
        """Untangle a candidate if it has flipped quads, and project it, once."""
        if not one.is_final:
            quads = one.candidate.quads
            if not is_late():
                one.placed = mend_fill(self._around, quads, one.placed)
            one.placed = self._projector.project(quads, one.placed)
            one.is_final = True
        return one.placed

    def _place_next(self, most: int) -> None:
        """Place the first of those that wait: at most so many, or fewer large ones."""
        count = vertices = 0
        for _, _, candidate, _ in self._waiting[:most]:
            vertices += candidate.n_vertices
            if count and vertices > PLACED_VERTICES:
                break
            count += 1
        done = 0
        for _, _, candidate, facts in self._waiting[:count]:
            if done and is_late():
                break
            done += 1
            placed = place_fill(self._around, candidate.quads, candidate.n_vertices)
            self._placed.append(_Placed(len(self._numbers), candidate, placed))
            self._numbers.append(np.concatenate([facts, placed.measures]))
            self._losses.append(candidate.loss)
        del self._waiting[:done]
        self._scores = self._models.whole.score(np.array(self._numbers)) - self._losses
