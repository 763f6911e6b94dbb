"""Pictures of slices: rendering, dilation, erosion that keeps topology, and outer contours."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from patterndb._native.features.ribs.raster import (
    close_gaps,
    dilate,
    erode,
    find_outer_contour,
    read_ring,
    render_edges,
)
from patterndb._native.features.ribs.rib import count_rounds
from patterndb.geometry.points import Bools
from patterndb_sketch.features.ribs import MARGIN

SQUARE = np.ones((3, 3), bool)


def may_go(ring: int) -> bool:
    """May a pixel go whose neighbours, counter-clockwise from the right, are these bits?

    Yes if the ring switches once each way, and one of the four that share a side is background.
    """
    bits = [(ring >> k) & 1 for k in range(8)]
    switches = sum(bits[k] != bits[(k + 1) % 8] for k in range(8))
    return switches == 2 and not all(bits[::2])


def packed(bits: Bools) -> NDArray[np.uint64]:
    """(rows, columns) cells of a picture (8 rows, 8 columns) of bools, row by row."""
    rows, columns = bits.shape[0] // 8, bits.shape[1] // 8
    cells = bits.reshape(rows, 8, columns, 8).transpose(0, 2, 1, 3).reshape(rows, columns, 64)
    return (cells.astype(np.uint64) << np.arange(64, dtype=np.uint64)).sum(axis=2, dtype=np.uint64)


def unpacked(picture: NDArray[np.uint64]) -> Bools:
    bits = (picture[..., None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    rows, columns = picture.shape
    whole = bits.reshape(rows, columns, 8, 8).transpose(0, 2, 1, 3)
    return whole.reshape(8 * rows, 8 * columns).astype(bool)


def scribble(seed: int, rows: int = 5, columns: int = 6, margin: int = 8) -> Bools:
    """Lines, dots and blots with a free margin."""
    rng = np.random.default_rng(seed)
    bits = np.zeros((8 * rows, 8 * columns), bool)
    inner = bits[margin:-margin, margin:-margin]
    for _ in range(rng.integers(1, 6)):
        (y, x), (dy, dx) = rng.integers(0, inner.shape), rng.integers(-1, 2, 2)
        for _ in range(rng.integers(1, 25)):
            if 0 <= y < inner.shape[0] and 0 <= x < inner.shape[1]:
                inner[y, x] = True
            y, x = y + dy, x + dx
    inner |= rng.random(inner.shape) < rng.choice([0.0, 0.02, 0.3])
    return bits


def labelled(bits: Bools, structure: Bools | None = None) -> tuple[NDArray[np.int32], int]:
    """The parts of a picture, and how many they are."""
    parts = np.zeros(bits.shape, np.int32)
    count = ndimage.label(bits, structure, parts)
    assert isinstance(count, int)
    return parts, count


def parts_and_holes(bits: Bools) -> tuple[int, int]:
    """Corners join what is set, sides what is not."""
    return labelled(bits, SQUARE)[1], labelled(~bits)[1]


def slowly_eroded(bits: Bools, first: Bools) -> Bools:
    """The rule pixel by pixel: not set at first, one switch each way around, and background at
    one of the four sides; of the layer that dilation would have added, sides before corners."""
    bits, first = np.pad(bits, 1).astype(bool), np.pad(first, 1).astype(bool)
    layer: Bools = bits & ~np.asarray(ndimage.binary_erosion(bits, SQUARE), bool) & ~first
    around = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
    # Cell by cell, row by row in each.
    order = sorted(
        zip(*np.nonzero(layer), strict=True),
        key=lambda p: ((p[0] - 1) // 8, (p[1] - 1) // 8, (p[0] - 1) % 8, (p[1] - 1) % 8),
    )
    for _ in range(2):
        for y, x in order:
            near = [bits[y + dy, x + dx] for dy, dx in around]
            up = sum(not a and b for a, b in zip(near, near[1:] + near[:1], strict=True))
            if bits[y, x] and up == 1 and not all(near[::2]):
                bits[y, x] = False
    return bits[1:-1, 1:-1]


class TestErosion:
    @settings(max_examples=80)
    @given(st.integers(0, 2**32), st.integers(1, 4))
    def test_parts_and_holes_are_unchanged_by_erosion(self, seed: int, rounds: int) -> None:
        """The number of parts and of holes; and no pixel goes that was set at first."""
        bits = scribble(seed)
        first = packed(bits)
        wide = first
        for _ in range(rounds):
            wide = dilate(wide)
        before = unpacked(wide)
        assert (before == ndimage.binary_dilation(bits, SQUARE, rounds)).all()
        for _ in range(rounds):
            erode(wide, first)
            after = unpacked(wide)
            assert parts_and_holes(after) == parts_and_holes(before)
            assert (after <= before).all() and (bits <= after).all()

    @settings(max_examples=30)
    @given(st.integers(0, 2**32))
    def test_against_the_rule_pixel_by_pixel(self, seed: int) -> None:
        bits = scribble(seed)
        wide = dilate(packed(bits))
        slow = slowly_eroded(unpacked(wide), bits)
        erode(wide, packed(bits))
        assert (unpacked(wide) == slow).all()

    @settings(max_examples=30)
    @given(st.integers(0, 2**32))
    def test_rings_are_the_eight_neighbours(self, seed: int) -> None:
        bits = np.random.default_rng(seed).random((16, 24)) < 0.5
        picture, wide = packed(bits), np.pad(bits, 1)
        for y, x in np.ndindex(*bits.shape):
            around = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
            wanted = [wide[y + 1 + dy, x + 1 + dx] for dy, dx in around]
            assert [bool(read_ring(picture, x, y) >> k & 1) for k in range(8)] == wanted

    def test_interior_pixels_stay(self) -> None:
        """The rule as printed, at most one switch each way, would hollow out a blot."""
        assert not may_go(0b11111111) and not may_go(0)
        bits = np.zeros((40, 40), bool)
        bits[15, 15] = True
        wide = np.zeros_like(bits)
        wide[10:25, 10:25] = True
        result = packed(wide)
        erode(result, packed(bits))
        inner = np.zeros_like(bits)
        inner[11:24, 11:24] = True
        assert (unpacked(result) == inner).all()

    def test_lone_lines_come_back_as_they_were(self) -> None:
        """What dilation adds to a line, erosion takes off again, whatever its direction."""
        for way in np.linspace(0, np.pi, 25):
            ends = np.array([[100.0, 100.0], [100 + 70 * np.cos(way), 100 + 70 * np.sin(way)]])
            picture = render_edges(ends, np.zeros(1, np.int32), 25, 25)[0]
            for rounds in (1, 4, 9):
                added = unpacked(close_gaps(picture, rounds)) & ~unpacked(picture)
                # Inner corners of the line's stairs are all that may be left.
                assert not (added & ~ndimage.binary_closing(unpacked(picture), SQUARE, 2)).any()


class TestGaps:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32))
    def test_gaps_are_closed_by_as_many_rounds_as_they_ask_for(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        gap, way, turn = rng.uniform(0.0, 20.0), *rng.uniform(0, 2 * np.pi, 2)
        at = 100.0 + rng.uniform(0, 1, 2)
        other = at + gap * np.array([np.cos(way), np.sin(way)])
        # The second line leads away from the first one's end.
        points = np.array([
            at, at - 30.0 * np.array([np.cos(way), np.sin(way)]),
            other, other + 30.0 * np.array([np.cos(way + turn / 7), np.sin(way + turn / 7)]),
        ])  # fmt: skip
        picture = render_edges(points, np.array([0, 2], np.int32), 25, 25)[0]
        rounds = count_rounds(gap, 1.0)
        assert 1 <= rounds < MARGIN
        assert labelled(unpacked(close_gaps(picture, rounds)), SQUARE)[1] == 1


class TestRendering:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32))
    def test_the_pixels_that_edges_pass_through(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        points = rng.uniform(2.0, 38.0, (4, 2))
        first = np.array([0, 1, 2], np.int32)
        picture, head, edge, link = render_edges(points, first, 5, 5)
        wanted = np.zeros((40, 40), bool)
        cells = {(e, c): False for e in range(3) for c in range(25)}
        for e in range(3):
            share = np.linspace(0, 1, 20_001)[:, None]
            x, y = (points[e] + share * (points[e + 1] - points[e])).astype(int).T
            wanted[y, x] = True
            for cell in np.unique(y // 8 * 5 + x // 8):
                cells[e, int(cell)] = True
        drawn = unpacked(picture)
        assert (wanted <= drawn).all()
        # A corner cut by less than the steps above may be missed there, never a whole pixel.
        assert (drawn & ~wanted).sum() <= 6
        for cell in range(25):
            k, found = head[cell], set()
            while k >= 0:
                found.add(int(edge[k]))
                k = link[k]
            assert {e for e in range(3) if cells[e, cell]} <= found


class TestContours:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32))
    def test_the_border_of_the_nearest_part(self, seed: int) -> None:
        """All pixels at a side of the outside, none that the outside does not touch."""
        bits = scribble(seed)
        bits[20, 20] = True
        label, count = labelled(bits, SQUARE)
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(8, 40, 2)
        border = find_outer_contour(packed(bits), x, y)
        names = np.unique(label[border[:, 1], border[:, 0]])
        assert len(names) == 1
        part = label == names[0]
        outside = labelled(~part)[0]
        outside = outside == outside[0, 0]
        traced = np.zeros_like(bits)
        traced[border[:, 1], border[:, 0]] = True
        assert (traced >= (part & ndimage.binary_dilation(outside))).all()
        assert (traced <= (part & ndimage.binary_dilation(outside, SQUARE))).all()
        steps = np.abs(np.diff(np.r_[border, border[:1]], axis=0)).max(axis=1)
        assert (steps == 1).all() or len(border) == 1
        away = [
            np.hypot(*(np.argwhere(label == k + 1)[:, ::-1] + 0.5 - [x, y]).T).min()
            for k in range(count)
        ]
        # Within a hole of a part the nearest contour may be that of another.
        reached = np.hypot(*(border + 0.5 - [x, y]).T).min()
        assert reached >= min(away) - 1e-9
        if not part_around(bits, x, y):
            assert reached == min(away)


def part_around(bits: Bools, x: float, y: float) -> bool:
    """Is the place set, or in a hole?"""
    return bool(np.asarray(ndimage.binary_fill_holes(bits))[int(y), int(x)])
