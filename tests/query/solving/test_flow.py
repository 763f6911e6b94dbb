"""Strokes in the solving: kernel, CP-SAT and trying agree, solution for solution."""

from __future__ import annotations

import itertools
import os
import random

import numpy as np
import pytest

from tests.support.query.cases import Chords, Strokes, Widths, brute_force, find_widths, is_feasible

#: Random systems to compare all solvers on; a release is held to 5,000.
SYSTEMS = int(os.environ.get("QUERY_SYSTEMS", "120"))


def edges_off(chords: Chords, widths: Widths, flows: Strokes) -> int | None:
    """The fewest edges by which distinct strands miss all strokes, None beyond the tolerance.

    By laying the strands out along the boundary, one by one.
    """
    ends: dict[tuple[int, int], list[tuple[int, int]]] = {}
    seen: set[int] = set()
    for side in range(chords.n_sides):
        at = 0
        for chord in chords.label[side]:
            across = range(widths[chord])
            # The second end sees the strands in reverse.
            for t in reversed(across) if chord in seen else across:
                ends.setdefault((chord, t), []).append((side, at))
                at += 1
            seen.add(chord)
    strands = list(ends.values())
    fits: list[list[tuple[int, int]]] = []
    for a, i, b, j in flows.rows.tolist():
        fits.append([])
        for number, pair in enumerate(strands):
            for (side0, at0), (side1, at1) in (pair, pair[::-1]):
                off = (abs(at0 - i), abs(at1 - j))
                if (side0, side1) == (a, b) and max(off) <= flows.tolerance:
                    fits[-1].append((number, sum(off)))
    sums = [
        sum(off for _, off in chosen)
        for chosen in itertools.product(*fits)
        if len({number for number, _ in chosen}) == len(chosen)
    ]
    return min(sums, default=None)


def tried(chords: Chords, lengths: list[int], flows: Strokes) -> list[Widths]:
    """All solutions, best first, by trying all widths."""
    off = {w: edges_off(chords, w, flows) for w in brute_force(chords, lengths)}
    kept = [(o, sum(x * x for x in w), w) for w, o in off.items() if o is not None]
    return [w for _, _, w in sorted(kept)]


def random_flows(chance: random.Random, most_sides: int) -> tuple[Chords, list[int], Strokes]:
    """A random label, lengths and strokes; half of the strokes lie on strands of a solution."""
    n_sides = chance.randint(1, most_sides)
    n = chance.randint(1, 6)
    label: list[list[int]] = [[] for _ in range(n_sides)]
    ends = [c for c in range(n) for _ in range(2)]
    chance.shuffle(ends)
    for c in ends:
        label[chance.randrange(n_sides)].append(c)
    names: dict[int, int] = {}
    chords = Chords.from_label([[names.setdefault(c, len(names)) for c in s] for s in label])
    planted = [chance.randint(1, 4) for _ in range(n)]
    lengths = chords.side_lengths(planted).tolist()
    if chance.random() < 0.2:
        for _ in range(2):
            lengths[chance.randrange(n_sides)] += 1
    strokes: list[list[int]] = []
    for _ in range(chance.choice([1, 1, 2, 2, 3])):
        if chance.random() < 0.5:
            c = chance.randrange(n)
            t = chance.randrange(planted[c])
            at: list[int] = []
            places = [
                (s, e) for s, of in enumerate(chords.label) for e, d in enumerate(of) if d == c
            ]
            for side, place in places:
                before = chords.label[side][:place]
                inside = planted[c] - 1 - t if at else t
                at += [side, sum(planted[b] for b in before) + inside]
            strokes.append(at if chance.random() < 0.5 else at[2:] + at[:2])
        else:
            sides = [s for s in range(n_sides) if lengths[s]]
            a, b = chance.choice(sides), chance.choice(sides)
            strokes.append([a, chance.randrange(lengths[a]), b, chance.randrange(lengths[b])])
    return (
        chords,
        lengths,
        Strokes(np.array(strokes, np.int32), chance.choice([0, 1, 1, 2])),
    )


@pytest.mark.parametrize("seed", range(4))
def test_kernel_cpsat_and_trying_agree(seed: int) -> None:
    chance = random.Random(seed)
    solvable = several = 0
    for _ in range(SYSTEMS // 4):
        chords, lengths, flows = random_flows(chance, 5)
        expected = tried(chords, lengths, flows)
        solvable += bool(expected)
        several += len(expected) > 1
        for by_cpsat in (False, True):
            found = find_widths(chords, lengths, None, flows, by_cpsat=by_cpsat)
            assert found == expected
            assert is_feasible(chords, lengths, flows, by_cpsat=by_cpsat) == bool(expected)
        for limit in (1, 2, 5):
            assert find_widths(chords, lengths, limit, flows) == expected[:limit]
    assert solvable >= SYSTEMS // 12
    assert several > SYSTEMS // 40


def test_two_strokes_on_one_polychord_need_two_strands() -> None:
    grid = Chords.from_label(((0,), (1,), (0,), (1,)))
    across = np.array([[0, 1, 2, 1], [0, 1, 2, 1]], np.int32)
    assert find_widths(grid, [3, 2, 3, 2], None, Strokes(across[:1], 0)) == [(3, 2)]
    assert not is_feasible(grid, [3, 2, 3, 2], Strokes(across, 0))
    assert is_feasible(grid, [3, 2, 3, 2], Strokes(across, 1))
    at_corners = np.array([[0, 0, 2, 0], [0, 0, 2, 0]], np.int32)
    assert not is_feasible(grid, [1, 2, 1, 2], Strokes(at_corners, 3))


def test_the_second_end_sees_strands_in_reverse() -> None:
    grid = Chords.from_label(((0,), (1,), (0,), (1,)))
    for edge in range(5):
        right = np.array([[0, edge, 2, 4 - edge]], np.int32)
        assert is_feasible(grid, [5, 2, 5, 2], Strokes(right, 0))
        wrong = np.array([[0, edge, 2, edge]], np.int32)
        assert is_feasible(grid, [5, 2, 5, 2], Strokes(wrong, 0)) == (edge == 2)


def test_the_example_of_the_paper() -> None:
    """Figure 10 of Marcias et al. 2015, as far as its text gives it.

    Side 0 has the polychords x1 x2 x3 x4 and 6 edges; x2 and x4 run on to side 1; the stroke
    leaves side 0 at edge 2. What the text does not give, the other sides, is made such that
    there are just the two solutions that the figure shows: (c) with nothing off, (d) with
    the strand off by one edge.
    """
    x1, x2, x3, x4, x7, x8 = range(6)
    chords = Chords.from_label(((x1, x2, x3, x4), (x4, x2), (x3, x7), (x7, x8), (x8, x1)))
    lengths = [6, 2, 3, 3, 4]
    c, d = (2, 1, 2, 1, 1, 2), (3, 1, 1, 1, 2, 1)
    assert sorted(find_widths(chords, lengths)) == [c, d]
    stroke = np.array([[0, 2, 1, 1]], np.int32)
    for by_cpsat in (False, True):
        assert find_widths(chords, lengths, None, Strokes(stroke, 0), by_cpsat=by_cpsat) == [c]
        assert find_widths(chords, lengths, None, Strokes(stroke, 1), by_cpsat=by_cpsat) == [c, d]
