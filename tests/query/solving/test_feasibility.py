"""Which patterns of a class fit: against every pattern in every orientation by itself."""

from __future__ import annotations

import random

import numpy as np
import pytest

from patterndb.core.pattern import Pattern
from query import Boundary
from query.listing.table import get_strict_table
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.problem import build_width_problem
from query.solving.widths import WidthSolver
from tests.support.query.cases import (
    KIND,
    Chords,
    all_orientations,
    brute_force,
    find_rows,
    grid_widths,
    laid_corners,
    laid_lengths,
    small_class,
    small_fills,
    small_patterns,
)


def fits_somehow(pattern: Pattern, boundary: Boundary) -> bool:
    """By the definition: lay the pattern down in all 2N ways, and try widths."""
    chords = Chords.from_label(pattern.label)
    n = pattern.n_sides
    for rotation, mirror in all_orientations(n):
        if laid_corners(pattern, rotation, mirror) != list(boundary.corner_counts):
            continue
        wanted = [0] * max(n, 1)
        for i, length in enumerate(boundary.lengths):
            wanted[(rotation - i if mirror else rotation + i) % max(n, 1)] = length
        if brute_force(chords, wanted):
            return True
    return False


def boundaries(n_sides: int, chance: random.Random, count: int, longest: int) -> list[Boundary]:
    """Random ones, more than half of them made for some pattern, and some of these spoilt."""
    found: list[Boundary] = []
    patterns = [p for p in small_patterns() if p.n_sides == n_sides]
    while len(found) < count:
        lengths = [chance.randint(1, longest) for _ in range(max(n_sides, 1))]
        corners = None if n_sides else ()
        if chance.random() < 0.6:
            of = chance.choice(patterns)
            turn, mirror = chance.choice(all_orientations(n_sides))
            widths = grid_widths(chance, of, 2).tolist()
            lengths = laid_lengths(of, widths, turn, mirror)
            corners = [KIND[k] for k in laid_corners(of, turn, mirror)]
            if n_sides > 1 and chance.random() < 0.5:
                for _ in range(2):
                    lengths[chance.randrange(n_sides)] += 1
        if sum(lengths) % 2 == 0 and sum(lengths) >= 4:
            found.append(Boundary(lengths, corners))
    return found


@pytest.mark.parametrize("n_sides", range(0, 11))
def test_the_class_answers_as_its_patterns_would(n_sides: int) -> None:
    patterns = small_class(n_sides)
    chance = random.Random(n_sides)
    some = 0
    for boundary in boundaries(n_sides, chance, 12, 5):
        rows = PatternFilter().choose_rows(patterns, boundary)
        fit = set(find_rows(get_strict_table(patterns), boundary, rows, 1).tolist())
        tried = rows.tolist() if len(rows) < 60 else chance.sample(rows.tolist(), 60)
        for row in tried:
            assert (row in fit) == fits_somehow(patterns.pattern(row), boundary)
        some += len(fit)
    assert some


@pytest.mark.parametrize("n_sides", [2, 3, 4, 5])
def test_cpsat_answers_the_same(n_sides: int) -> None:
    patterns = small_class(n_sides)
    for boundary in boundaries(n_sides, random.Random(n_sides), 5, 7):
        table = get_strict_table(patterns)
        entries = table.entries(boundary, np.ones(len(patterns), np.bool_))
        problem = build_width_problem(boundary)
        kernel, other = (
            WidthSolver(problem, by_cpsat=by_cpsat).find_feasible(
                table, entries.row, entries.packed
            )
            for by_cpsat in (False, True)
        )
        assert other.tolist() == kernel.tolist()


@pytest.mark.parametrize("threads", [2, 3, 8])
def test_the_answer_does_not_depend_on_threads(
    threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(feasibility, "ROWS_PER_THREAD", 7)
    for n_sides in (5, 8):
        patterns = small_class(n_sides)
        table = get_strict_table(patterns)
        for boundary in boundaries(n_sides, random.Random(0), 6, 6):
            rows = PatternFilter().choose_rows(patterns, boundary)
            one = find_rows(table, boundary, rows, 1)
            more = find_rows(table, boundary, rows, threads)
            assert one.tolist() == more.tolist()


def test_every_small_disk_makes_its_own_pattern_fit() -> None:
    """Codes aside: whatever fills a boundary, its pattern is among those that fit."""
    for boundary in random.Random(3).sample(sorted(small_fills(), key=repr), 300):
        patterns = small_class(boundary.n_sides)
        rows = PatternFilter().choose_rows(patterns, boundary)
        assert len(find_rows(get_strict_table(patterns), boundary, rows)) > 0


def test_filters_bound_number_and_valence() -> None:
    patterns = small_class(3)
    boundary = Boundary((4, 4, 4))
    every = PatternFilter().choose_rows(patterns, boundary)
    assert (patterns.n_reflex[every] == 0).all()
    for most in range(5):
        rows = PatternFilter(max_irregular=most).choose_rows(patterns, boundary)
        assert rows.tolist() == [r for r in every if patterns.n_irregular[r] <= most]
    for valence in [(3, 5), (3, 3), (5, 5), (4, 4), (5, 9)]:
        rows = PatternFilter(valence=valence).choose_rows(patterns, boundary)
        assert rows.tolist() == [
            r
            for r in every.tolist()
            if all(valence[0] <= v <= valence[1] for v in patterns.pattern(r).valences)
        ]
    assert len(every) > 3
