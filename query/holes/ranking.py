"""Rank the candidates of a hole by the whole: corners, what artists did, how regular, how it lies.

The chance that a candidate is the artist's own is proportional to exp(score). The score is linear,
as in a conditional logit model, and trees add to it, which look at the numbers of a candidate and
at how far they are from the least and the greatest of the list. Trained with the corner model by
scripts/train_holes.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, takewhile

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.ranking import measure_quads
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.deadline import is_late
from query.fill import Fill
from query.holes.corners import TreeModel
from query.holes.neighbourhood import Neighbourhood, make_bare_neighbourhood
from query.holes.projection import MEASURES, HoleProjector, PlacedFill, mend_fill, place_fill

#: What is known of a candidate before it is placed.
FACTS = (
    "log_corners",
    "assignment",
    "log_frequency",
    "log_meshes",
    "log_symmetries",
    "log_place",
    "unseen",
    "inner_irregular",
    "loop_irregular",
    "valence_3",
    "valence_5",
    "valence_far",
    "log_quads",
    "asked_corners",
    "log_hole_meshes",
    "log_hole_share",
    "in_holes",
    "regular_inside",
    "rectangle",
    "strand_ratio",
    "strand_worst",
    "strand_turn",
    "loop_irregular_part",
    "touching",
    "dipoles",
    "log_edges",
    "outside_irregular",
    "forced",
    "flat",
    "steep",
    "least_side",
    "best_closed",
    "below_closed",
    "asymmetric",
)

NAMES = FACTS + MEASURES


#: What is taken for the share of patterns that no hole has shown.
LEAST_SHARE = 1e-7

#: The log probability of the corners of regular fills where none was found.
NONE_CLOSED = -30.0

#: Measures beyond this are as bad as this: single quads without area shall not outweigh all else.
CLIP = 30.0

#: Candidates that are placed before they are ranked by the whole: for the first fill, and then.
PLACED_FIRST, PLACED = 48, 96

#: The most new vertices that candidates have together which are placed at once, beyond the first.
PLACED_VERTICES = 12_000


@dataclass(frozen=True, slots=True, eq=False)
class HoleCandidate:
    """A fill of a loop.

    fill:    as the query found it; its own numbering begins at a corner.
    quads:   (q, 4) int32, loop vertices 0..L-1 in the loop's numbering, inner ones after.
    n_vertices: loop and inner vertices.
    log_corners: log probability of the quads at the loop's vertices, one by one, less that of the
             most probable numbers.
    assignment: how likely they are together, less the likeliest: see AssignmentModel.
    frequency, n_meshes, n_symmetries: of the pattern in the database; 0, 0 and 1 where no mesh has
             shown it.
    hole_meshes, hole_share: of the pattern among those of holes; see HolePatterns. 0 and 0 where no
             hole has shown it.
    asymmetric: has the loop a mirror, but none that maps the fill onto itself?
    loss:    what it loses in score because it does not follow the loop's mirrors.
    place:   among the fills of its pattern, from 1.
    key:     tells it from any other fill of the loop.
    best_closed: log_corners of the likeliest fill of the loop without irregular vertices inside;
             NONE_CLOSED where none was found.
    """

    fill: Fill
    quads: Int32Array
    n_vertices: int
    log_corners: float
    assignment: float
    frequency: int
    n_meshes: int
    n_symmetries: int
    hole_meshes: int
    hole_share: float
    asymmetric: bool
    loss: float
    place: int
    key: bytes
    best_closed: float


@dataclass(frozen=True, slots=True, eq=False)
class RankingModel:
    """mean, spread: (f,) by which numbers are standardised. weights: (f,); see NAMES and PLAIN."""

    mean: Floats
    spread: Floats
    weights: Floats

    def score(self, numbers: Floats) -> Floats:
        """(c,) scores of candidates from their numbers (c, f): the greater, the likelier."""
        return ((tame_numbers(numbers) - self.mean) / self.spread) @ self.weights

    def score_facts(self, facts: Floats) -> Floats:
        """(c,) the part of the score that is known before placing."""
        k = len(FACTS)
        return ((tame_numbers(facts) - self.mean[:k]) / self.spread[:k]) @ self.weights[:k]


@dataclass(frozen=True, slots=True, eq=False)
class WholeModel:
    """linear: the score by NAMES. trees: what is added to it, by :func:`compare_numbers`."""

    linear: RankingModel
    trees: TreeModel

    def score(self, numbers: Floats) -> Floats:
        """(c,) scores of all candidates of one list, from their numbers (c, f)."""
        numbers = tame_numbers(numbers)
        return self.linear.score(numbers) + self.trees.score(compare_numbers(numbers))[:, 0]


def compare_numbers(numbers: Floats) -> Floats:
    """(c, 3 f) numbers (c, f), how far each is above the least of its column, and above the
    greatest."""
    if not len(numbers):
        return np.hstack([numbers, numbers, numbers])
    return np.hstack([numbers, numbers - numbers.min(axis=0), numbers - numbers.max(axis=0)])


def tame_numbers(numbers: Floats) -> Floats:
    """Clip what is out of range, and what is no number."""
    return np.clip(np.nan_to_num(numbers, nan=0.0, posinf=CLIP, neginf=-CLIP), -CLIP, CLIP)


def list_facts(candidates: list[HoleCandidate], around: Neighbourhood) -> Floats:
    """Return (c, len(FACTS)) float64 of every candidate."""
    n = len(around.outside)
    rows = np.empty((len(candidates), len(FACTS)))
    points = around.points[:n]
    ahead = np.roll(points, -1, axis=0) - points
    lengths = np.maximum(np.linalg.norm(ahead, axis=1), 1e-12 * around.scale)
    ahead = ahead / lengths[:, None]
    logs = np.log(lengths)
    of_loop = _describe_loop(around, points)
    for row, candidate in zip(rows, candidates, strict=True):
        quads, n_vertices = candidate.quads, candidate.n_vertices
        found = measure_quads(
            quads, n_vertices, around.regular_valence, around.clamped_valence, ahead, logs
        )
        frequency = candidate.frequency
        row[:7] = (
            candidate.log_corners,
            candidate.assignment,
            math.log1p(frequency),
            math.log1p(candidate.n_meshes),
            math.log(max(candidate.n_symmetries, 1)),
            math.log(candidate.place),
            float(frequency == 0),
        )
        row[7:14] = found[:7]
        row[14:17] = (
            math.log1p(candidate.hole_meshes),
            math.log(max(candidate.hole_share, LEAST_SHARE)),
            float(candidate.hole_meshes > 0),
        )
        row[17:25] = found[7:15]
        row[25:30] = of_loop
        row[30:] = (
            found[15],
            candidate.best_closed,
            candidate.log_corners - candidate.best_closed,
            float(candidate.asymmetric),
        )
    return rows


def _describe_loop(around: Neighbourhood, points: Floats) -> tuple[float, ...]:
    """Measure what all candidates of a loop share: see FACTS, log_edges to steep."""
    centred = points - points.mean(axis=0)
    size = np.linalg.svd(centred, compute_uv=False)
    area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-300)
    return (
        float(np.log(len(points))),
        float((np.abs(around.far_valence) > 0.01).mean()),
        float((around.regular_valence < 1).sum()),
        float(size[-1] / max(float(size[0]), 1e-300)),
        float((around.normals @ normal).mean()),
    )


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
    """Candidates, of which those that look best are placed and ranked by the whole.

    facts, whole: the models by which they are ranked before and after they are placed.
    """

    def __init__(self, projector: HoleProjector, facts: RankingModel, whole: WholeModel) -> None:
        self._projector, self._around = projector, projector.around
        self._facts, self._whole = facts, whole
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
        scores = self._facts.score_facts(facts) - losses
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

    def take_best(self, *, sound: bool = False) -> tuple[HoleCandidate, PlacedFill, float]:
        """Take the best off the list, with its score; where none is placed any more, place more.

        sound: one with flipped quads only where all that are placed have some.
        """
        if not self._placed:
            self._place_next(PLACED)
        best, *others = self._by_score()
        if sound and best.placed.flipped:
            whole = (one for one in others if one.is_final and not one.placed.flipped)
            best = next(whole, best)
        self._placed.remove(best)
        return best.candidate, self._finish(best), float(self._scores[best.row])

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
        self._scores = self._whole.score(np.array(self._numbers)) - self._losses


def rank_candidates(
    early: Iterator[HoleCandidate], late: Iterator[HoleCandidate], shortlist: Shortlist
) -> Iterator[tuple[HoleCandidate, PlacedFill, float]]:
    """Yield candidates with their scores, best first, until it is late.

    early: those of which the first is the best. late: those that are looked at after it.
    """
    known: list[HoleCandidate] = []
    for candidate in early:
        known.append(candidate)
        if is_late():
            break
    if not known:
        known += islice(late, 1)
    if not known:
        return
    shortlist.add(known, PLACED_FIRST)
    rest = takewhile(lambda _: not is_late(), late)
    whole = shortlist.find_sound()
    if not whole:
        # The first fill has flipped quads only where all have.
        shortlist.add(list(rest), PLACED - PLACED_FIRST)
        shortlist.place_until_sound()
    yield shortlist.take_best(sound=True)
    if whole:
        shortlist.add(list(rest), PLACED - PLACED_FIRST)
    while shortlist and not is_late():
        yield shortlist.take_best()


def measure_plain_fill(fill: Fill, points: Floats) -> Floats:
    """Measure (len(PLAIN),) a fill of a boundary in space (n, 3) that no mesh surrounds."""
    n = len(points)
    valence = np.bincount(fill.quads.ravel(), minlength=fill.n_vertices)
    around = make_bare_neighbourhood(points, valence[:n].astype(np.int32))
    inner = valence[n:]
    frequency = fill.pattern.frequency
    irregular = int((inner != 4).sum())
    facts = (
        np.log1p(frequency),
        float(frequency == 0),
        float(irregular),
        float(fill.n_irregular - irregular),
        float((inner == 3).sum()),
        float((inner == 5).sum()),
        float(np.maximum(np.abs(inner - 4) - 1, 0).sum()),
        np.log(len(fill.quads)),
    )
    return np.concatenate([facts, place_fill(around, fill.quads, fill.n_vertices).measures])
