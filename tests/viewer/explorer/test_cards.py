"""Cards of fills: one outline for all fills of a boundary, strokes marked, valences told apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import query
from patterndb.geometry.embedding import find_flipped_quads
from query import Boundary, Fill, Stroke
from query.boundary import CornerKind
from query.placing import find_loops, find_strand
from tests.support.viewer.domed import SOURCE
from viewer import save_gallery, style
from viewer.drawing import draw_disk
from viewer.fillcard import make_fill_card

KINDS: tuple[CornerKind, ...] = ("convex", "convex", "convex", "reflex", "convex", "convex")


def test_fills_of_a_boundary_with_reflex_corners_have_one_outline() -> None:
    boundary = Boundary((4, 2, 3, 3, 2, 2), KINDS)
    found = list(query.fills(SOURCE, boundary, limit=12, per_pattern=1))
    cards = [make_fill_card(fill, boundary) for fill in found]
    drawings = [draw_disk(card.disk, points=card.points) for card in cards]
    rims = [drawing.points[: drawing.perimeter] for drawing in drawings]
    assert len(rims) > 5
    for rim in rims:
        assert np.abs(rim - rims[0]).max() < 1e-9
    for drawing in drawings:
        assert not find_flipped_quads(drawing.quads, drawing.points).any()


def _count_off(fill: Fill, way: list[list[int]], ends: list[tuple[int, int]]) -> int:
    """By how many edges boundary edges, as pairs of vertices, miss those asked for; 99 for each
    on another side."""
    starts = np.r_[0, np.cumsum(fill.lengths)].tolist()
    off = 0
    for edge, (side, at) in zip(way, ends, strict=True):
        first = [starts[side] + k for k in range(fill.lengths[side])]
        near = [
            abs(v - starts[side] - at) for v in first if {v, (v + 1) % fill.perimeter} == {*edge}
        ]
        off += near[0] if near else 99
    return off


@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_a_stroke_is_marked_with_its_own_strand(data: st.DataObject) -> None:
    """The edges asked for, and a strand that ends within the tolerance of them."""
    boundary = Boundary((4, 3, 5, 4))
    edges = [(side, edge) for side, n in enumerate(boundary.lengths) for edge in range(n)]
    ends = data.draw(st.lists(st.sampled_from(edges), min_size=2, max_size=2, unique=True))
    tolerance = data.draw(st.integers(0, 1))
    strokes = [Stroke(*ends), *([Stroke.loop()] if data.draw(st.booleans(), "loop") else [])]
    found = query.fills(SOURCE, boundary, strokes=strokes, tolerance=tolerance, limit=8)
    for fill in found:
        mark, *loops = make_fill_card(fill, boundary, strokes, tolerance).marks
        starts = boundary.side_starts
        asked = [starts[side] + edge for side, edge in ends]
        assert mark.ends.tolist() == [[at, (at + 1) % fill.perimeter] for at in asked]
        ways = (mark.edges[[0, -1]].tolist(), mark.edges[[-1, 0]].tolist())
        assert min(_count_off(fill, way, ends) for way in ways) == fill.flow_distance
        rings = [{tuple(sorted(e)) for e in ring.edges.tolist()} for ring in find_loops(fill)]
        for loop in loops:
            assert len(loop.ends) == 0
            assert (loop.edges[0] == loop.edges[-1]).all()
            assert {tuple(sorted(e)) for e in loop.edges.tolist()} in rings


def test_marks_are_painted_in_the_stroke_s_colour(tmp_path: Path) -> None:
    boundary, stroke = Boundary((4, 3, 4, 3)), Stroke((0, 1), (2, 2))
    fill = query.best(SOURCE, boundary, strokes=[stroke], tolerance=0)
    assert fill is not None
    assert find_strand(fill, (0, 1)).ends == ((0, 1), (2, 2))
    plain, marked = tmp_path / "plain.svg", tmp_path / "marked.svg"
    save_gallery(plain, [make_fill_card(fill, boundary)])
    save_gallery(marked, [make_fill_card(fill, boundary, [stroke])])
    assert style.STROKE not in plain.read_text()
    assert style.STROKE in marked.read_text() and ">stroke<" in marked.read_text()


#: Of irregular vertices.
VALENCES = [2, 3, *range(5, 16)]


@pytest.mark.parametrize("valence", VALENCES)
def test_valences_are_told_apart(valence: int) -> None:
    """By colour up to 12, and by their markers' outlines always."""
    shape, colour = style.choose_valence_shape(valence), style.choose_valence_colour(valence)
    for other in set(VALENCES) - {valence}:
        assert not np.array_equal(shape, style.choose_valence_shape(other))
        if other <= 12 and valence <= 12:
            assert colour != style.choose_valence_colour(other)
