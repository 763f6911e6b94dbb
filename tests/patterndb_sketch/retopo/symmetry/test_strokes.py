"""Strokes and symmetry: curves drawn before it is put on, and strokes across its plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, seed, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import SYMMETRY, add_chain, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import (
    Plane,
    begin_symmetry,
    cut_half,
    end_symmetry,
    refuse_beyond,
    split_stroke,
)
from patterndb_sketch.retopo.tools.loop import cut_loop
from patterndb_sketch.retopo.tools.stroke import insert_stroke_on_half
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.networks import genus, is_drawn_within
from tests.support.retopo.symmetry import TILTED, X, ball, empty, half, seam


def test_curves_drawn_before_are_cut_and_told() -> None:
    sizes = Sizes.of(ball().diagonal)
    at = half("ball", X)
    t = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    network = empty(ball(), sizes)
    drawn: list[int] = []
    for level, radius in ((0.5, 1.0), (0.0, 1.0)):
        circle = np.stack([radius * np.cos(t), radius * np.sin(t), 0.0 * t + level], axis=1)
        stroke = clean_stroke(circle, ball(), sizes, True)
        edit = insert_stroke_on_half(
            network, cut_half(ball(), Plane((-9.0, 0.0, 0.0))), sizes, stroke
        )
        network = edit.network
        drawn += edit.chains
    # One on the far side alone, and one on the near side alone.
    for x in (-0.8, 0.8):
        small = np.stack([0.0 * t + x, 0.3 * np.cos(t), 0.3 * np.sin(t) + 0.7], axis=1)
        far = clean_stroke(small / np.linalg.norm(small, axis=1)[:, None], ball(), sizes, True)
        network = insert_stroke_on_half(
            network, cut_half(ball(), Plane((-9.0, 0.0, 0.0))), sizes, far
        ).network
    before = network
    edit = begin_symmetry(network, at, sizes.sampling)
    check_network(edit.network)
    assert genus(edit.network) == 0
    assert any(note.startswith("2 curves are cut at the plane") for note in edit.notes), edit.notes
    for chain in edit.network.chains.values():
        assert at.plane.heights(chain.points).min() > -1e-12
    for chain in seam(edit.network):
        assert abs(at.plane.heights(edit.network.chains[chain].points)).max() == 0.0
    # What is on the near side alone is as it was.
    same = edit.network.chains.keys() & before.chains.keys()
    assert same
    assert all(edit.network.chains[c] is before.chains[c] for c in same)
    with pytest.raises(RefusedError, match="on already"):
        begin_symmetry(edit.network, at, sizes.sampling)
    with pytest.raises(RefusedError, match="off already"):
        end_symmetry(before, ball(), sizes, X)


def test_two_curves_across_one_place_are_refused() -> None:
    sizes = Sizes.of(ball().diagonal)
    network = empty(ball(), sizes)
    up = np.array([0.0, 0.0, 1.0])
    for shift in (0.0, 0.3):
        line = np.array([[-0.2, -shift, 1.0], [0.0, 0.0, 1.0], [0.2, shift, 1.0]])
        network, _ = add_chain(network, line, np.tile(up, (3, 1)))
    with pytest.raises(RefusedError, match="at one place"):
        begin_symmetry(network, half("ball", X), sizes.sampling)


def test_closed_strokes_become_open_and_end_on_the_plane() -> None:
    sizes, at = Sizes.of(ball().diagonal), half("ball", X)
    t = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    wave = 0.3 * np.sin(3.0 * t)
    circle = np.stack([np.cos(t), np.sin(t), wave], axis=1)
    circle /= np.linalg.norm(circle, axis=1)[:, None]
    stroke = clean_stroke(circle, ball(), sizes, True)
    (part,), beyond = split_stroke(stroke, at, sizes)
    assert beyond == 1
    assert not part.closed
    assert (part.points[[0, -1], 0] == 0.0).all()
    assert part.points[:, 0].min() == 0.0
    # One that does not cross stays closed; one beyond is nothing.
    small = np.stack([0.0 * t + 0.8, 0.3 * np.cos(t), 0.3 * np.sin(t)], axis=1)
    near = clean_stroke(small, ball(), sizes, True)
    assert [part.closed for part in split_stroke(near, at, sizes)[0]] == [True]
    far = clean_stroke(small * [-1.0, 1.0, 1.0], ball(), sizes, True)
    assert split_stroke(far, at, sizes) == ([], 1)
    network = begin_symmetry(empty(ball(), sizes), at, sizes.sampling).network
    with pytest.raises(RefusedError, match="other side of the plane"):
        insert_stroke_on_half(network, at, sizes, far)
    with pytest.raises(RefusedError, match="the spine crosses the plane"):
        refuse_beyond(stroke, at, "the spine")
    refuse_beyond(near, at, "the spine")


def test_a_stroke_along_the_plane_is_none() -> None:
    sizes, at = Sizes.of(ball().diagonal), half("ball", X)
    t = np.linspace(0.3, 1.5, 80)
    line = np.stack([0.2 * sizes.snap * np.sin(40.0 * t), np.cos(t), np.sin(t)], axis=1)
    stroke = SurfaceCurve(line, line.copy(), False)
    assert split_stroke(stroke, at, sizes)[0] == []


@seed(1)
@settings(max_examples=20, deadline=None, database=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["ball", "dome"]), st.booleans())
# A curve that ends a little beyond the plane, at a node with others.
@example(32768, "ball", False)
# A piece of two points between two crossings of the plane becomes a part of the seam.
@example(67535, "ball", False)
def test_random_strokes_keep_all_that_holds(number: int, name: str, tilted: bool) -> None:
    """Strokes before, on the half, off and on again: the invariants hold, and nothing is lost."""
    rng = np.random.default_rng(number)
    plane = TILTED if tilted else X
    at = half(name, plane)
    sizes = Sizes.of(at.whole.diagonal)
    whole = cut_half(at.whole, Plane((-9.0, 0.0, 0.0)))

    def scribble() -> SurfaceCurve:
        places = rng.normal(size=(rng.integers(2, 5), 3))
        if name == "dome":
            places[:, 2] = np.abs(places[:, 2]) + 0.1
        t = np.linspace(0.0, len(places) - 1.0, 60)
        line = np.stack([np.interp(t, np.arange(len(places)), places[:, d]) for d in range(3)], 1)
        line /= np.linalg.norm(line, axis=1)[:, None]
        # A closed one of two places would run back upon itself.
        return clean_stroke(line, at.whole, sizes, len(places) > 2 and bool(rng.integers(2)))

    network = empty(at.whole, sizes)
    for _ in range(2):
        network = insert_stroke_on_half(network, whole, sizes, scribble()).network
    network = begin_symmetry(network, at, sizes.sampling).network
    for _ in range(3):
        check_network(network)
        assert genus(network) == 0 and is_drawn_within(network)
        for chain in network.chains.values():
            height = plane.heights(chain.points)
            assert height.min() > -1e-9
            if SYMMETRY in chain.marks:
                assert abs(height).max() < 1e-12
        try:
            network = insert_stroke_on_half(network, at, sizes, scribble()).network
        except RefusedError:
            continue
    edit = end_symmetry(network, at.whole, sizes, plane)
    off = edit.network
    check_network(off, patches=False)
    assert genus(off) == 0
    assert network.chains.keys() <= off.chains.keys()
    if name == "ball":
        assert edit.notes == ()
        assert len(off.patches) == 2 * len(network.patches)
    back = begin_symmetry(off, at, sizes.sampling).network
    check_network(back, patches=False)
    if edit.notes:
        # The dome has no place for all images beyond a tilted plane.
        assert "left out" in edit.notes[0]
        return
    assert back.chains.keys() == network.chains.keys()
    assert all((back.chains[c].points == network.chains[c].points).all() for c in network.chains)


def test_no_curve_goes_beyond_the_seam_where_one_is_drawn_along_the_border() -> None:
    """A ring that lies on the border for a way, near the seam, and a cut through all of them:
    the cut went on behind the seam, and the patch's image did not close then."""
    steps = np.linspace(-1.0, 1.0, 41)
    x, y = (one.ravel() for one in np.meshgrid(steps, steps, indexing="ij"))
    first = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel()
    one, two = [first, first + 41, first + 42], [first, first + 42, first + 1]
    triangles = np.concatenate([np.stack(one, 1), np.stack(two, 1)])
    surface = Surface.from_arrays(np.stack([x, y, 0.0 * x], 1), triangles).orient()
    sizes = Sizes.of(surface.diagonal)
    plane = Plane.of((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    on_half = cut_half(surface, plane)
    network = begin_symmetry(empty(surface, sizes), on_half, sizes.sampling).network
    t = np.linspace(0.0, 2.0 * np.pi, 40)
    ring = np.stack([-0.82 - 0.23 * np.sin(t), 0.19 + 0.23 * np.cos(t), 0.0 * t], 1)
    ring[:, 0] = np.maximum(ring[:, 0], -1.0)
    network = insert_stroke_on_half(
        network, on_half, sizes, clean_stroke(ring, surface, sizes, None)
    ).network
    start = on_half.surface.nearest(np.array([[-0.75, 0.0, 0.0]]))
    network = cut_loop(network, on_half.surface, sizes, start, (-0.8, -0.59, 0.0)).network
    check_network(network)
    assert is_drawn_within(network)
    off = end_symmetry(network, surface, sizes, plane).network
    check_network(off)
    assert len(off.patches) == 2 * len(network.patches) > 0
