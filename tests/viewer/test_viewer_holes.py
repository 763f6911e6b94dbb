"""Pictures of holes: triangles cut off at a panel's edge, the same bytes again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shared import CHECKOUT

from ingest.formats import read_mesh
from query.engine import PatternSource
from query.holes import fill_holes
from viewer.holes import _cut_triangles, choose_view, draw_holes, draw_panels, show_fills
from viewer.paper import PictureFormatError


def area(corners: np.ndarray) -> float:
    a, b = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    return float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)


@given(st.integers(0, 10_000), st.sampled_from([0, 1]))
def test_cut_triangles_keep_their_area_and_colours(seed: int, axis: int) -> None:
    draw = np.random.default_rng(seed)
    corners = draw.normal(size=(20, 3, 3))
    # Colours that are linear in the place stay so on what is cut off.
    colours = corners.astype(np.float32)
    one = _cut_triangles((corners, colours), axis, 0.2, 1.0)
    other = _cut_triangles((corners, colours), axis, 0.2, -1.0)
    assert (one[0][..., axis] >= 0.2 - 1e-9).all() and (other[0][..., axis] <= 0.2 + 1e-9).all()
    assert np.isclose(area(one[0]) + area(other[0]), area(corners))
    for cut, painted in (one, other):
        assert np.allclose(cut, painted, atol=1e-4)


def test_a_picture_before_and_after(source: PatternSource, tmp_path: Path) -> None:
    mesh = read_mesh(CHECKOUT / "docs" / "meshes" / "head.obj")
    fills = list(fill_holes(source, mesh, loop=[36], limit=3))
    one = draw_holes(tmp_path / "a.png", fills[:1], height=300).read_bytes()
    assert (
        one.startswith(b"\x89PNG")
        and one == draw_holes(tmp_path / "b.png", fills[:1], 300).read_bytes()
    )
    panels = [show_fills([fill], f"{number}") for number, fill in enumerate(fills)]
    assert draw_panels(tmp_path / "c.png", panels, choose_view(fills[:1]), 2, 400).exists()
    with pytest.raises(PictureFormatError):
        draw_holes(tmp_path / "a.svg", fills[:1])
