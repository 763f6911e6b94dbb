"""Fills of a loop for the likely assignments of its corners, each once, in the loop's own
numbering."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from patterndb._native.query.holes.candidates import turn_quads
from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.reduction import reduce_disk
from patterndb.geometry.points import Floats
from query.boundary import MAX_PERIMETER, MIN_PERIMETER, Boundary, CornerKind
from query.engine import PatternSource, fills
from query.expand import expand_pattern
from query.fill import Fill
from query.holes.corners import LEAST_LOG, AssignmentModel, measure_assignments
from query.holes.features import measure_hole
from query.holes.loops import Hole
from query.holes.models import HoleModels
from query.holes.neighbourhood import HoleRim, Neighbourhood
from query.holes.options import HoleOptions
from query.holes.patterns import KEPT, SHARE, HolePatterns, PatternEmbedding
from query.holes.ranking import NONE_CLOSED, HoleCandidate
from query.holes.regular import (
    MOST_EDGES,
    QuadRing,
    build_regular_fill,
    lay_ring,
    list_closed_walks,
    list_rectangles,
    pave_loop,
)
from query.holes.symmetry import count_followed, find_mirrors, lose_by_mirrors
from query.listing.matches import Continuation, Listing, MatchSearch, Ranking, list_matches
from query.listing.table import get_strict_table
from query.recognition import hash_quads
from query.request import NO_DOUBLETS, PatternFilter
from query.solving.problem import build_width_problem
from query.solving.widths import WidthSolver
from query.stroke import Stroke

#: Fills without irregular vertices inside: how many are listed of the most probable closed walks,
#: of which how many are looked at, after how many steps of the search; and rectangles.
REGULAR, CLOSED_WALKS, CLOSED_STEPS, RECTANGLES = 12, 30, 3_000, 6

#: Assignments that are asked for, likeliest first, how many of them before the first fill is
#: returned, and the fills taken of each.
ASSIGNMENTS, ASKED_FIRST = 30, 5
PER_ASSIGNMENT = 8

#: Embeddings of patterns of holes that are made: before the first fill is returned,
#: of the likeliest ones that a short search keeps, and after it, of those of a longer search.
REMEMBERED, REMEMBERED_LATE, KEPT_LATE = 120, 360, 1_000

#: Of so many assignments fills are listed that no artist made, too; and of the first so many that
#: have this many corners or more, for which fills are seldom learned.
ASKED_WHOLE, ASKED_WHOLE_WIDE, WIDE = 3, 8, 8

#: Beyond so many corners whole lists are constructed, which takes up to a second each: the
#: likeliest assignment alone has one.
MOST_CONSTRUCTED = 16

#: Assignments that are paved ring by ring, and the most fills that come of it.
PAVED_ASSIGNMENTS, PAVED = 60, 8

#: Fills of a ring along the loop and a smaller fill within: assignments that get rings, fills that
#: are made at most, closed walks and embeddings that are looked at for each ring. The score of
#: what lies within counts irregular vertices of the ring, too; the last is that of a regular fill.
RINGED_ASSIGNMENTS, RINGED = 8, 40
RINGED_WALKS, RINGED_EMBEDDINGS = 4, 30
RINGED_REGULAR = -1.5

#: Fills of the relaxed lists, whose corners may lie elsewhere; these are asked for where fewer
#: candidates are known.
RELAXED = 30

#: Loop polychords are tried this wide: rings of a finger tip.
WIDEST_LOOP = 4

#: And fills with up to so many loop polychords are widened at all.
MOST_LOOPS = 2

KINDS: dict[int, CornerKind] = {1: "convex", 3: "reflex", 4: "full"}


def _empty_set() -> set[Any]:
    return set()


def _empty_dict() -> dict[Any, Any]:
    return {}


@dataclass(slots=True)
class HoleSearch:
    """The candidates of one loop, found assignment by assignment.

    source: a database. logs: (L, 4) log probabilities of 1 to 4 quads at each vertex.
    regular_valence: (L,) the quads that make the loop regular.
    model, patterns: of what artists do.
    rim: what fills may not join. mirrors: of the loop.
    strokes: strands that fills must have, within tolerance. threads: of queries.
    fixed: quads at loop vertices that the caller chose.
    ranked: (c, L) assignments, likeliest first, of scores (c,).
    known: keys of what was found.
    best_closed: log probability of the corners of the likeliest regular fill, less that of the most
        probable corners. _asked: assignments of which whole lists were asked for early.
    """

    source: PatternSource
    logs: Floats
    regular_valence: Int32Array
    model: AssignmentModel
    patterns: HolePatterns
    rim: HoleRim
    mirrors: Int32Array
    strokes: Sequence[Stroke]
    tolerance: int
    threads: int | None
    fixed: Mapping[int, int]
    ranked: Int32Array
    scores: Floats
    known: set[bytes] = field(default_factory=_empty_set)
    best_closed: float = NONE_CLOSED
    _asked: int = 0
    _facts: dict[int, tuple[int, int, int]] = field(default_factory=_empty_dict)
    _places: dict[int, int] = field(default_factory=_empty_dict)
    _embeddings: set[PatternEmbedding] = field(default_factory=_empty_set)
    _listings: dict[tuple[CornerKind, ...], Listing] = field(default_factory=_empty_dict)

    @classmethod
    def begin(
        cls,
        source: PatternSource,
        hole: Hole,
        around: Neighbourhood,
        models: HoleModels,
        options: HoleOptions,
        fixed: Mapping[int, int],
    ) -> HoleSearch:
        """Prepare the search for fills of a hole.

        fixed: quads by places in the loop; these get probability one. What the caller fixes may
        not follow the loop's mirrors, and then none count.
        """
        logs = models.corners.log_probabilities(measure_hole(hole, around))
        regular = around.regular_valence
        mirrors = find_mirrors(hole.points, regular)
        if fixed or options.strokes:
            mirrors = mirrors[:0]
        for at, quads in fixed.items():
            logs[at] = 4 * LEAST_LOG
            logs[at, quads - 1] = 0.0
        ranked, scores = models.assignments.rank(logs, regular, mirrors)
        return cls(
            source=source,
            logs=logs,
            regular_valence=regular,
            model=models.assignments,
            patterns=models.patterns,
            rim=HoleRim.of(hole),
            mirrors=mirrors,
            strokes=tuple(options.strokes),
            tolerance=options.tolerance,
            threads=options.threads,
            fixed=fixed,
            ranked=ranked,
            scores=scores,
        )

    def early(self) -> Iterator[HoleCandidate]:
        """Yield the candidates that the first fill is chosen from: regular ones, patterns of holes,
        those that are paved, and learned ones of the likeliest assignments; where there are none,
        all of the likeliest assignments."""
        found = 0
        for source in (
            self.regular(),
            self.remembered(REMEMBERED, KEPT),
            self.paved(),
            () if self.strokes else self.likely(0, ASKED_FIRST, learned=True),
        ):
            for candidate in source:
                found += 1
                yield candidate
        if not found:
            self._asked = ASKED_FIRST
            yield from self.likely(0, ASKED_FIRST)

    def late(self) -> Iterator[HoleCandidate]:
        """Yield the others: those of more assignments, more patterns of holes, rings with patterns
        within, and, where few are known, relaxed ones."""
        yield from self.likely(self._asked, ASSIGNMENTS)
        yield from self.remembered(REMEMBERED_LATE, KEPT_LATE)
        yield from self.ringed()
        if len(self.known) < RELAXED:
            yield from self.relaxed()

    def take_new(self, quads: Int32Array, n_vertices: int) -> bytes | None:
        """Remember quads in the loop's numbering: their key; None for no fill, one that cannot be
        welded in, or one that is known."""
        twin, fault = weld_quads(quads, n_vertices, len(self.logs))
        if fault or not self.rim.admits(quads):
            return None
        key = hash_quads(quads, twin, False)
        if key in self.known:
            return None
        self.known.add(key)
        return key

    def regular(self) -> Iterator[HoleCandidate]:
        """Yield candidates without an irregular vertex inside: of the most probable closed walks,
        and rectangles."""
        n = len(self.logs)
        if self.strokes or n % 2:
            return
        if n <= MOST_EDGES:
            walks = list_closed_walks(self.logs, CLOSED_WALKS, CLOSED_STEPS)
        else:
            walks = list(self.ranked)
        rectangles = list_rectangles(self.logs, RECTANGLES)
        top = float(self.logs.max(axis=1).sum())
        found: list[tuple[Int32Array, int, Pattern]] = []
        for corners in (*walks, *rectangles):
            if not self._has_fixed(corners):
                continue
            if len(found) >= REGULAR and not any(corners is one for one in rectangles):
                continue
            made = build_regular_fill(corners)
            if made is None or not self.rim.admits(made[0]):
                continue
            twin, fault = weld_quads(*made, n)
            if fault:
                continue
            found.append((*made, Pattern.from_disk(reduce_disk(twin))))
            likely = float(self.logs[np.arange(n), corners - 1].sum()) - top
            self.best_closed = max(self.best_closed, likely)
        for quads, n_vertices, pattern in found:
            fill = Fill(quads, n_vertices, (n,), pattern, (), 0, False, 0, "constructed")
            if self._fact(fill)[0] or self.patterns.row_of(pattern.id) >= 0:
                fill = replace(fill, origin="learned")
            yield from self._new(fill, 0, n, 1)

    def remembered(self, most: int, kept: int) -> Iterator[HoleCandidate]:
        """Yield candidates whose patterns are those of holes, likeliest first.

        most: embeddings that are made, of those that were not before. kept: by the search.
        """
        if self.strokes:
            return
        n = len(self.logs)
        embeddings, quads = self.patterns.enumerate_embeddings(self.logs, kept)
        for at, asked in self.fixed.items():
            quads[quads[:, at] != asked] = 0
        share = np.log(self.patterns.share[[embedding.pattern for embedding in embeddings]])
        scores = (
            self.model.score(self.logs, self.regular_valence, np.maximum(quads, 1)) + SHARE * share
        )
        for i in np.argsort(-scores, kind="stable").tolist():
            embedding = embeddings[i]
            if most <= 0:
                return
            if embedding in self._embeddings or not quads[i].all():
                continue
            most -= 1
            self._embeddings.add(embedding)
            pattern = self.patterns.pattern(embedding.pattern)
            fill = expand_pattern(pattern, embedding.widths, mirrored=embedding.mirrored)
            first = self.patterns.first_vertex(embedding)
            for variant in (fill, *_widen_loops(fill)):
                self._places[embedding.pattern] = self._places.get(embedding.pattern, 0) + 1
                yield from self._new(variant, first, n, self._places[embedding.pattern])

    def paved(self) -> Iterator[HoleCandidate]:
        """Yield candidates that are paved ring by ring, of the likeliest assignments: those with
        one irregular vertex inside, mostly."""
        n = len(self.logs)
        if self.strokes or n % 2 or n > MOST_EDGES:
            return
        count = 0
        for corners in self.ranked[:PAVED_ASSIGNMENTS]:
            made = pave_loop(corners) if self._has_fixed(corners) else None
            candidate = None if made is None else self._construct(*made)
            if candidate is not None:
                yield candidate
                count += 1
                if count == PAVED:
                    return

    def _construct(self, quads: Int32Array, n_vertices: int) -> HoleCandidate | None:
        """The candidate that quads in the loop's numbering are; None for no fill, or a known
        one."""
        n = len(self.logs)
        twin, fault = weld_quads(quads, n_vertices, n)
        if fault or hash_quads(quads, twin, False) in self.known:
            return None
        pattern = Pattern.from_disk(reduce_disk(twin))
        fill = Fill(quads, n_vertices, (n,), pattern, (), 0, False, 0, "constructed")
        if self._fact(fill)[0] or self.patterns.row_of(pattern.id) >= 0:
            fill = replace(fill, origin="learned")
        return next(self._new(fill, 0, n, 1), None)

    def ringed(self) -> Iterator[HoleCandidate]:
        """Yield candidates of a ring of quads along the loop, and a regular fill or a pattern of
        holes within it."""
        n = len(self.logs)
        if self.strokes or n % 2 or n > MOST_EDGES:
            return
        found: list[tuple[float, QuadRing, Int32Array | PatternEmbedding | None]] = []
        asked = zip(self.ranked[:RINGED_ASSIGNMENTS], self.scores.tolist(), strict=False)
        for corners, score in asked:
            ring = lay_ring(corners) if self._has_fixed(corners) else None
            if ring is None:
                continue
            if not len(ring.inner):
                found.append((score, ring, None))
                continue
            logs = ring.log_within()
            at = np.arange(len(logs))
            for walk in list_closed_walks(logs, RINGED_WALKS, CLOSED_STEPS):
                likely = float(logs[at, walk - 1].sum()) + RINGED_REGULAR
                found.append((score + likely, ring, walk))
            embeddings, within = self.patterns.enumerate_embeddings(logs, RINGED_EMBEDDINGS)
            for embedding, quads in zip(embeddings, within, strict=True):
                likely = float(logs[at, quads - 1].sum())
                likely += SHARE * float(np.log(self.patterns.share[embedding.pattern]))
                found.append((score + likely, ring, embedding))
        found.sort(key=lambda one: -one[0])
        for _, ring, within in found[:RINGED]:
            quads = ring.quads
            if isinstance(within, PatternEmbedding):
                m, first = len(ring.inner), self.patterns.first_vertex(within)
                pattern = self.patterns.pattern(within.pattern)
                quads = expand_pattern(pattern, within.widths, mirrored=within.mirrored).quads
                quads = ring.join(np.where(quads < m, (quads + first) % m, quads))
            elif within is not None:
                made = build_regular_fill(within)
                if made is None:
                    continue
                quads = ring.join(made[0])
            candidate = self._construct(quads, int(quads.max()) + 1)
            if candidate is not None:
                yield candidate

    def _has_fixed(self, corners: Int32Array) -> bool:
        """Do corners (L,) have the quads that the caller fixed?"""
        return all(corners[at] == asked for at, asked in self.fixed.items())

    def likely(self, first: int, last: int, *, learned: bool = False) -> Iterator[HoleCandidate]:
        """Candidates of some of the likeliest assignments, strictly with their corners.

        learned: of learned patterns alone. Without, fills that no artist made are listed, too, of
        the likeliest.
        """
        for number, quads in enumerate(self.ranked[first:last], first):
            n_corners = int((quads != 2).sum())
            whole = ASKED_WHOLE_WIDE if n_corners >= WIDE else ASKED_WHOLE
            limit = PER_ASSIGNMENT
            if n_corners > MOST_CONSTRUCTED:
                whole, limit = 1, 2
            yield from self.ask(quads, limit, strict=True, learned=learned or number >= whole)

    def relaxed(self, most: int = RELAXED) -> Iterator[HoleCandidate]:
        """Candidates whose corners may lie elsewhere than the most probable, and the asked,
        ones."""
        best = (self.logs[:, :3].argmax(axis=1) + 1).astype(np.int32)
        wide = int((best != 2).sum()) > MOST_CONSTRUCTED
        if wide and self.known:
            return
        yield from self.ask(best, most, strict=False)
        if wide:
            return
        clamped = np.clip(self.regular_valence, 1, 3)
        if (clamped != best).any():
            yield from self.ask(clamped, most, strict=False)

    def ask(
        self, quads_at: Int32Array, limit: int, *, strict: bool, learned: bool = False
    ) -> Iterator[HoleCandidate]:
        """Candidates with these quads (L,) at the loop's vertices; learned: of learned patterns
        alone."""
        n = len(quads_at)
        if n % 2 or not MIN_PERIMETER <= n <= MAX_PERIMETER:
            return
        corners = np.flatnonzero(quads_at != 2)
        first = int(corners[0]) if len(corners) else 0
        if len(corners):
            lengths = np.diff(np.r_[corners, first + n]).tolist()
            boundary = Boundary(lengths, [KINDS[int(quads_at[c])] for c in corners])
        else:
            boundary = Boundary.closed(n)
        moved = [_move_stroke(stroke, boundary, first, n) for stroke in self.strokes]
        if strict and learned and not self.strokes:
            found = self._learned_fills(boundary, limit)
        else:
            found = fills(
                self.source,
                boundary,
                limit=limit,
                strict=strict,
                strokes=moved,
                tolerance=self.tolerance,
                threads=self.threads,
            )
        places: dict[int, int] = {}
        for fill in found:
            for variant in (fill, *_widen_loops(fill)):
                places[fill.pattern.id] = places.get(fill.pattern.id, 0) + 1
                yield from self._turn(variant, first, n, not len(corners), places[fill.pattern.id])

    def _learned_fills(self, boundary: Boundary, limit: int) -> Iterator[Fill]:
        """The strict fills of learned patterns that artists used most.

        A whole query looks at the complete family and at constructions as well, which costs three
        times as much, and most assignments are asked only in case.
        """
        patterns = self.source.pattern_class(boundary.n_sides)
        if not len(patterns.ids):
            return
        table = get_strict_table(patterns)
        key = boundary.corners
        if key not in self._listings:
            passing = PatternFilter(valence=NO_DOUBLETS).admit_patterns(table)
            entries = table.entries(boundary, passing)
            self._listings[key] = Ranking(True, False).list_entries(table, entries)
        search = MatchSearch(
            solver=WidthSolver(build_width_problem(boundary), threads=1),
            ranking=Ranking(True, False),
            keep=2,
            n_loops=0,
        )
        count = 0
        for batch in list_matches(table, self._listings[key], search, 0):
            for _, found in sorted(batch.found, key=lambda one: one[0]):
                if isinstance(found, Continuation):
                    continue
                yield found.fill()
                count += 1
                if count == limit:
                    return

    def _turn(
        self, fill: Fill, first: int, n: int, closed: bool, place: int
    ) -> Iterator[HoleCandidate]:
        """The fill in the loop's numbering; of a closed side, every way it can lie there."""
        if not closed:
            yield from self._new(fill, first, n, place)
            return
        for turn in range(n):
            yield from self._new(fill, turn, n, place)

    def _new(self, fill: Fill, first: int, n: int, place: int) -> Iterator[HoleCandidate]:
        quads, at_loop = turn_quads(fill.quads, first, n)
        if not len(quads) or not self._has_fixed(at_loop):
            return
        key = self.take_new(quads, fill.n_vertices)
        if key is None:
            return
        traits = measure_assignments(self.logs, self.regular_valence, at_loop[None])
        frequency, meshes, symmetries = self._fact(fill)
        row = self.patterns.row_of(fill.pattern.id)
        followed = count_followed(quads, fill.n_vertices, n, key, self.mirrors)
        yield HoleCandidate(
            fill,
            quads,
            fill.n_vertices,
            float(traits[0, 0]),
            float(self.model.score_traits(traits)[0] - self.scores[0]),
            frequency,
            meshes,
            symmetries,
            int(self.patterns.meshes[row]) if row >= 0 else 0,
            float(self.patterns.share[row]) if row >= 0 else 0.0,
            bool(len(self.mirrors)) and not followed,
            lose_by_mirrors(len(self.mirrors), followed),
            place,
            key,
            self.best_closed,
        )

    def _fact(self, fill: Fill) -> tuple[int, int, int]:
        """How often and in how many meshes a pattern was seen, and its symmetries."""
        pattern = fill.pattern
        if pattern.id not in self._facts:
            patterns = self.source.pattern_class(pattern.n_sides)
            at = np.flatnonzero(patterns.ids == pattern.id)
            self._facts[pattern.id] = (0, 0, 1)
            if len(at):
                ways = pattern.rotations * (1 if pattern.chiral else 2)
                seen = int(patterns.frequency[at[0]]), int(patterns.n_meshes[at[0]])
                self._facts[pattern.id] = (seen[0], seen[1], ways)
        return self._facts[pattern.id]


