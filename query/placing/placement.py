"""Placing a fill: where in space its vertices lie, and its strands on their strokes.

Strands are pulled onto their strokes by Laplacian editing (:func:`pull_strands`), and the fill
follows softly. Source: Sorkine et al. 2004, "Laplacian Surface Editing", as Marcias et al. 2015 use
it (section 4, "Deformation"). Differs from the paper: Laplacian coordinates are kept as they are,
without local similarity transforms. A fill at rest has none along its surface, so that there is
nothing to turn, and those across it come back with the projection; it is done in rounds, each
keeping the coordinates of the one before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, vstack

from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface, Triangles
from patterndb.system.numbers import TOLERANCE
from query.errors import InvalidQueryError
from query.placing.flow import Following, follow_strokes
from query.placing.laplace import HeldQuads
from query.placing.leastsquares import LeastSquares
from query.placing.projection import (
    AT_REST,
    Projector,
    SpaceProjector,
    SurfaceProjector,
    lay_on_disk,
    lay_on_region,
    make_projector,
    settle,
    settle_whole,
)
from query.placing.region import Region, enclose_region
from query.placing.strands import SidedDisk, locate_edge
from query.placing.untangle import REACHES, UNMOVED, Mended, MendOptions, mend
from query.stroke import Stroke

#: Parts of the way to the strokes that are tried, the furthest first, until no quad flips that
#: was not flipped before, and no strand ends farther from its stroke.
PULLS = (1.0, 0.75, 0.5, 0.25, 0.125)

#: Rounds of smoothing after which a net that is tangled is not smoothed further, but untangled.
TRIAL = 5

#: A net is tangled all over if more than this part of its quads is flipped, and more than so many:
#: then it is laid anew. Untangling a few takes milliseconds.
ALL_OVER = 0.02
FEW = 20

#: Untangling goes on while it leaves this part of the flipped quads, or fewer.
HOPE = 0.8

#: Fills of so many quads, at most, are tried in all ways: each takes milliseconds.
SMALL = 500

#: Edges from flipped quads within which vertices move at first to untangle them.
NEAR = REACHES[:2]

#: Times that flipped quads on a surface are untangled: projecting may flip some again.
UNTANGLINGS = 5


class FollowedStrokeJson(TypedDict):
    """How far a stroke is from its strand; None where it has no points, or none is near enough."""

    mean_before: float | None
    most_before: float | None
    mean_after: float | None
    most_after: float | None


class PlacementJson(TypedDict):
    """A placement as JSON; see :class:`Placement` for what the entries mean."""

    flipped: list[int]
    rounds: int
    residual: float
    at_rest: bool
    off_surface: float
    region_share: float | None
    strokes: list[FollowedStrokeJson]
    pull: float


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A placed fill, and how it went.

    vertices: (v, 3) float64, in the fill's numbering. Boundary vertices are the points given,
              bit for bit.
    flipped:  (f,) int32, quads that are clockwise, cross themselves or have no area, as seen
              along the normals of the surface, or of the placed fill where there is none.
    rounds:   rounds of smoothing and projection; 0 without a surface.
    residual: the largest move of the last round as a part of the fill's diagonal; below 1e-4
              the fill is at rest. Else smoothing was broken off, as where far more than half of
              a ball is filled and a smoother net would slip off it, inside out.
    off_surface: the greatest distance of an interior vertex from the surface; 0.0 without one.
    region_share: the part of the surface's area that the boundary encloses on its left; 1.0
              if it does not separate the surface, None without one.
    strokes_before, strokes_after: (s, 2) float64 mean and greatest distance of every stroke to
              the midline of its strand, both by arc length, before and after the strands were
              pulled. NaN where the stroke has no points, or no strand is near enough.
    pull:     the part of the way that strands were pulled, 0 to 1: less than 1 where going all
              the way would have flipped quads, or left a strand farther from its stroke than it
              was.
    """

    vertices: Points
    flipped: NDArray[np.int32]
    rounds: int
    residual: float
    off_surface: float
    region_share: float | None
    strokes_before: NDArray[np.float64]
    strokes_after: NDArray[np.float64]
    pull: float

    @property
    def at_rest(self) -> bool:
        """Did smoothing and projection come to an end?"""
        return self.residual < AT_REST

    def to_json(self) -> PlacementJson:
        """How it went, as JSON takes it; the vertices are left out."""
        followed = np.hstack([self.strokes_before, self.strokes_after]).tolist()
        return {
            "flipped": self.flipped.tolist(),
            "rounds": self.rounds,
            "residual": self.residual,
            "at_rest": self.at_rest,
            "off_surface": self.off_surface,
            "region_share": self.region_share,
            "strokes": [
                {
                    "mean_before": _finite(row[0]),
                    "most_before": _finite(row[1]),
                    "mean_after": _finite(row[2]),
                    "most_after": _finite(row[3]),
                }
                for row in followed
            ],
            "pull": self.pull,
        }


