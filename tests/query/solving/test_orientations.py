"""Which orientations of a pattern fit: against every orientation by itself, and CP-SAT."""

from __future__ import annotations

import random

import numpy as np
import pytest

from patterndb.core.pattern import Pattern
from query import Boundary
from query.listing.table import get_strict_table
from query.orientation import list_orientations
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.problem import build_width_problem
from query.solving.systems import systems_of
from query.solving.widths import WidthSolver
from tests.query.solving.test_feasibility import boundaries
from tests.support.query.cases import (
    Chords,
    all_allowed,
    brute_force,
    find_orientations,
    find_rows,
    is_feasible,
    small_class,
    small_patterns,
)


def fitting_orientations(pattern: Pattern, boundary: Boundary) -> list[bool]:
    """By the definition of an orientation, and by trying widths."""
    chords = Chords.from_label(pattern.label)
    found = []
    for orientation in list_orientations(pattern.n_sides):
        lengths, corners = orientation.seen(boundary)
        found.append(
            tuple(corners.tolist()) == pattern.corners
            and bool(brute_force(chords, lengths.tolist()))
        )
    return found


@pytest.mark.parametrize("n_sides", range(0, 11))
def test_every_orientation_is_answered_by_itself(n_sides: int) -> None:
    patterns = small_class(n_sides)
    table = get_strict_table(patterns)
    chance = random.Random(100 + n_sides)
    some = 0
    for boundary in boundaries(n_sides, chance, 10, 5):
        rows = PatternFilter().choose_rows(patterns, boundary)
        fit = find_orientations(table, boundary, rows, 1)
        assert fit.shape == (len(rows), 2 * max(n_sides, 1))
        some += int(fit.sum())
        for at in chance.sample(range(len(rows)), min(len(rows), 25)):
            pattern = patterns.pattern(int(rows[at]))
            assert fit[at].tolist() == fitting_orientations(pattern, boundary)
    assert some


@pytest.mark.parametrize("n_sides", [3, 4, 6])
def test_cpsat_answers_every_orientation_the_same(n_sides: int) -> None:
    patterns = small_class(n_sides)
    table = get_strict_table(patterns)
    chance = random.Random(n_sides)
    for boundary in boundaries(n_sides, chance, 3, 9):
        rows = PatternFilter().choose_rows(patterns, boundary)
        rows = np.sort(chance.sample(rows.tolist(), min(len(rows), 12)))
        fit = find_orientations(table, boundary, rows)
        for at, row in enumerate(rows.tolist()):
            pattern = patterns.pattern(row)
            chords = Chords.from_label(pattern.label)
            for o, orientation in enumerate(list_orientations(n_sides)):
                lengths, corners = orientation.seen(boundary)
                same = tuple(corners.tolist()) == pattern.corners
                assert fit[at, o] == (same and is_feasible(chords, lengths, by_cpsat=True))


@pytest.mark.parametrize("n_sides", [1, 5, 8])
def test_slices_of_rows_answer_as_the_whole(n_sides: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feasibility, "ROWS_PER_THREAD", 16)
    patterns = small_class(n_sides)
    table = get_strict_table(patterns)
    for boundary in boundaries(n_sides, random.Random(1), 6, 6):
        rows = PatternFilter().choose_rows(patterns, boundary)
        np.random.default_rng(2).shuffle(rows)
        whole = find_orientations(table, boundary, rows, 3)
        parts = [find_orientations(table, boundary, part) for part in np.array_split(rows, 5)]
        assert (np.concatenate(parts) == whole).all()
        fit = find_rows(table, boundary, rows)
        assert fit.tolist() == rows[whole.any(axis=1)].tolist()


def test_a_call_that_is_cancelled_looks_at_nothing() -> None:
    patterns = small_class(5)
    boundary = Boundary((4, 4, 4, 4, 4))
    rows = PatternFilter().choose_rows(patterns, boundary)
    table = get_strict_table(patterns)
    flag = np.zeros(1, np.uint8)
    solver = WidthSolver(build_width_problem(boundary), cancelled=flag)
    asked = table, rows, all_allowed(table, boundary, rows)
    assert solver.is_feasible(*asked).any()
    assert solver.find_feasible(*asked).any()
    flag[0] = 1
    assert not solver.is_feasible(*asked).any()
    assert not solver.find_feasible(*asked).any()


def test_systems_are_made_once_and_forgotten_with_their_class() -> None:
    patterns = [p for p in small_patterns() if p.n_sides == 3]
    one = type(small_class(3)).from_patterns(3, patterns[:4])
    other = type(small_class(3)).from_patterns(3, patterns[4:])
    assert systems_of(one) is systems_of(one)
    assert systems_of(other) is not systems_of(one)
    for made, of in ((systems_of(one), one), (systems_of(other), other)):
        for r, joins in enumerate(of.joins):
            first, last = made.first[r : r + 2]
            classes = zip(
                made.class_i[first:last].tolist(),
                made.class_j[first:last].tolist(),
                strict=True,
            )
            i, j = np.nonzero(np.triu(joins))
            assert sorted(map(sorted, classes)) == np.c_[i, j].tolist()
            for s, q in enumerate(made.claim[r].tolist()):
                a, b = made.near_first[q : q + 2]
                assert made.claimant[q] == s
                assert made.near[a:b].tolist() == np.flatnonzero(joins[s]).tolist()
