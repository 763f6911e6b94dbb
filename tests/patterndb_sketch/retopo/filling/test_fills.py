"""The fills of patches: the first of the list, others on demand, and those along flow lines."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import (
    Choice,
    Filling,
    Flow,
    add_flow,
    change_counts,
    clear_flows,
    fill_network,
    filling_of,
    has_suitable_fill,
    rank_fills,
    side_lengths,
    step_fill,
    take_fill,
    weld_patches,
)
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.network import Network, are_equal, set_choice, set_count
from query.engine import PatternSource
from tests.support.retopo.editors import (
    chain_at,
    do,
    drawn_grid,
    line,
    patch_around,
    same_arrays,
)
from tests.support.retopo.filling import EDGE
from tests.support.retopo.networks import plane


@pytest.fixture(scope="module")
def grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads."""
    return drawn_grid(source).fill().network


def test_every_patch_is_filled_for_its_counts(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.5, 1), (0.5, 1.5), (1, 2)))
    do(editor, "erase", at=[2, 2.5, 0])
    do(editor, "corner", at=[2.5, 0, 0])
    do(editor, "subdivide", at=[1.5, 0, 0], count=7)
    found = editor.fill()
    assert found.notes == ()
    assert found.placed.keys() == found.network.patches.keys()
    kinds = {len(patch.corners) for patch in found.network.patches.values()}
    assert len(kinds) > 2
    for patch, placed in found.placed.items():
        at = found.network.patches[patch]
        choice = filling_of(at).choice
        assert choice is not None
        assert has_suitable_fill(found.network, at)
        assert choice.by == "program"
        assert choice.lengths == side_lengths(found.network, at)
        assert same_arrays(choice.faces, placed.quads)
        assert placed.perimeter == choice.perimeter
        assert len(placed.flipped) == 0
        assert np.allclose(np.linalg.norm(placed.normals, axis=1), 1.0)


def test_the_first_of_the_list_is_taken_and_others_on_demand(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 1.5, 1.5)
    network, _ = change_counts(grid, EDGE, {chain_at(grid, 1.5, 1): 6, chain_at(grid, 1, 1.5): 6})
    listed = list(rank_fills(network, network.patches[patch], source))
    assert len(listed) > 4
    for number in (0, 3):
        made = take_fill(network, patch, source, number)
        assert filling_of(made.patches[patch]).choice == Choice.of(listed[number], "user")
    flowing = add_flow(network, patch, np.array([[1.02, 1.4, 0], [1.5, 1.5, 0], [1.6, 1.98, 0]]))
    with pytest.raises(RefusedError, match="has no fill 900; its list is shorter"):
        take_fill(flowing, patch, source, 900)
    # Stepping goes round the list, both ways.
    first = take_fill(network, patch, source, 0)
    assert are_equal(step_fill(first, patch, source, 3), take_fill(network, patch, source, 3))
    assert are_equal(
        step_fill(first, patch, source, -1), take_fill(network, patch, source, len(listed) - 1)
    )
    assert are_equal(step_fill(step_fill(first, patch, source, 5), patch, source, -5), first)
    assert are_equal(step_fill(first, patch, source, len(listed)), first)
    # From no fill, one on is the first, and one back the last.
    none = set_choice(network, patch, None)
    assert are_equal(step_fill(none, patch, source, 1), first)
    last = take_fill(network, patch, source, len(listed) - 1)
    assert are_equal(step_fill(none, patch, source, -1), last)


def test_what_the_user_took_is_kept_for_other_counts_where_it_fits(
    source: PatternSource,
) -> None:
    editor = drawn_grid(source)
    do(editor, "subdivide", at=[1.5, 1, 0], count=6)
    editor.fill()
    do(editor, "choose", at=[1.5, 1.5, 0], number=2)
    patch = find_patch(editor.network, editor.surface, [1.5, 1.5, 0])
    chosen = filling_of(editor.network.patches[patch]).choice
    assert chosen is not None
    assert chosen.by == "user"
    assert filling_of(editor.fill().network.patches[patch]).choice == chosen
    do(editor, "subdivide", at=[1.5, 1, 0], by=2)
    again = filling_of(editor.fill().network.patches[patch]).choice
    assert again is not None
    assert again.lengths != chosen.lengths
    fits = [
        fill
        for fill in rank_fills(editor.network, editor.network.patches[patch], source)
        if Choice.of(fill).code == chosen.code
    ]
    assert (again.by, again.code) == ("user", chosen.code) if fits else again.by == "program"


def test_flow_lines_lead_the_edges_until_they_are_cleared(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = editor.fill().network
    patch = patch_around(before, 1.5, 1.5)
    across = [[1.02, 1.4, 0], [1.5, 1.5, 0], [1.6, 1.98, 0]]
    do(editor, "flow", points=across)
    assert filling_of(editor.network.patches[patch]).choice is None
    found = editor.fill()
    filling = filling_of(found.network.patches[patch])
    former = filling_of(before.patches[patch]).choice
    assert former is not None
    assert filling.choice is not None
    assert filling.choice.code != former.code, "no regular grid turns from side to side"
    assert len(filling.flows) == 1
    listed = rank_fills(found.network, found.network.patches[patch], source)
    assert next(listed).flow_distance is not None
    do(editor, "flow", clear=[1.5, 1.5, 0])
    assert filling_of(editor.network.patches[patch]).flows == ()
    cleared = filling_of(editor.fill().network.patches[patch])
    assert cleared.choice == former
    assert editor.do(Call("flow", {"clear": [1.5, 1.5, 0]})).refused is not None
    with pytest.raises(RefusedError, match="has no flow lines"):
        clear_flows(editor.network, patch)


def test_a_flow_line_that_leads_nowhere_leaves_its_patch_empty_and_is_told(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 0.5, 0.5)
    made = add_flow(grid, patch, np.array([[0.45, 0.02, 0], [0.5, 0.05, 0], [0.48, 0.02, 0]]))
    found = fill_network(made, plane(), source, EDGE)
    assert found.placed.keys() == grid.patches.keys() - {patch}
    (note,) = found.notes
    assert note.startswith(f"patch {patch} cannot be filled: the stroke")
    assert len(weld_patches(found).quads) == 8 * 16


def test_a_patch_of_an_odd_border_is_refused_and_told(source: PatternSource, grid: Network) -> None:
    patch = grid.patches[patch_around(grid, 0.5, 0.5)]
    network = grid
    for half, count in zip(patch.loop, (3, 4, 4, 4), strict=True):
        network = set_count(network, half >> 1, count, pinned=True)
    with pytest.raises(RefusedError, match="has 15 edges around it, and a fill needs an even"):
        rank_fills(network, network.patches[patch.id], source)
    found = fill_network(network, plane(), source, EDGE)
    assert patch.id not in found.placed
    assert any("has 15 edges around it" in note for note in found.notes)


def test_fillings_keep_what_they_are_given() -> None:
    filling = Filling().with_moved([3, 7], [[1, 2, 3], [0.1, -0.0, 1e300]])
    which, places = filling.moved_vertices
    assert which.tolist() == [3, 7]
    assert same_arrays(places, np.array([[1, 2, 3], [0.1, -0.0, 1e300]]))
    assert filling.with_choice(None) == Filling(), "places are those of one fill"
    assert Flow.of([[1, 2, 3], [4, 5, 6]]).points.tolist() == [[1, 2, 3], [4, 5, 6]]