def place(
    fill: SidedDisk,
    points: ArrayLike,
    surface: Triangles | Surface | Region | None = None,
    strokes: Sequence[Stroke] | None = None,
    *,
    tolerance: int = TOLERANCE,
) -> Placement:
    """Put a fill's vertices where they belong in space.

    points:  (P, 3) where the boundary vertices lie, in order; they stay there exactly.
    surface: triangles to lie on, counter-clockwise seen from outside, as a trimesh.Trimesh has
             them. The boundary should lie on it, counter-clockwise too: what it encloses to
             its left is what is filled. For many fills a :class:`Surface`, or the
             :class:`Region` that the boundary encloses, made once saves time.
    strokes: those with points pull the strands that carry them, of strands whose ends are at
             most ``tolerance`` edges off.

    Interior vertices lie at the means of their neighbours; on a surface, at rest under rounds
    of smoothing and projection (:mod:`query.placing.projection`). Where quads are flipped,
    vertices near them are moved until they are not, if that can be: inside a planar convex
    boundary it can but for edges that join vertices of one straight side.

    Raises InvalidBoundaryError for points that are not P finite ones or all in one place, and
    InvalidMeshError for a surface without triangles.
    """
    at = as_points(points, "the points of the boundary")
    if len(at) != fill.perimeter:
        raise InvalidBoundaryError(
            f"{len(at)} points for {fill.perimeter} boundary vertices; give one for each"
        )
    if not np.ptp(at, axis=0).any():
        raise InvalidBoundaryError("all points of the boundary are in one place")
    if tolerance < 0:
        raise InvalidQueryError(f"tolerance is {tolerance}; the least is 0")
    strokes = () if strokes is None else strokes
    for stroke in strokes:
        for end in (stroke.start, stroke.end):
            if end is not None:
                locate_edge(fill.lengths, end)
    if surface is not None and not isinstance(surface, Region):
        surface = enclose_region(Surface.of(surface), at)
    return _Placing(fill, at, surface).run(strokes, tolerance)


def pull_placed(
    fill: SidedDisk, vertices: Points, strokes: Sequence[Stroke], *, tolerance: int = TOLERANCE
) -> Points:
    """Pull the strands of a fill whose vertices (v, 3) lie in space already onto their strokes.

    Boundary vertices stay; where no strand carries a stroke, or pulling would flip quads, so do
    the others.
    """
    placing = _Placing(fill, vertices[: fill.perimeter], None)
    drawn = follow_strokes(fill, vertices, strokes, tolerance, placing.net.neighbours)
    return placing.pull(vertices, [one for one in drawn if one is not None])[0]


