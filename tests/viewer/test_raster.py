"""Shapes as pixels: covers are exact areas; letters stand where their typeface says."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from viewer.lettering import EM, load_typeface, outline_text
from viewer.raster import Raster

BLACK = np.zeros(3)
WHITE = np.ones(3)


def cover_of(contours: list[NDArray[np.float64]], width: int, height: int) -> NDArray[np.float64]:
    """(h, w) the part of each pixel that a shape covers."""
    raster = Raster(width, height)
    raster.fill_contours(contours, BLACK)
    return 1.0 - raster.pixels[..., 0].astype(np.float64)


def measure_area(points: NDArray[np.float64]) -> float:
    x, y = points.T
    return abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2.0


place = st.floats(0.0, 12.0, allow_nan=False, width=32)
triangles = st.lists(st.tuples(place, place), min_size=3, max_size=3).map(np.array)


@given(triangles)
def test_a_triangle_covers_its_area(triangle: NDArray[np.float64]) -> None:
    cover = cover_of([triangle], 12, 12)
    assert cover.sum() == pytest.approx(measure_area(triangle), abs=1e-4)
    assert cover.min() >= 0.0 and cover.max() <= 1.0 + 1e-6


@given(triangles, st.floats(0.1, 0.9))
def test_parts_cover_what_the_whole_does(triangle: NDArray[np.float64], at: float) -> None:
    a, b, c = triangle
    m = b + at * (c - b)
    whole = cover_of([triangle], 12, 12)
    parts = cover_of([np.array([a, b, m])], 12, 12) + cover_of([np.array([a, m, c])], 12, 12)
    assert np.abs(whole - parts).max() < 1e-4


@settings(max_examples=30)
@given(triangles)
def test_a_cover_is_what_fine_samples_count(triangle: NDArray[np.float64]) -> None:
    n = 16
    at = (np.arange(12 * n) + 0.5) / n
    x, y = np.meshgrid(at, at)
    a, b, c = triangle
    side = [
        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))
    ]
    inside = np.all(np.array(side) > 0, axis=0) | np.all(np.array(side) < 0, axis=0)
    counted = inside.reshape(12, n, 12, n).mean(axis=(1, 3))
    # An edge is wrong by a sample in every row or column of samples that it crosses.
    assert np.abs(cover_of([triangle], 12, 12) - counted).max() < 3.0 / n


@given(st.tuples(st.floats(-20, 20), st.floats(-20, 20)))
def test_what_leaves_the_picture_is_cut_off(by: tuple[float, float]) -> None:
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]]) + by
    low, high = np.clip(square.min(0), 0, 8), np.clip(square.max(0), 0, 8)
    assert cover_of([square], 8, 8).sum() == pytest.approx(np.prod(high - low), abs=1e-3)


def test_a_hole_is_not_covered() -> None:
    square = np.array([[1.0, 1], [9, 1], [9, 9], [1, 9]])
    hole = np.array([[3.0, 3], [3, 6], [6, 6], [6, 3]])
    cover = cover_of([square, hole], 10, 10)
    assert cover.sum() == pytest.approx(64 - 9)
    assert (cover[3:6, 3:6] == 0.0).all()


def test_an_outline_is_as_wide_as_asked_and_painted_once() -> None:
    raster = Raster(40, 40)
    raster.outline(np.array([[[10.0, 10], [30, 10], [30, 30], [10, 30]]]), 4.0, BLACK)
    cover = 1.0 - raster.pixels[..., 0]
    assert cover[20, 8:12].tolist() == [1.0] * 4 and cover[20, [7, 12]].tolist() == [0.0, 0.0]
    # Corners are round: between a square corner and none.
    assert 0.0 < cover[8, 8] < 1.0
    # A quarter of a joint, a polygon of 12 corners, is at each: 12-gons have the area 3 r^2.
    assert cover.sum() == pytest.approx(24.0**2 - 16.0**2 - 4 * (2.0**2 - 3.0 * 2.0**2 / 4))


def test_later_shapes_are_painted_over_earlier() -> None:
    raster = Raster(6, 6)
    square = np.array([[0.0, 0], [6, 0], [6, 6], [0, 6]])
    raster.fill(np.array([square, square / 2.0]), np.array([BLACK, [1.0, 0.0, 0.0]]))
    assert raster.pixels[0, 0].tolist() == [1.0, 0.0, 0.0]
    assert raster.pixels[5, 5].tolist() == [0.0, 0.0, 0.0]


def test_a_png_reads_back_as_it_was() -> None:
    image = pytest.importorskip("matplotlib.image")
    raster = Raster(7, 5)
    raster.pixels[:] = np.random.default_rng(3).random((5, 7, 3), np.float32)
    read = image.imread(io.BytesIO(raster.encode_png(160)))
    assert read.shape == (5, 7, 3)
    assert np.abs(read - raster.pixels).max() <= 0.5 / 255 + 1e-6


@pytest.mark.parametrize("mono", [False, True])
@pytest.mark.parametrize("bold", [False, True])
def test_a_line_is_as_wide_as_its_letters(bold: bool, mono: bool) -> None:
    face = load_typeface(bold=bold, mono=mono)
    assert (np.diff(face.characters) > 0).all()
    contours, width = outline_text("Äb ×→", 20.0, bold=bold, mono=mono)
    assert width == pytest.approx(
        sum(outline_text(c, 20.0, bold=bold, mono=mono)[1] for c in "Äb ×→")
    )
    if mono:
        assert width == pytest.approx(5 * 20.0 * 1233 / EM)
    # Letters reach from below the line to the ascent, and none is left of the line.
    places = np.concatenate(contours)
    assert places[:, 0].min() > -2.0 and places[:, 0].max() < width + 2.0
    assert 13.0 < places[:, 1].max() < 20.0


def test_letters_that_are_not_there_are_boxes() -> None:
    assert load_typeface(bold=False, mono=False).find_letters("a☃").tolist()[1] == 0
    box, _ = outline_text("☃", 10.0)
    assert box and np.array_equal(np.concatenate(box), np.concatenate(outline_text("中", 10.0)[0]))


def test_the_counter_of_a_letter_is_open() -> None:
    contours, width = outline_text("o", 100.0)
    cover = cover_of([c * (1.0, -1.0) + (0.0, 100.0) for c in contours], 64, 104)
    middle = cover[100 - 27, round(width / 2)]
    assert middle == 0.0 and cover.sum() > 500
