"""Pictures of holes: the same bytes again."""

from __future__ import annotations

from pathlib import Path

import pytest
from shared import CHECKOUT

from ingest.formats import read_mesh
from query.engine import PatternSource
from query.holes import fill_holes
from viewer.holes import choose_view, draw_holes, draw_panels, show_fills
from viewer.paper import PictureFormatError


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