class _Placing:
    """The steps of :func:`place`, which all need the same things."""

    def __init__(self, fill: SidedDisk, points: Points, region: Region | None) -> None:
        self.fill = fill
        self.points = points
        self.net = HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter)
        self.region = region
        self.projector = make_projector(self.net, points, region)
        self.rounds, self.residual = 0, 0.0

    def run(self, strokes: Sequence[Stroke], tolerance: int) -> Placement:
        if isinstance(self.projector, SurfaceProjector):
            vertices = self._settle(self.projector)
        else:
            vertices = self._flatten()
        before = follow_strokes(self.fill, vertices, strokes, tolerance, self.net.neighbours)
        vertices, pull = self.pull(vertices, [one for one in before if one is not None])
        after = [
            None if one is None else Following.between(one.stroke, one.edges, vertices)
            for one in before
        ]
        off = 0.0
        if self.region is not None and len(vertices) > len(self.points):
            inner = vertices[len(self.points) :]
            gaps = self.region.surface.nearest(inner).points - inner
            off = float(np.linalg.norm(gaps, axis=1).max())
        normals = self.projector.find_normals(vertices)
        return Placement(
            vertices=vertices,
            flipped=np.flatnonzero(flipped(self.net.quads, vertices, normals)).astype(np.int32),
            rounds=self.rounds,
            residual=self.residual,
            off_surface=off,
            region_share=None if self.region is None else self.region.share,
            strokes_before=_distances(before),
            strokes_after=_distances(after),
            pull=pull,
        )

    def _count_flipped(self, vertices: Points) -> int:
        """How many quads are flipped."""
        normals = self.projector.find_normals(vertices)
        return int(flipped(self.net.quads, vertices, normals).sum())

    def _flatten(self) -> Points:
        """The vertices where no surface is given."""
        best = self._mend(self.net.place_harmonic(self.points), hope=1.0)
        is_planar = isinstance(self.projector, SpaceProjector) and self.projector.plane is not None
        if best.flipped and is_planar:
            tried = self.net.place_centred(self.points)
            if self._count_flipped(tried) < best.flipped:
                return tried
        return best.vertices

    def _settle(self, projector: SurfaceProjector) -> Points:
        """The vertices on a surface, without strokes."""
        assert self.region is not None
        start = lay_on_region(self.region, self.net, self.points)
        first = settle(projector, start, TRIAL)
        self.rounds, self.residual = first.rounds, first.move
        best, wrong = first.vertices, self._count_flipped(first.vertices)
        if not wrong:
            rest = settle(projector, best) if first.move >= AT_REST else first
            if not self._count_flipped(rest.vertices):
                self.rounds += 0 if rest is first else rest.rounds
                self.residual = rest.move
                return rest.vertices
            # A net over far more than half of a ball slips off and turns inside out: it goes on
            # as far as it stays whole.
        elif wrong <= max(FEW, ALL_OVER * len(self.net.quads)):
            mended = self._mend(best, NEAR)
            best, wrong = mended.vertices, mended.flipped
        if wrong:
            return self._unfold(projector, best, wrong)
        rest = settle_whole(projector, best)
        self.rounds, self.residual = self.rounds + rest.rounds, rest.move
        return rest.vertices

    def _unfold(self, projector: SurfaceProjector, vertices: Points, wrong: int) -> Points:
        """The placing with the fewest flipped quads: ``vertices``, which have ``wrong``, or fill
        and region laid on one disk, which folds nowhere; untangled.

        The latter is not smoothed: where the net of the least squared edges folds, quads get worse
        on the way there.
        """
        assert self.region is not None
        best, fewest = vertices, wrong
        spread = lay_on_disk(self.region, self.net, self.points)
        if spread is not None:
            mended = self._mend(spread)
            if mended.flipped < fewest:
                best, fewest = mended.vertices, mended.flipped
        if fewest and (spread is None or len(self.net.quads) <= SMALL):
            # Where the region is no disk there is only the net as it settles.
            rest = settle(projector, vertices)
            mended = self._mend(rest.vertices, hope=np.inf)
            if mended.flipped < fewest:
                self.rounds, self.residual = self.rounds + rest.rounds, rest.move
                return mended.vertices
        self.residual = max(self.residual, AT_REST)
        return best

    def _mend(
        self, vertices: Points, reaches: Sequence[int] = REACHES, hope: float = HOPE
    ) -> Mended:
        """The vertices with as few flipped quads as can be found."""
        normals = self.projector.find_normals(vertices)
        wrong = int(flipped(self.net.quads, vertices, normals).sum())
        still = UNMOVED * float(np.linalg.norm(np.ptp(self.points, axis=0)))
        hope = hope if len(self.net.quads) > SMALL else np.inf
        options = MendOptions(UNTANGLINGS, still, reaches, hope)
        return mend(self.net, Mended(vertices, normals, wrong), self._reproject, options)

    def _reproject(self, before: Points, moved: Points, normals: Points) -> tuple[Points, Points]:
        p = self.net.n_held
        moved[p:] = self.projector.project(moved[p:], normals[p:])
        return moved, self.projector.find_normals(moved)

    def pull(self, vertices: Points, drawn: list[Following]) -> tuple[Points, float]:
        """The vertices with strands on their strokes, and the part of the way they went."""
        allowed = self._count_flipped(vertices)
        for part in PULLS if drawn else ():
            partly = [one.partly(vertices, part) for one in drawn]
            mended = self._mend(pull_strands(self.net, vertices, partly, self.projector))
            if mended.flipped > allowed:
                continue
            # Strands that are pulled apart, held back or mended may end where none wanted them.
            if not any(is_farther(one, mended.vertices) for one in drawn):
                return mended.vertices, part
        return vertices, 0.0


