"""Constructed fills: always an answer, every invariant of it, best first, each once."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from query import Boundary, Fill
from query.boundary import CornerKind
from query.construct import PartFill, construct_fills
from query.construct.plan import carry_out_plan, count_least
from query.construct.planner import Planner
from query.errors import InvalidQueryError
from query.listing.construction import FamilyLookup
from query.recognition import count_irregular, count_quads
from tests.support.fillchecks import check_fill
from tests.support.query.cases import code_of
from tests.support.query.construct import assert_fills

LOOKUP = FamilyLookup()

CONVEX: list[CornerKind] = ["convex"]
REFLEX: list[CornerKind] = ["reflex"]
CONVEX_REFLEX = CONVEX + REFLEX


class NoLookup:
    """Knows nothing: what is left is the grid."""

    max_sides = 8

    def count(self, boundary: Boundary, *, strict: bool = False) -> int | None:
        return None

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        return None


def random_boundary(
    seed: int, sides: tuple[int, int], longest: int, reflex: float, shortest: int = 1
) -> Boundary:
    chance = random.Random(seed)
    n = chance.randint(*sides)
    lengths = [chance.randint(shortest, longest) for _ in range(max(n, 1))]
    lengths[0] += sum(lengths) % 2
    lengths[0] += max(0, 4 - sum(lengths))
    kinds: list[CornerKind] = ["reflex" if chance.random() < reflex else "convex" for _ in range(n)]
    return Boundary(lengths, kinds)


def assert_listed(fills: list[Fill], boundary: Boundary) -> None:
    for fill in fills:
        assert_fills(fill, boundary)
        assert (fill.origin, fill.pattern.origin) == ("constructed", "constructed")
    ranks = [(f.n_irregular, f.n_irregular_boundary, f.n_quads) for f in fills]
    assert ranks == sorted(ranks)
    assert len({code_of(f) for f in fills}) == len(fills)


def small_boundaries(perimeter: int, kinds: tuple[CornerKind, ...]) -> Iterator[Boundary]:
    """All of that perimeter up to rotation, every corner of one of the kinds."""
    if len(kinds) > 1:
        yield Boundary.closed(perimeter)
    for places in product((None, *kinds), repeat=perimeter):
        turned = min(
            (places[i:] + places[:i] for i in range(perimeter)),
            key=lambda row: [k or "" for k in row],
        )
        at = [i for i, kind in enumerate(places) if kind]
        if not at or places != turned:
            continue
        ends = [*at[1:], at[0] + perimeter]
        lengths = [end - begin for begin, end in zip(at, ends, strict=True)]
        yield Boundary(lengths, [k for k in places if k])


@pytest.mark.parametrize(
    ("perimeter", "kinds"),
    [
        (4, ("convex", "reflex")),
        (6, ("convex", "reflex")),
        (8, ("convex",)),
        (8, ("reflex",)),
        (10, ("convex",)),
    ],
)
def test_every_small_boundary_has_a_fill(perimeter: int, kinds: tuple[CornerKind, ...]) -> None:
    n = 0
    for boundary in small_boundaries(perimeter, kinds):
        (fill,) = construct_fills(boundary, LOOKUP, limit=1)
        assert_fills(fill, boundary)
        n += 1
    assert n > 10


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_small_boundaries_of_any_corners_have_fills(seed: int) -> None:
    boundary = random_boundary(seed, (0, 10), 3, 0.4)
    assert_listed(list(construct_fills(boundary, LOOKUP)), boundary)


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_convex_boundaries_have_fills(seed: int) -> None:
    boundary = random_boundary(seed, (0, 16), 9, 0)
    fills = list(construct_fills(boundary, LOOKUP))
    assert fills
    assert_listed(fills, boundary)


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_boundaries_with_reflex_corners_have_fills(seed: int) -> None:
    boundary = random_boundary(seed, (3, 12), 8, 0.25, shortest=2)
    fills = list(construct_fills(boundary, LOOKUP))
    assert fills
    assert_listed(fills, boundary)


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_strict_fills_have_their_corners_as_asked(seed: int) -> None:
    boundary = random_boundary(seed, (4, 12), 9, 0.1, shortest=3)
    strict = list(construct_fills(boundary, LOOKUP, strict=True))
    assert all(fill.strict for fill in strict)
    assert_listed(strict, boundary)


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_a_plan_foretells_its_irregular_vertices(seed: int) -> None:
    boundary = random_boundary(seed, (5, 16), 9, 0.1 if seed % 2 else 0)
    for plan in Planner(LOOKUP).plans(boundary, seed % 3 == 0):
        quads, n_vertices = carry_out_plan(plan, boundary.perimeter, LOOKUP)
        found = sum(count_irregular(count_quads(quads, n_vertices), boundary))
        assert count_least(plan) <= found <= plan.count


def test_corners_are_kept_where_there_is_room() -> None:
    for n in range(9, 15):
        boundary = Boundary([8] * n)
        fill = next(construct_fills(boundary, LOOKUP, strict=True))
        assert_fills(fill, boundary)
        assert fill.strict
        # One valence-5 vertex for every corner beyond four.
        assert fill.n_irregular == n - 4


@settings(max_examples=20, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_a_shorter_list_is_the_beginning_of_a_longer_one(seed: int) -> None:
    boundary = random_boundary(seed, (0, 11), 7, 0.2)
    whole = [code_of(fill) for fill in construct_fills(boundary, LOOKUP)]
    for limit in (1, 2, 5):
        some = [code_of(fill) for fill in construct_fills(boundary, LOOKUP, limit=limit)]
        assert some == whole[:limit]


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_a_grid_answers_what_nobody_knows(seed: int) -> None:
    boundary = random_boundary(seed, (0, 12), 4, 0.3)
    fill = next(construct_fills(boundary, NoLookup()))
    assert_fills(fill, boundary)
    perimeter, half = boundary.perimeter, boundary.perimeter // 2
    corner = dict(zip(boundary.side_starts, boundary.corners, strict=False))
    if boundary.convex and boundary.n_sides:
        # The spots of a grid's corners that hit most, by trying all.
        hits = max(
            sum(v % perimeter in corner for v in (p, p + a, p + half, p + half + a))
            for p in range(half)
            for a in range(1, half)
        )
        assert fill.n_irregular <= boundary.n_sides + 4 - 2 * hits


@pytest.mark.parametrize(
    "boundary",
    [
        Boundary([1] * 34),
        Boundary([1] * 300),
        Boundary([1] * 33 + [101]),
        Boundary([1, 20] * 16),
        Boundary([3] * 34),
        Boundary([500, 3, 2, 4, 2, 1, 2, 2, 2]),
        Boundary([600, 9, 8, 7]),
        Boundary([16] * 50),
        Boundary([20, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 14]),
        Boundary([18, 97, 20, 37, 1, 1, 8]),
        Boundary([4, 4] * 12, CONVEX_REFLEX * 12),
        Boundary([3] * 20, REFLEX * 20),
        Boundary.closed(4),
        Boundary.closed(50),
        Boundary([50]),
        Boundary([50], ["reflex"]),
        Boundary([1, 3], ["reflex", "reflex"]),
    ],
    ids=lambda b: f"{b.n_sides}-{b.perimeter}",
)
def test_extreme_boundaries_have_a_fill(boundary: Boundary) -> None:
    (fill,) = construct_fills(boundary, LOOKUP, limit=1)
    assert_fills(fill, boundary)


def test_a_closed_side_is_a_square() -> None:
    (fill,) = construct_fills(Boundary.closed(12), LOOKUP)
    assert (fill.n_irregular, fill.n_quads) == (4, 9)
    assert next(construct_fills(Boundary([12]), LOOKUP)).n_irregular == 3


def test_an_l_shape_is_two_rectangles() -> None:
    """The chord prolongs a side through the reflex corner, and everything is regular."""
    boundary = Boundary([8, 3, 5, 4, 3, 7], CONVEX * 3 + REFLEX + CONVEX * 2)
    assert next(construct_fills(boundary, LOOKUP, strict=True)).n_irregular == 0


def test_a_limit_below_one_is_refused() -> None:
    with pytest.raises(InvalidQueryError, match="at least 1"):
        construct_fills(Boundary([1, 1, 1, 1]), LOOKUP, limit=0)


class BrokenLookup(FamilyLookup):
    """Its fills are no meshes: a corner vertex is joined to the next but one."""

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        part = super().best(boundary, strict=strict)
        if part is None:
            return None
        quads = part.quads.copy()
        quads[0] = quads[-1]
        return PartFill(quads, part.n_irregular)


def test_parts_that_do_not_join_to_a_mesh_are_left_out() -> None:
    boundary = Boundary([5, 4, 6, 5, 4, 5, 6, 5])
    (fill,) = construct_fills(boundary, BrokenLookup(), limit=1)
    assert_fills(fill, boundary)


def test_fills_are_disks_along_their_boundary() -> None:
    for seed in range(8):
        boundary = random_boundary(seed, (5, 14), 6, 0)
        listed = list(construct_fills(boundary, LOOKUP, limit=3))
        assert listed
        for fill in listed:
            document = {
                "quads": fill.quads.tolist(),
                "sides": [side.tolist() for side in fill.sides()],
                "n_irregular": fill.n_irregular,
                "n_vertices": fill.n_vertices,
            }
            check_fill(boundary.lengths, document)
