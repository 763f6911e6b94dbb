"""Pictures made of pixels: shapes painted over each other, their edges smooth, and PNG files.

A pixel takes of a shape's colour what part of it the shape covers, computed exactly from the edges:
each adds its signed area to the pixels that it crosses, and the sum from the left is the cover.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb._native.viewer.raster import paint_shapes
from patterndb.geometry.points import Points
from viewer import style

#: Corners of the disc that rounds a line's joint.
ROUND = 12

#: zlib's level: beyond it files of flat colours shrink no more.
COMPRESSION = 6


class Raster:
    """A blank picture of (height, width) pixels; places are pixels from the upper left, y down."""

    def __init__(self, width: int, height: int) -> None:
        self.pixels = np.empty((height, width, 3), np.float32)
        self.pixels[:] = style.parse_colour(style.PAPER)

    def fill(self, corners: Points, colours: NDArray[np.float64]) -> None:
        """Fill (n, c, 2) polygons in order with (n, 3) colours."""
        n, c = corners.shape[:2]
        contours = np.arange(n + 1) * c
        self._paint(corners.reshape(-1, 2), contours, np.arange(n + 1), colours)

    def outline(self, corners: Points, width: float, colour: NDArray[np.float64]) -> None:
        """Draw the outlines of (n, c, 2) polygons, so many pixels wide, with round joints."""
        n, c = corners.shape[:2]
        ahead = np.roll(corners, -1, axis=1) - corners
        lengths = np.linalg.norm(ahead, axis=2, keepdims=True)
        aside = np.divide(
            ahead[..., ::-1] * (-1.0, 1.0),
            lengths,
            out=np.zeros_like(ahead),
            where=lengths > 0.0,
        ) * (width / 2.0)
        ends = np.stack([corners, corners + ahead], axis=2)
        bars = np.concatenate([ends - aside[:, :, None], ends[:, :, ::-1] + aside[:, :, None]], 2)
        angles = np.arange(ROUND) * (2.0 * math.pi / ROUND)
        disc = np.stack([np.cos(angles), np.sin(angles)], axis=1) * (width / 2.0)
        joints = corners[:, :, None] + disc
        # A polygon's bars and joints are contours of one shape: nothing is painted twice.
        points = np.concatenate(
            [bars.reshape(n, 4 * c, 2), joints.reshape(n, ROUND * c, 2)], axis=1
        )
        sizes = np.tile(np.repeat([4, ROUND], c), n)
        contours = np.concatenate([[0], np.cumsum(sizes)])
        self._paint(
            points.reshape(-1, 2),
            contours,
            np.arange(n + 1) * 2 * c,
            np.broadcast_to(colour, (n, 3)),
        )

    def fill_contours(self, contours: Sequence[Points], colour: NDArray[np.float64]) -> None:
        """Fill one shape of several contours, holes the other way round."""
        if contours:
            starts = np.concatenate([[0], np.cumsum([len(contour) for contour in contours])])
            shape = np.array([0, len(contours)])
            self._paint(np.concatenate(contours), starts, shape, colour[None])

    def _paint(
        self,
        points: Points,
        contours: NDArray[np.int64],
        shapes: NDArray[np.int64],
        colours: NDArray[np.float64],
    ) -> None:
        paint_shapes(
            self.pixels,
            np.ascontiguousarray(points, np.float64),
            contours.astype(np.int64),
            shapes.astype(np.int64),
            np.ascontiguousarray(colours, np.float32),
        )

    def encode_png(self, dpi: float) -> bytes:
        """Encode the picture as the bytes of a PNG file; the same picture gives the same bytes."""
        height, width = self.pixels.shape[:2]
        whole = np.round(self.pixels * 255.0).astype(np.uint8).reshape(height, 3 * width)
        # Every row is kept as its difference to the one above, which is mostly nothing.
        rows = np.empty((height, 1 + 3 * width), np.uint8)
        rows[:, 0] = 2
        rows[0, 1:] = whole[0]
        rows[1:, 1:] = whole[1:] - whole[:-1]
        per_metre = round(dpi / 0.0254)
        return b"".join(
            (
                b"\x89PNG\r\n\x1a\n",
                _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
                _chunk(b"pHYs", struct.pack(">IIB", per_metre, per_metre, 1)),
                _chunk(b"IDAT", zlib.compress(rows.tobytes(), COMPRESSION)),
                _chunk(b"IEND", b""),
            )
        )


def _chunk(kind: bytes, content: bytes) -> bytes:
    check = zlib.crc32(kind + content)
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)
