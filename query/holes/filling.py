"""Fill the holes of a mesh: likely corners, candidates, placing, ranking, welding."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, takewhile
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError, TimeLimitError
from patterndb.system.deadline import end_by, get_deadline, is_late, run_until_late
from query.boundary import MAX_PERIMETER, MIN_PERIMETER, Boundary
from query.caprequest import LEAST_TENSION, CapRequest, Shape
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.fill import Fill
from query.holes.assignments import MOST_QUADS
from query.holes.candidates import HoleSearch
from query.holes.caps import RimPlane, find_cap, list_cap_quads
from query.holes.context import measure_hole
from query.holes.laying import HoleGround
from query.holes.loops import (
    Hole,
    MeshTopology,
    explain_closed,
    find_holes,
    find_islands,
    hole_of_faces,
    hole_of_loop,
    hole_on_loop,
)
from query.holes.models import HoleModels, shipped_models
from query.holes.odd import list_even_ways
from query.holes.ranking import HoleCandidate, RankingModel, WholeModel, list_facts
from query.holes.rim import HoleRim
from query.holes.shape import PlacedFill, count_flipped, mend_fill, place_fill
from query.holes.surroundings import (
    Surroundings,
    find_border_places,
    list_faces_near,
    look_around,
)
from query.holes.symmetry import find_mirrors
from query.holes.twin import find_rest, prepare_twins
from query.recognise import as_fill
from query.stroke import Stroke

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface

#: Candidates that are placed before they are ranked by the whole: for the first fill, and then.
PLACED_FIRST, PLACED = 48, 96

#: But no more than have so many new vertices together, beyond the first.
PLACED_VERTICES = 12_000

#: Fills of a hole of which the other side shows a part; and what their score, which is that of the
#: rest, is raised by: they come before all that do not follow the other side.
CONTINUED, AHEAD = 12, 100.0

#: Seconds after a time limit in which a fill that was found by then may be placed.
PLACING_SECONDS = 0.25

#: Rings of faces around a hole that are looked at, and one more.
SEEN = 4


@dataclass(frozen=True, slots=True, eq=False)
class HoleFill:
    """A fill of a hole, in numbers of the mesh.

    hole:     what it fills.
    quads:    (q, 4) int32, vertices of the mesh; new ones from the mesh's number of vertices on.
    points:   (k, 3) float64, where the new vertices lie.
    local:    (q, 4) int32, the same quads with the loop's vertices as 0..L-1.
    corners:  (L,) int32 quads at each loop vertex.
    score:    the greater, the likelier that an artist made it; inf for a twin.
    twin:     is it the mirror image of the other side of the mesh, or of the fill of a hole there?
    flipped:  quads that are turned over where they lie.
    valences: (L + k,) int32 faces around the loop's vertices and the new ones; 0 on the border that
              stays, where no number of them is regular.
    fill:     what the database gave; None for a twin and an n-gon. Where the other side of the mesh
              shows a part of the hole, that of the rest.
    ngon:     (L,) int32 the corners of the one face that fills the hole instead of quads; None
              where quads do.
    flat:     was it laid in the plane of the hole's boundary?
    """

    hole: Hole
    quads: Int32Array
    points: NDArray[np.float64]
    local: Int32Array
    corners: Int32Array
    score: float
    twin: bool
    flipped: int
    valences: Int32Array
    fill: Fill | None
    ngon: Int32Array | None = None
    flat: bool = False

    @property
    def n_quads(self) -> int:
        """How many quads fill the hole."""
        return len(self.quads)

    @property
    def n_faces(self) -> int:
        """How many faces fill the hole: quads, or one n-gon."""
        return len(self.quads) if self.ngon is None else 1

    @property
    def n_irregular(self) -> int:
        """Vertices of the fill and its loop around which there are not 4 faces."""
        return int(((self.valences != 4) & (self.valences != 0)).sum())

    @property
    def pattern(self) -> str:
        """The name of the pattern, "twin" or "n-gon"."""
        return self._kind if self.fill is None else self.fill.pattern.name

    @property
    def origin(self) -> str:
        """Where the pattern comes from; "twin" for a mirror image, "n-gon" for an n-gon."""
        return self._kind if self.fill is None else self.fill.origin

    @property
    def _kind(self) -> str:
        return "twin" if self.ngon is None else "n-gon"

    def weld(self) -> PolygonMesh:
        """The whole mesh: see :func:`weld_fills`."""
        return weld_fills([self])

    def to_json(self) -> dict[str, Any]:
        """The fill as JSON takes it."""
        return {
            "pattern": self.pattern,
            "origin": self.origin,
            "score": round(self.score, 6) if np.isfinite(self.score) else None,
            "quads": self.quads.tolist(),
            "ngon": None if self.ngon is None else self.ngon.tolist(),
            "points": self.points.tolist(),
            "n_irregular": self.n_irregular,
            "flipped": self.flipped,
            "flat": self.flat,
        }


class HoleFills(Iterator[HoleFill]):
    """An iterator over the fills of a hole, best first.

    hole: what they fill. twin: was a mirror twin found? seconds: spent so far. stopped: "time
    limit" where that ended the list, else None. complete: was everything searched that was asked
    for?
    """

    def __init__(
        self, hole: Hole, found: Iterator[HoleFill], limit: int | None, time_limit: float | None
    ) -> None:
        self.hole = hole
        self.twin = False
        self.seconds = 0.0
        self.stopped: str | None = None
        self._found = found
        self._limit, self._time_limit = limit, time_limit
        self._count = 0
        self._deadline: float | None = None

    def __iter__(self) -> HoleFills:
        return self

    @property
    def complete(self) -> bool:
        return self.stopped is None

    def __next__(self) -> HoleFill:
        begin = perf_counter()
        if self._deadline is None:
            mine = math.inf if self._time_limit is None else begin + self._time_limit
            self._deadline = min(mine, get_deadline())
        if self.stopped is not None or self._count == self._limit:
            raise StopIteration
        try:
            fill = self._find_next(self._deadline)
        finally:
            self.seconds += perf_counter() - begin
        if fill is None:
            if perf_counter() >= self._deadline:
                self.stopped = "time limit"
            raise StopIteration
        self._count += 1
        self.twin = self.twin or fill.twin
        return fill

    def _find_next(self, deadline: float) -> HoleFill | None:
        # The search ends at the deadline, with what it has: to place that takes a moment more. A
        # single step that takes longer, on a very large hole, is left to itself.
        def search() -> HoleFill | None:
            with end_by(deadline):
                return next(self._found, None)

        try:
            with end_by(deadline + PLACING_SECONDS):
                return run_until_late(search, "a fill was placed")
        except TimeLimitError:
            self.stopped = "time limit"
            return None

    def to_json(self, fills: Sequence[HoleFill]) -> dict[str, Any]:
        """The hole and those of its fills that were listed, as JSON takes them."""
        return {
            "loop": self.hole.loop.tolist(),
            "corners": fills[0].corners.tolist() if fills else [],
            "twin": self.twin,
            "stopped": self.stopped,
            "complete": self.complete,
            "seconds": round(self.seconds, 4),
            "fills": [fill.to_json() for fill in fills],
        }


def fill_holes(
    db: PatternSource,
    mesh: PolygonMesh | MeshTopology | Hole,
    *,
    loop: Sequence[int] | None = None,
    faces: Iterable[int] | None = None,
    limit: int | None = 20,
    corners: Mapping[int, int] | None = None,
    strokes: Sequence[Stroke] = (),
    tolerance: int = 1,
    surface: Surface | None = None,
    twins: bool = True,
    like: Sequence[HoleFill] = (),
    shape: Shape = "auto",
    tension: float = LEAST_TENSION,
    ngon: bool = False,
    time_limit: float | None = None,
    threads: int | None = None,
    models: HoleModels | None = None,
) -> HoleFills:
    """The fills of one hole of a mesh, placed, best first, as an iterator.

    db: a database. mesh: a polygon mesh (or what is known of one: its topology, or a hole).
    loop: one or more vertices of a border loop; without it, and without faces, the mesh must have
    exactly one. faces: quads, triangles or n-gons to be made anew instead. limit: the most fills.
    corners: loop vertices (of the mesh) whose quads within the caller fixes, 1 to 4.
    strokes: strands that every fill shall have; their ends are edges of side 0 of the loop, from
    the hole's first vertex. Strands are pulled onto those that have points.
    tolerance: edges that a strand's end may be off.
    surface: what is to be laid on: new vertices come to rest on the part that the rim encloses, or,
    where the rim does not lie on it, are put on its nearest points.
    twins: is a mirror image of the other side proposed first?
    like: fills of other holes of the mesh. Where this hole is the mirror image of one of theirs,
    the same fill comes first, mirrored; where the mesh is nearly symmetric, it is placed anew.
    time_limit: seconds after which the list ends; the earlier deadline of the thread that begins it
    (:mod:`patterndb.system.deadline`) ends it, too. A list that is still empty then has the best
    fill that was found until then, if there is one.
    shape, tension, ngon: how the fill is to lie; see :class:`query.caprequest.CapRequest`. A mirror
    image lies as the other side does unless a shape or a tension is chosen.
    models: of what artists do; by default those that come with the package.

    Every even loop of 4 to 2,000 edges has fills; with corners that the caller fixes the list is
    empty where no fill is found that has them. Raises InvalidMeshError for what is no loop, for a
    hole with an island and for a fill of another mesh, InvalidQueryError for an odd loop
    (:func:`list_even_ways` has the nearest ways out), corners that are none, and for shape, tension
    and ngon that contradict each other or the rest.
    """
    cap = CapRequest(shape=shape, tension=tension, ngon=ngon)
    hole = choose_hole(mesh, loop=loop, faces=faces)
    if surface is not None and (shape == "flat" or tension):
        raise InvalidQueryError(
            "new vertices lie on the surface that is given; leave shape flat and tension out"
        )
    if ngon:
        if corners or strokes or surface is not None:
            raise InvalidQueryError("an n-gon has no quads; leave corners, strokes and surface out")
        return HoleFills(hole, iter([_ngon_fill(hole)]), limit, time_limit)
    _refuse_loop(hole)
    fixed = _fixed_corners(hole, corners or {})
    if any(fill.hole.topology is not hole.topology for fill in like):
        raise InvalidMeshError("like has a fill of another mesh; give fills of this one's holes")
    used = models or shipped_models()
    listed = _list_fills(
        db, hole, fixed, tuple(strokes), tolerance, surface, twins, like, cap, threads, used
    )
    return HoleFills(hole, listed, limit, time_limit)


def weld_fills(fills: Sequence[HoleFill]) -> PolygonMesh:
    """Weld fills of different holes of one mesh into it.

    All old vertices keep their numbers and places to the bit; faces that stay keep their order,
    less those that the fills replace; new vertices and faces come after, fill by fill. Raises
    InvalidMeshError for fills of different meshes.
    """
    if not fills:
        raise InvalidMeshError("give one fill or more")
    mesh = fills[0].hole.topology.mesh
    if any(fill.hole.topology.mesh is not mesh for fill in fills):
        raise InvalidMeshError("the fills are of different meshes; weld those of one mesh")
    stays = np.ones(mesh.n_faces, np.bool_)
    for fill in fills:
        stays[fill.hole.removed] = False
    arity = mesh.arities()
    kept = mesh.corners[np.repeat(stays, arity)]
    points = [mesh.points]
    new: list[Int32Array] = []
    sizes: list[int] = []
    n = len(mesh.points)
    for fill in fills:
        first = len(mesh.points)
        faces = fill.quads if fill.ngon is None else fill.ngon[None]
        moved = np.where(faces >= first, faces - first + n, faces)
        new.append((moved[:, ::-1] if fill.hole.runs_backwards() else moved).ravel())
        sizes += [faces.shape[1]] * len(faces)
        points.append(fill.points)
        n += len(fill.points)
    lengths = np.concatenate([arity[stays], np.array(sizes, np.int64)])
    return PolygonMesh(
        np.concatenate(points),
        np.concatenate([kept, *new]).astype(np.int32),
        np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
    )


def choose_hole(
    mesh: PolygonMesh | MeshTopology | Hole,
    *,
    loop: Sequence[int] | None = None,
    faces: Iterable[int] | None = None,
) -> Hole:
    """Find the hole that is meant: see :func:`fill_holes`.

    Raises InvalidMeshError where that cannot be told, and for a hole with an island.
    """
    if isinstance(mesh, Hole):
        if loop is not None or faces is not None:
            raise InvalidMeshError("a hole is given; loop and faces would name another")
        if not len(mesh.removed):
            _refuse_islands(mesh, find_holes(mesh.topology))
        return mesh
    topology = mesh if isinstance(mesh, MeshTopology) else MeshTopology.of(mesh)
    if loop is not None and faces is not None:
        raise InvalidMeshError("name a loop or faces, not both")
    if faces is not None:
        return hole_of_faces(topology, faces)
    holes = find_holes(topology)
    if loop is not None:
        hole = hole_of_loop(topology, loop)
    elif len(holes) == 1:
        (hole,) = holes
    elif not holes:
        raise InvalidMeshError(explain_closed(topology))
    else:
        sizes = ", ".join(f"{len(h)} edges at vertex {int(h.loop[0])}" for h in holes[:6])
        raise InvalidMeshError(
            f"the mesh has {len(holes)} border loops ({sizes}{', ...' if len(holes) > 6 else ''}); "
            "name a vertex of the one to be filled"
        )
    _refuse_islands(hole, holes)
    return hole


def _refuse_islands(hole: Hole, others: Sequence[Hole]) -> None:
    islands = find_islands(hole, others)
    if islands:
        at = int(islands[0].loop[0])
        raise InvalidMeshError(
            f"the hole at vertex {int(hole.loop[0])} has an island within: another part of "
            f"the mesh, with vertex {at}; join it to the rim by a face, or take it out"
        )


def _refuse_loop(hole: Hole) -> None:
    n = len(hole)
    if n % 2:
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} has {n} edges, an odd number, and quads alone "
            f"cannot fill it; {_tell_ways(hole)}; ngon fills it with one face"
        )
    if not MIN_PERIMETER <= n <= MAX_PERIMETER:
        raise InvalidQueryError(
            f"the loop has {n} edges; loops of {MIN_PERIMETER} to {MAX_PERIMETER} can be filled"
        )


def _tell_ways(hole: Hole) -> str:
    """The nearest way of each kind, in words."""
    ways = list_even_ways(hole)
    if not ways:
        return "nor is there a way to change it by one edge"
    return "nearest ways: " + "; ".join(f"{way.kind}: {way.told}" for way in ways)


def _fixed_corners(hole: Hole, corners: Mapping[int, int]) -> dict[int, int]:
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
    db: PatternSource,
    hole: Hole,
    fixed: dict[int, int],
    strokes: tuple[Stroke, ...],
    tolerance: int,
    surface: Surface | None,
    twins: bool,
    like: Sequence[HoleFill],
    cap: CapRequest,
    threads: int | None,
    models: HoleModels,
) -> Iterator[HoleFill]:
    around = look_around(hole)
    n = len(hole)
    flat = None if surface is not None else find_cap(hole, cap.shape)
    plane = None if flat is None else flat.plane
    ground = HoleGround.make(around, surface, plane, cap.tension, strokes, tolerance)
    # A mirror image is laid only as the caller chose.
    chosen = ground if cap.shape != "auto" or cap.tension else None
    logs = models.corners.log_probabilities(measure_hole(hole, around))
    search = HoleSearch.begin(
        db,
        logs,
        around.due,
        models.assignments,
        models.patterns,
        HoleRim.of(hole),
        find_mirrors(around.points[:n], around.due),
        fixed=fixed,
        strokes=strokes,
        tolerance=tolerance,
        threads=threads,
    )
    if twins and not strokes and not fixed:
        found = prepare_twins(hole.topology).find(hole)
        if found is not None:
            quads, points = found
            if search.take_new(quads, n + len(points), n) is not None:
                yield _mirrored_fill(hole, around, quads, points, chosen)
        elif (same := _mirror_fill(hole, around, like, ground)) is not None:
            quads, points, is_flat = same
            if search.take_new(quads, n + len(points), n) is not None:
                yield _mirrored_fill(hole, around, quads, points, chosen, is_flat=is_flat)
        else:
            for fill in _continue_part(db, hole, around, surface, cap, chosen, threads, models):
                if search.take_new(fill.local, n + len(fill.points), n) is not None:
                    yield fill
    if flat is not None and flat.apart and not strokes:
        yield from _cap_fills(hole, ground, flat.plane, fixed, search)
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
    board = _CandidateBoard(ground, models.facts, models.whole)
    board.add(known, PLACED_FIRST)
    rest = takewhile(lambda _: not is_late(), late)
    whole = board.find_sound()
    if not whole:
        # The first fill has flipped quads only where all have.
        board.add(list(rest), PLACED - PLACED_FIRST)
        board.place_until_sound()
    yield _hole_fill(hole, *board.take_best(sound=True), ground)
    if whole:
        board.add(list(rest), PLACED - PLACED_FIRST)
    while board and not is_late():
        yield _hole_fill(hole, *board.take_best(), ground)


def _cap_fills(
    hole: Hole,
    ground: HoleGround,
    plane: RimPlane,
    fixed: dict[int, int],
    search: HoleSearch,
) -> Iterator[HoleFill]:
    """The quads that artists put into a flat cap; they come before the ranked ones."""
    n = len(hole)
    for rank, quads in enumerate(list_cap_quads(hole.points, plane, search.mirrors)):
        counts = np.bincount(quads.ravel())
        points = ground.lay(quads, np.zeros((len(counts) - n, 3)))
        if any(counts[at] != asked for at, asked in fixed.items()):
            continue
        if ground.count_flipped(quads, points) or search.take_new(quads, len(counts), n) is None:
            continue
        fill = as_fill(quads, Boundary.closed(n), "constructed")
        capped = _renumber(hole, ground.around, quads, points, AHEAD - rank, False, 0, fill)
        yield replace(capped, flat=True)


def _ngon_fill(hole: Hole) -> HoleFill:
    """One face of all vertices of a loop."""
    n = len(hole)
    if len(set(hole.loop.tolist())) < n:
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} runs through a vertex twice, and a face "
            "cannot; leave ngon out"
        )
    none = np.zeros((0, 4), np.int32)
    fill = _renumber(hole, look_around(hole), none, np.zeros((0, 3)), float("inf"), False, 0, None)
    valences = np.where(find_border_places(hole), 0, fill.valences + 1).astype(np.int32)
    return replace(fill, corners=np.ones(n, np.int32), valences=valences, ngon=hole.loop)


def _mirror_fill(
    hole: Hole, around: Surroundings, like: Sequence[HoleFill], ground: HoleGround
) -> tuple[Int32Array, NDArray[np.float64], bool] | None:
    """The fill of a hole of which this one is the mirror image, turned to fit, and placed; and
    whether it is flat."""
    for other in like:
        if other.ngon is not None:
            continue
        match = prepare_twins(hole.topology).match(hole, other.hole)
        # What is around them must ask for the same, or the same fill is another there.
        if match is None or (look_around(other.hole).due[match.places] != around.due).any():
            continue
        n_vertices = len(hole) + len(other.points)
        quads = match.mirror_quads(other.local, n_vertices)
        if match.exact:
            return quads, match.mirror_points(other.points), other.flat
        placed = mend_fill(around, quads, place_fill(around, quads, n_vertices))
        points = ground.lay(quads, placed.points)
        if ground.count_flipped(quads, points) <= other.flipped:
            return quads, points, ground.plane is not None
    return None


@dataclass(slots=True, eq=False)
class _Placed:
    """A candidate that is placed. row: its numbers' among those of all that ever were, for the
    score compares them. laid: are quads untangled, and does it lie as the caller wants it?"""

    row: int
    candidate: HoleCandidate
    lies: PlacedFill
    laid: bool = False


class _CandidateBoard:
    """Candidates, of which those that look best are placed and ranked by the whole."""

    def __init__(self, ground: HoleGround, first: RankingModel, whole: WholeModel) -> None:
        self._ground, self._around = ground, ground.around
        self._first, self._whole = first, whole
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
        scores = self._first.score_facts(facts) - np.array([one.loss for one in candidates])
        for score, candidate, row in zip(scores.tolist(), candidates, facts, strict=True):
            self._waiting.append((-score, self._serial, candidate, row))
            self._serial += 1
        self._waiting.sort(key=lambda one: one[:2])
        self._place_next(most)

    def find_sound(self) -> bool:
        """Is a candidate placed that has no flipped quad where it is laid? Of those that have none
        the one that scores most is laid, and all that score more are."""
        return any(not self._lay(one).flipped for one in self._by_score())

    def place_until_sound(self) -> None:
        """Place more until one has no flipped quad, or none waits."""
        while not self.find_sound() and self._waiting and not is_late():
            self._place_next(PLACED)

    def take_best(self, *, sound: bool = False) -> tuple[HoleCandidate, PlacedFill, float]:
        """Take the best off the board; where none is placed any more, more are.

        sound: one with flipped quads only where all that are placed have some.
        """
        if not self._placed:
            self._place_next(PLACED)
        best, *others = self._by_score()
        if sound and best.lies.flipped:
            whole = (one for one in others if one.laid and not one.lies.flipped)
            best = next(whole, best)
        self._placed.remove(best)
        return best.candidate, self._lay(best), float(self._scores[best.row])

    def _by_score(self) -> list[_Placed]:
        """Those that are placed, greatest score first."""
        return sorted(self._placed, key=lambda one: -float(self._scores[one.row]))

    def _lay(self, one: _Placed) -> PlacedFill:
        """Untangle a candidate if it has flipped quads, and lay it on its ground, once."""
        if not one.laid:
            quads, ground = one.candidate.quads, self._ground
            if not is_late():
                one.lies = mend_fill(self._around, quads, one.lies)
            if ground.moves:
                points = ground.lay(quads, one.lies.points)
                flipped = ground.count_flipped(quads, points)
                one.lies = PlacedFill(points, one.lies.measures, flipped)
            one.laid = True
        return one.lies

    def _place_next(self, most: int) -> None:
        """Place the first of those that wait: at most so many, or fewer large ones."""
        count = vertices = 0
        for _, _, candidate, _ in self._waiting[:most]:
            vertices += candidate.n_vertices
            if count and vertices > PLACED_VERTICES:
                break
            count += 1
        placed = 0
        for _, _, candidate, facts in self._waiting[:count]:
            if placed and is_late():
                break
            placed += 1
            lies = place_fill(self._around, candidate.quads, candidate.n_vertices)
            self._placed.append(_Placed(len(self._numbers), candidate, lies))
            self._numbers.append(np.concatenate([facts, lies.measures]))
            self._losses.append(candidate.loss)
        del self._waiting[:placed]
        self._scores = self._whole.score(np.array(self._numbers)) - self._losses


def _continue_part(
    db: PatternSource,
    hole: Hole,
    around: Surroundings,
    surface: Surface | None,
    cap: CapRequest,
    chosen: HoleGround | None,
    threads: int | None,
    models: HoleModels,
) -> Iterator[HoleFill]:
    """Fills of a hole across the plane of symmetry: what the other side shows of it is mirrored,
    and the rest, which is its own mirror image, is a hole to be filled."""
    found = prepare_twins(hole.topology).find_part(hole)
    rest = find_rest(found[0], len(hole)) if found is not None else None
    if found is None or rest is None or len(rest) % 2 or len(rest) < MIN_PERIMETER:
        return
    if not HoleRim.of(hole).admits(found[0]):
        return
    part = _renumber(hole, around, *found, 0.0, False, 0, None)
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
    listed = _list_fills(db, smaller, {}, (), 0, surface, False, (), cap, threads, models)
    place = {int(v): i for i, v in enumerate(hole.loop)}
    for fill in islice(listed, CONTINUED):
        quads = [[place.get(v, v - n_old + n) for v in quad] for quad in fill.quads.tolist()]
        local = np.array([*found[0].tolist(), *quads], np.int32)
        points = np.concatenate([found[1], fill.points])
        score = fill.score + AHEAD
        yield _mirrored_fill(hole, around, local, points, chosen, score=score, fill=fill.fill)


def _hole_fill(
    hole: Hole, candidate: HoleCandidate, placed: PlacedFill, score: float, ground: HoleGround
) -> HoleFill:
    quads, turned = candidate.quads, placed.flipped
    fill = _renumber(
        hole, ground.around, quads, placed.points, score, False, turned, candidate.fill
    )
    return replace(fill, flat=ground.plane is not None)


def _mirrored_fill(
    hole: Hole,
    around: Surroundings,
    quads: Int32Array,
    points: NDArray[np.float64],
    chosen: HoleGround | None,
    *,
    is_flat: bool = False,
    score: float = float("inf"),
    fill: Fill | None = None,
) -> HoleFill:
    """A fill that lies as the other side does, or, where the caller chose how, on that ground."""
    if chosen is None:
        flipped = count_flipped(around, quads, points)
    else:
        smooth = place_fill(around, quads, len(hole) + len(points)).points
        points, is_flat = chosen.lay(quads, smooth), chosen.plane is not None
        flipped = chosen.count_flipped(quads, points)
    made = _renumber(hole, around, quads, points, score, fill is None, flipped, fill)
    return replace(made, flat=is_flat)


def _renumber(
    hole: Hole,
    around: Surroundings,
    local: Int32Array,
    points: NDArray[np.float64],
    score: float,
    twin: bool,
    flipped: int,
    fill: Fill | None,
) -> HoleFill:
    n = len(hole)
    first_new = len(hole.topology.mesh.points)
    quads = np.where(local < n, hole.loop[np.minimum(local, n - 1)], local - n + first_new)
    counts = np.bincount(local.ravel(), minlength=n + len(points))
    valences = counts.copy()
    valences[:n] = np.where(find_border_places(hole), 0, counts[:n] - around.due + 4)
    return HoleFill(
        hole,
        quads.astype(np.int32),
        points,
        local,
        counts[:n].astype(np.int32),
        score,
        twin,
        flipped,
        valences.astype(np.int32),
        fill,
    )
