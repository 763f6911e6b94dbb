"""Counts of networks: chosen by length, kept where they are settled, changed as few as can be."""

from __future__ import annotations

import pytest

from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.filling import (
    change_counts,
    choose_counts,
    complete_counts,
    find_strip,
    free_counts,
    side_lengths,
    weld_patches,
)
from patterndb_sketch.retopo.network import Network, set_count
from query.engine import PatternSource
from tests.support.retopo.editors import (
    SIZES,
    chain_at,
    do,
    drawn_grid,
    line,
    patch_around,
)
from tests.support.retopo.filling import EDGE, assert_even, different
from tests.support.retopo.networks import plane


@pytest.fixture(scope="module")
def grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads."""
    return drawn_grid(source).fill().network


def test_a_square_grid_is_counted_by_its_lengths(grid: Network) -> None:
    used = {half >> 1 for patch in grid.patches.values() for half in patch.loop}
    assert {grid.chains[c].count for c in used} == {4}
    assert all(side_lengths(grid, patch) == (4, 4, 4, 4) for patch in grid.patches.values())
    border = set(grid.chains) - used
    assert {grid.chains[c].count for c in border} == {0}, "no patch is beside it"
    again, notes = complete_counts(grid, EDGE)
    assert again is grid
    assert notes == ()


def test_settled_counts_stay_where_something_is_drawn(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = editor.fill().network
    do(editor, "stroke", points=line((1, 1.5), (2, 1.5)))
    after = editor.fill().network
    assert_even(after)
    kept = before.chains.keys() & after.chains.keys()
    assert len(before.chains) - len(kept) == 2
    assert all(before.chains[c].count == after.chains[c].count for c in kept)
    halves = [c for c in after.chains.keys() - kept if after.chains[c].length < 0.6]
    assert sorted(after.chains[c].count for c in halves) == [2, 2, 2, 2]


def test_pinned_counts_stay_and_others_do_not(grid: Network) -> None:
    pinned = chain_at(grid, 0.5, 0)
    other = chain_at(grid, 2.5, 0)
    network = set_count(set_count(grid, pinned, 8, pinned=True), other, 8)
    chosen, notes = choose_counts(network, EDGE)
    assert notes == ()
    assert_even(chosen)
    assert chosen.chains[pinned].count == 8
    assert chosen.chains[other].count == 4
    free = free_counts(chosen, [pinned])
    assert free.chains[pinned].count == 8
    assert not free.chains[pinned].pinned
    assert choose_counts(free, EDGE)[0].chains[pinned].count == 4
    with pytest.raises(InvalidRetopoError, match="there is no chain 9999"):
        free_counts(grid, [9999])


def test_pins_that_cannot_be_are_told_with_their_names(grid: Network) -> None:
    patch = grid.patches[patch_around(grid, 1.5, 1.5)]
    chains = [half >> 1 for half in patch.loop]
    network = grid
    for chain, count in zip(chains, (3, 4, 4, 4), strict=True):
        network = set_count(network, chain, count, pinned=True)
    for made, notes in (complete_counts(network, EDGE), choose_counts(network, EDGE)):
        (note,) = notes
        assert f"around patch {patch.id} add up to an odd number" in note
        assert all(str(chain) in note for chain in chains)
        assert all(made.chains[c].count == network.chains[c].count for c in chains)
        others = [p for p in made.patches.values() if p.id != patch.id]
        assert all(sum(side_lengths(made, p)) % 2 == 0 for p in others)


def test_one_count_more_changes_a_few_others(grid: Network) -> None:
    border = chain_at(grid, 0.5, 0)
    made, notes = change_counts(grid, EDGE, {border: 5})
    assert notes == ()
    assert_even(made)
    assert made.chains[border].count == 5
    assert made.chains[border].pinned
    assert len(different(grid, made) - {border}) <= 3
    loosely, _ = change_counts(grid, EDGE, {border: 5}, pin=False)
    assert not loosely.chains[border].pinned
    assert loosely.chains[border].count == 5


def test_two_counts_more_change_nothing_else_where_that_is_even(grid: Network) -> None:
    border = chain_at(grid, 0.5, 0)
    made, _ = change_counts(grid, EDGE, {border: 6})
    assert_even(made)
    assert len(different(grid, made)) <= 4


def test_counts_below_one_and_unknown_chains_are_refused(grid: Network) -> None:
    with pytest.raises(RefusedError, match="would have 0 edges; the least is 1"):
        change_counts(grid, EDGE, {chain_at(grid, 0.5, 0): 0})
    with pytest.raises(InvalidRetopoError, match="there is no chain 9999"):
        change_counts(grid, EDGE, {9999: 3})


def test_a_curve_of_no_patch_is_counted_too(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    do(editor, "stroke", points=line((0, 0), (1, 0)))
    do(editor, "subdivide", at=[0.5, 0, 0], count=7)
    assert editor.network.chains[chain_at(editor.network, 0.5, 0)].count == 7
    assert editor.fill().network is editor.network


def test_strips_run_straight_through_quads(grid: Network) -> None:
    across = chain_at(grid, 0.5, 0)
    wanted = {chain_at(grid, 0.5, y) for y in range(4)}
    assert set(find_strip(grid, across)) == wanted
    assert find_strip(grid, across)[0] == across
    inner = chain_at(grid, 1, 1.5)
    assert set(find_strip(grid, inner)) == {chain_at(grid, x, 1.5) for x in range(4)}


def test_strips_end_where_sides_are_of_several_curves(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((1.5, 1), (1.5, 2)))
    network = editor.network
    # Of the cells above and below the one that is cut, the sides next to it are two curves each.
    assert set(find_strip(network, chain_at(network, 1.5, 0))) == {chain_at(network, 1.5, 0)}
    cut = {chain_at(network, x, y) for x in (1.25,) for y in (1, 2)}
    assert set(find_strip(network, chain_at(network, 1.25, 1))) == cut
    along = find_strip(network, chain_at(network, 0, 1.5))
    assert set(along) == {chain_at(network, x, 1.5) for x in (0, 1, 1.5, 2, 3)}


def test_a_loop_through_a_row_is_twelve_quads_more(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = weld_patches(editor.fill())
    assert len(before.quads) == 9 * 16
    do(editor, "subdivide", at=[0.5, 0, 0], by=1, strip=True)
    found = editor.fill()
    assert len(weld_patches(found).quads) == len(before.quads) + 12
    fives = [c for c, chain in found.network.chains.items() if chain.count == 5]
    assert set(fives) == {chain_at(found.network, 0.5, y) for y in range(4)}
