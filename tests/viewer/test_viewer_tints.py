"""Bundles of parallel polychords, and what is painted of them."""

from __future__ import annotations

import numpy as np
import pytest
from viewer_disks import ALL, disk, expand, pattern

from viewer.card import Card, facts_of, plural, valence_text
from viewer.drawing import boundary_bundles, bundles, draw, tint_numbers

REDUCED = ["one quad", "doublet", "two doublets", "triangle", "pentagon", "ring", "L", "plus"]


@pytest.mark.parametrize("name", REDUCED)
def test_a_reduced_pattern_has_a_bundle_for_every_polychord(name: str) -> None:
    p = pattern(ALL[name])
    assert np.array_equal(bundles(p.disk()), p.polychords().of_strand)


@pytest.mark.parametrize("name", REDUCED)
def test_expansion_keeps_the_bundles(name: str) -> None:
    p = pattern(ALL[name])
    widths = [2 + c % 3 for c in range(p.n_chords + p.n_loops)]
    d = expand(p, widths)
    bundle = bundles(d)
    label = [c for side in p.label for c in side for _ in range(widths[c])]
    assert boundary_bundles(d, bundle).tolist() == label
    assert bundle.max() + 1 == p.n_chords + p.n_loops
    assert np.array_equal(tint_numbers(d, bundle), tint_numbers(p.disk(), bundles(p.disk())))


def test_a_grid_has_two_bundles() -> None:
    assert bundles(disk(ALL["two quads"])).max() == 1


def test_bands_go_over_and_under() -> None:
    # Along a polychord, the band lies on top in every second quad.
    p = pattern(ALL["one quad"])
    drawing = draw(expand(p, [6, 6]))
    tints = drawing.tints.reshape(-1, 3, 3)
    on_top = (tints[:, 2] == tints[:, 0]).all(axis=1)
    assert on_top.sum() == 18
    grid = on_top.reshape(6, 6)
    assert (grid[:, 1:] != grid[:, :-1]).all() and (grid[1:] != grid[:-1]).all()


def test_a_mirrored_drawing_is_the_mirror_image() -> None:
    d = disk(ALL["L"])
    assert np.array_equal(draw(d, mirrored=True).points, draw(d).points * [-1.0, 1.0])


def test_corners_and_irregular_vertices() -> None:
    drawing = draw(disk(ALL["plus"]))
    assert len(drawing.convex) == 8 and len(drawing.reflex) == 4
    drawing = draw(disk(ALL["pentagon"]))
    assert drawing.valences.tolist() == [5]


def test_texts() -> None:
    assert valence_text([]) == "regular"
    assert valence_text([5, 3, 3]) == "3·3·5"
    assert valence_text([3] * 4 + [5] * 5) == "3×4 · 5×5"
    assert plural(1, "quad") == "1 quad" and plural(1200, "quad") == "1,200 quads"
    p = pattern(ALL["L"], frequency=1234)
    card = Card.of_pattern(p, 3)
    assert card.title == p.name and card.facts == "regular   1,234×"
    facts = dict(facts_of(p, p.disk(), [1] * 4, ["a.obj", "b.obj", "c.obj", "d.obj", "e.obj"]))
    assert facts["quads"] == "3" and facts["seen"] == "1,234 times"
    assert facts["meshes"] == "a.obj, b.obj, c.obj and 2 more"
    assert facts["corners"].split()[:6].count("3") == 1