def is_farther(one: Following, vertices: Points) -> bool:
    """Do these vertices put a strand farther from its stroke than it was, in the mean or where it
    is farthest?"""
    now = Following.between(one.stroke, one.edges, vertices)
    return now.mean > one.mean or now.most > one.most


def _finite(number: float) -> float | None:
    return number if np.isfinite(number) else None


def _distances(followed: Sequence[Following | None]) -> NDArray[np.float64]:
    rows = [(np.nan, np.nan) if one is None else (one.mean, one.most) for one in followed]
    return np.array(rows, np.float64).reshape(-1, 2)


#: What a midpoint's distance from its target weighs against a vertex's distance from the mean
#: of its neighbours: so much that strands lie on their strokes, and bend softly beside them.
PULL = 3.0

#: Rounds of pulling and projecting, at most.
PULL_ROUNDS = 12

#: A round that moves nothing further than this part of the diagonal is the last.
PULL_AT_REST = 1e-4


def pull_strands(
    net: HeldQuads, vertices: Points, followed: Sequence[Following], projector: Projector
) -> Points:
    """(v, 3) the vertices with every strand's midpoints near their targets.

    followed: strands and targets; boundary vertices, and so the ends of open strands, stay.
    """
    p, v = net.n_held, len(vertices)
    edges = np.concatenate([one.edges for one in followed])
    targets = np.concatenate([one.targets for one in followed])
    held = (edges >= p).any(axis=1)
    edges, targets = edges[held], targets[held]
    if v == p or len(edges) == 0:
        return vertices
    count = np.arange(len(edges))
    middle = csc_array(
        (np.full(2 * len(edges), 0.5), (np.r_[count, count], edges.T.ravel())),
        shape=(len(edges), v),
    )
    rows = [net.build_laplacian()[p:, p:], PULL * middle[:, p:]]
    system = LeastSquares(vstack(rows, format="csc"))
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    at = vertices
    for _ in range(PULL_ROUNDS):
        wanted = PULL * (targets - at[edges].mean(axis=1))
        moved = at.copy()
        moved[p:] += system.solve(np.concatenate([np.zeros((v - p, 3)), wanted]))
        moved = projector.project(moved, projector.find_normals(at))
        moved[:p] = vertices[:p]
        largest = float(np.linalg.norm(moved - at, axis=1).max())
        at = moved
        if largest < PULL_AT_REST * diagonal:
            break
    return at
