"""Bundles of parallel polychords, and what is painted of them."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb.core.bundles import find_boundary_bundles, find_bundles
from tests.support.viewer.disks import ALL, disk, expand, pattern
from viewer.card import Card, collect_facts, format_count, format_valences
from viewer.drawing import choose_tints, draw_disk

REDUCED = ["one quad", "doublet", "two doublets", "triangle", "pentagon", "ring", "L", "plus"]


@pytest.mark.parametrize("name", REDUCED)
def test_a_reduced_pattern_has_a_bundle_for_every_polychord(name: str) -> None:
    p = pattern(ALL[name])
    assert np.array_equal(find_bundles(p.disk()), p.polychords().of_strand)


@pytest.mark.parametrize("name", REDUCED)
def test_expansion_keeps_the_bundles(name: str) -> None:
    p = pattern(ALL[name])
    widths = [2 + c % 3 for c in range(p.n_chords + p.n_loops)]
    d = expand(p, widths)
    bundle = find_bundles(d)
    label = [c for side in p.label for c in side for _ in range(widths[c])]
    assert find_boundary_bundles(d, bundle).tolist() == label
    assert bundle.max() + 1 == p.n_chords + p.n_loops
    assert np.array_equal(choose_tints(d, bundle), choose_tints(p.disk(), find_bundles(p.disk())))


def test_a_grid_has_two_bundles() -> None:
    assert find_bundles(disk(ALL["two quads"])).max() == 1


def test_bands_go_over_and_under() -> None:
    # Along a polychord, the band lies on top in every second quad.
    p = pattern(ALL["one quad"])
    drawing = draw_disk(expand(p, [6, 6]))
    tints = drawing.tints.reshape(-1, 3, 3)
    on_top = (tints[:, 2] == tints[:, 0]).all(axis=1)
    assert on_top.sum() == 18
    grid = on_top.reshape(6, 6)
    assert (grid[:, 1:] != grid[:, :-1]).all() and (grid[1:] != grid[:-1]).all()


def test_a_mirrored_drawing_is_the_mirror_image() -> None:
    d = disk(ALL["L"])
    assert np.array_equal(draw_disk(d, mirrored=True).points, draw_disk(d).points * [-1.0, 1.0])


def test_corners_and_irregular_vertices() -> None:
    drawing = draw_disk(disk(ALL["plus"]))
    assert len(drawing.convex) == 8 and len(drawing.reflex) == 4
    drawing = draw_disk(disk(ALL["pentagon"]))
    assert drawing.valences.tolist() == [5]


def test_texts() -> None:
    assert format_valences([]) == "regular"
    assert format_valences([5, 3, 3]) == "3·3·5"
    assert format_valences([3] * 4 + [5] * 5) == "3×4 · 5×5"
    assert format_count(1, "quad") == "1 quad" and format_count(1200, "quad") == "1,200 quads"
    p = pattern(ALL["L"], frequency=1234)
    card = Card.of_pattern(p, 3)
    assert card.title == p.name and card.facts == "regular   1,234×"
    facts = dict(collect_facts(p, p.disk(), [1] * 4, ["a.obj", "b.obj", "c.obj", "d.obj", "e.obj"]))
    assert facts["quads"] == "3" and facts["seen"] == "1,234 times"
    assert facts["meshes"] == "a.obj, b.obj, c.obj and 2 more"
    assert facts["corners"].split()[:6].count("3") == 1