def _widen_loops(fill: Fill) -> list[Fill]:
    """The same fill with wider loop polychords: rings that no boundary tells the number of."""
    loops = fill.pattern.n_loops
    if not loops or loops > MOST_LOOPS or not fill.strict:
        return []
    open_ones = fill.widths[: fill.pattern.n_chords]
    now = fill.widths[fill.pattern.n_chords :]
    found: list[Fill] = []
    for loop in range(loops):
        for width in range(now[loop] + 1, WIDEST_LOOP + 1):
            widths = (*open_ones, *now[:loop], width, *now[loop + 1 :])
            made = expand_pattern(
                fill.pattern, widths, rotation=fill.rotation, mirrored=fill.mirrored
            )
            found.append(
                replace(made, n_irregular=fill.n_irregular, flow_distance=fill.flow_distance)
            )
    return found


def _move_stroke(stroke: Stroke, boundary: Boundary, first: int, n: int) -> Stroke:
    """A stroke whose ends are edges of the loop, side 0, as edges of the boundary's sides."""
    if stroke.is_loop:
        return stroke
    starts = boundary.side_starts

    def moved(end: tuple[int, int]) -> tuple[int, int]:
        edge = (end[1] - first) % n
        side = int(np.searchsorted(starts, edge, side="right")) - 1
        return side, edge - starts[side]

    assert stroke.start is not None and stroke.end is not None
    return replace(stroke, start=moved(stroke.start), end=moved(stroke.end))
