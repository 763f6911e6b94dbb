"""Pictures of holes: the same bytes again, holes in sight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from query.engine import PatternSource
from query.holes import HoleFill, fill_holes
from tests.support.shared import CHECKOUT
from viewer.holes import (
    choose_view,
    draw_holes,
    draw_panels,
    find_front,
    show_fills,
    show_holes,
)
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


def box(size: float, n: int, without: tuple[int, ...] = ()) -> tuple[np.ndarray, np.ndarray]:
    """A box around 0 of n x n quads a side, sides in order -x, +x, -y, +y, -z, +z: the sides
    ``without`` left out."""
    ticks = np.linspace(-size, size, n + 1)
    u, v = np.meshgrid(ticks, ticks, indexing="ij")
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    first = (i * (n + 1) + j).ravel()
    cells = np.stack([first, first + n + 1, first + n + 2, first + 1], axis=1)
    points, faces = [], []
    for side in range(6):
        if side in without:
            continue
        axis, sign = side // 2, 2.0 * (side % 2) - 1.0
        place = np.full((3, *u.shape), sign * size)
        place[(axis + 1) % 3], place[(axis + 2) % 3] = u, v
        faces.append((cells if sign > 0 else cells[:, ::-1]) + len(points) * (n + 1) ** 2)
        points.append(place.reshape(3, -1).T)
    welded, number = np.unique(np.concatenate(points).round(9), axis=0, return_inverse=True)
    return welded, number.ravel()[np.concatenate(faces)]


def fill_within(source: PatternSource, without: tuple[int, ...]) -> HoleFill:
    """Fill what was taken from the top of a box that lies within another one."""
    (inner, quads), (outer, shell) = box(0.3, 4), box(1.0, 5, without)
    faces = np.concatenate([quads, shell + len(inner)])
    mesh = PolygonMesh.from_faces(np.concatenate([inner, outer]), faces)
    top = np.flatnonzero((inner[quads][..., 2] > 0.29).all(axis=1))
    return next(fill_holes(source, mesh, faces=top.reshape(4, 4)[1:3, 1:3].ravel().tolist()))


def share_of_colour(path: Path, column: int) -> float:
    """How much of one of two pictures side by side has the colour of what is made anew."""
    picture = pytest.importorskip("matplotlib.image").imread(path)
    half = np.array_split(picture, 2, axis=1)[column]
    red, blue = half[..., 0], half[..., 2]
    return float((blue - red > 0.1 if column else red - blue > 0.1).mean())


def test_a_hole_is_looked_at_through_an_opening(source: PatternSource, tmp_path: Path) -> None:
    fill = fill_within(source, (1,))
    view = choose_view([fill])
    assert view.axes[2][0] > 0.3, "from where the shell is open"
    assert view.axes[2][2] > 0.1, "and the top is seen"
    assert not find_front([fill], view).any()
    path = draw_holes(tmp_path / "open.png", [fill], 300)
    assert min(share_of_colour(path, 0), share_of_colour(path, 1)) > 0.01


def test_what_hides_a_hole_from_everywhere_is_left_out(
    source: PatternSource, tmp_path: Path
) -> None:
    fill = fill_within(source, ())
    view = choose_view([fill])
    front = find_front([fill], view)
    mesh = fill.hole.topology.mesh
    far = np.abs(mesh.points[mesh.corners.reshape(-1, 4)]).max(axis=(1, 2)) > 0.9
    assert front.any() and not front[~far].any(), "of the shell alone"
    assert front.sum() < far.sum() / 2, "and not all of it"
    for number, left_out in enumerate((None, front)):
        panels = [show_holes([fill], "", left_out), show_fills([fill], "", left_out)]
        path = draw_panels(tmp_path / f"{number}.png", panels, view, 2, 300)
        for column in (0, 1):
            share = share_of_colour(path, column)
            assert share == 0.0 if left_out is None else share > 0.01
    # As the command draws it.
    assert share_of_colour(draw_holes(tmp_path / "shut.png", [fill], 300), 1) > 0.01
