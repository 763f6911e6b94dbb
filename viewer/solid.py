"""Shaded triangles of a picture: a surface, and a fill on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.viewer.solid import fill_triangles
from patterndb.geometry.points import Points
from query.placing import Surface
from viewer import style
from viewer.camera import View
from viewer.net import Net
from viewer.style import make_circle, parse_colour

# Curves as bands of triangles that face the viewer, shaded as if they were round.

Grid = NDArray[np.float32]

Triangles = tuple[Points, Grid]

#: Mitres longer than so many half widths are cut: there the curve turns back.
LONGEST_MITRE = 1.6

#: How bright a band's rim is, its middle being 1 and lighter than the colour by GLOSS of white.
#: Bands narrower than ROUND points are of one colour.
RIM, GLOSS, ROUND = 0.72, 0.2, 2.5

NOTHING: Triangles = (np.zeros((0, 3, 3)), np.zeros((0, 3, 3), np.float32))


def make_ribbons(lines: Sequence[Points], colour: str, width: float, lift: float) -> Triangles:
    """Make bands along polylines (k, 3) as they are seen, ``width`` points wide.

    lift: how much nearer to the viewer they are than what they lie on, in points.
    """
    kept = [line for line in lines if len(line) > 1]
    if not kept:
        return NOTHING
    points = np.concatenate(kept)
    starts = np.cumsum([0, *(len(line) for line in kept)])
    joined = np.ones(len(points) - 1, np.bool_)
    joined[starts[1:-1] - 1] = False
    across = _across(points[:, :2], joined) * (width / 2.0)
    raised = points + np.array([0.0, 0.0, lift])
    side = np.concatenate([across, np.zeros((len(across), 1))], axis=1)
    # Nearer in the middle: where bands cross, the crossing looks round, too.
    rows = np.stack(
        [raised - side, raised + np.array([0.0, 0.0, width / 4.0]), raised + side], axis=1
    )
    a, b = rows[:-1][joined], rows[1:][joined]
    base = parse_colour(colour)
    rim = middle = base
    if width >= ROUND:
        rim, middle = base * RIM, base * (1.0 - GLOSS) + GLOSS
    shades = [rim, middle, rim]
    corners: list[Points] = []
    colours: list[Points] = []
    for i, j in ((0, 1), (1, 2)):
        corners += [
            np.stack([a[:, i], a[:, j], b[:, j]], axis=1),
            np.stack([a[:, i], b[:, j], b[:, i]], axis=1),
        ]
        colours += [
            np.stack([shades[i], shades[j], shades[j]]),
            np.stack([shades[i], shades[j], shades[i]]),
        ]
    n = len(a)
    painted = np.concatenate([np.broadcast_to(shade, (n, 3, 3)) for shade in colours])
    return np.concatenate(corners), painted.astype(np.float32)


def make_discs(
    places: Points, colour: str, radius: float, lift: float, inner: float = 0.0
) -> Triangles:
    """Make discs at places (n, 3) as they are seen, or rings with an inner radius."""
    if not len(places):
        return NOTHING
    rim = make_circle()
    after = np.roll(rim, -1, axis=0)
    zero = np.zeros((len(rim), 1))
    outer = [np.hstack([ends * radius, zero]) for ends in (rim, after)]
    within = [np.hstack([ends * inner, zero]) for ends in (rim, after)]
    fan = np.stack([within[0], outer[0], outer[1]], axis=1)
    if inner > 0.0:
        fan = np.concatenate([fan, np.stack([within[0], outer[1], within[1]], axis=1)])
    corners = (places + np.array([0.0, 0.0, lift]))[:, None, None] + fan
    flat = np.broadcast_to(parse_colour(colour), (len(places) * len(fan), 3, 3))
    return corners.reshape(-1, 3, 3), flat.astype(np.float32)


def dash_line(line: Points, dash: float) -> list[Points]:
    """Cut a polyline (k, 3) as it is seen into dashes of so many points with gaps as long."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1))]
    if along[-1] <= dash:
        return [line]
    count = max(1, round(along[-1] / (2.0 * dash)))
    step = along[-1] / count
    dashes: list[Points] = []
    for k in range(count):
        first, last = k * step, (k + 0.55) * step
        inner = along[(along > first) & (along < last)]
        at = np.r_[first, inner, last]
        dashes.append(np.stack([np.interp(at, along, line[:, c]) for c in range(3)], axis=1))
    return dashes


def _across(flat: Points, joined: NDArray[np.bool_]) -> Points:
    """(k, 2) to the left of lines at each of their points, as long as a mitre wants."""
    step = np.diff(flat, axis=0)
    size = np.linalg.norm(step, axis=1, keepdims=True)
    step = np.where(joined[:, None] & (size > 0.0), step / np.where(size > 0.0, size, 1.0), 0.0)
    before = np.vstack([np.zeros((1, 2)), step])
    after = np.vstack([step, np.zeros((1, 2))])
    total = before + after
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # Where a line turns right back, its own last direction is as good as any.
    total = np.where(length > 1e-6, total / np.where(length > 1e-6, length, 1.0), before)
    own = np.where(np.abs(after).sum(axis=1, keepdims=True) > 0.0, after, before)
    cosine = np.abs((total * own).sum(axis=1, keepdims=True))
    mitre = np.minimum(1.0 / np.maximum(cosine, 1e-6), LONGEST_MITRE)
    return np.stack([-total[:, 1], total[:, 0]], axis=1) * mitre


# Which triangle is seen at every pixel: a depth buffer without OpenGL.


def spread_farthest(depth: Grid) -> Grid:
    """Find (h, w) the least depth in the 3 x 3 pixels around: what lines beside ridges are held
    to."""
    padded = np.pad(depth, 1, mode="edge")
    rows = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    return np.minimum(np.minimum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])


SURFACE = "#c3ccd6"
SURFACE_BACK = "#97a2ae"
FILL = "#fff8ea"
FILL_BACK = "#d6ccb6"
CARRIED = "#ffcb80"
FORMER = "#cfd3d8"

#: Where the light comes from, seen by the viewer; how bright is what it does not reach, of a
#: surface and of a fill, whose lines must stand out; and how much it brightens: what faces the
#: viewer is as good as fully lit.
LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
SHADE = 0.62
FILL_SHADE = 0.78
LIT = 1.15

#: A fill's pieces cut through the surface's triangles: it is painted nearer by this part of an
#: edge, and by so many points at least.
LIFT = (0.12, 2.0)

#: What lies so far behind the nearest thing around, in lifts, is hidden.
HIDDEN = 2.5

#: Points to a pixel of the buffer that says what is hidden.
COARSE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Triangles as they are seen.

    corners: (t, 3, 3) float64 x, y in points from the picture's lower left, and nearness.
    colours: (t, 3, 3) float32, 0 to 1, of the corners.
    lift:    points by which the fill is nearer than it is.
    ground:  the first of them, or none; the same arrays as long as they stay as they are, so that
             who shows them need not look.
    """

    corners: Points
    colours: Grid
    lift: float
    ground: Triangles = NOTHING

    @classmethod
    def of(
        cls,
        view: View,
        middle: tuple[float, float],
        surface: Surface | None,
        net: Net | None,
        *,
        faded: bool = False,
    ) -> Solid:
        """A surface and a fill, either of which may be missing; middle: of the view. faded: the
        fill is one of before, in grey."""
        corners: list[Points] = [np.zeros((0, 3, 3))]
        colours: list[Grid] = [np.zeros((0, 3, 3), np.float32)]
        shift = np.array([*middle, 0.0])
        lift = LIFT[1]
        if surface is not None:
            seen = (view.seen(surface.vertices) + shift)[surface.triangles]
            normals = (surface.normals @ view.axes.T)[surface.triangles]
            corners.append(seen)
            base, back = style.parse_colour(SURFACE), style.parse_colour(SURFACE_BACK)
            colours.append(shade_triangles(seen, normals, base, back, SHADE))
        if net is not None:
            lift = max(LIFT[0] * net.edge * view.scale, LIFT[1])
            seen = _triangles(view.seen(net.patches) + shift + (0.0, 0.0, lift))
            normals = _triangles(net.normals @ view.axes.T)
            base = np.tile(style.parse_colour(FILL), (len(net.patches), 1))
            base[net.carried] = style.parse_colour(CARRIED)
            if faded:
                base[:] = style.parse_colour(FORMER)
            each = np.repeat(base, len(seen) // max(len(net.patches), 1), axis=0)
            corners.append(seen)
            colours.append(
                shade_triangles(
                    seen, normals, each[:, None], style.parse_colour(FILL_BACK), FILL_SHADE
                )
            )
        return cls(np.concatenate(corners), np.concatenate(colours), lift)

    def image(self, width: float, height: float, scale: float) -> tuple[Grid, Grid]:
        """Painted on white: (h, w, 3) float32 colours and (h, w) nearness, -inf where nothing
        is. width, height: in points; scale: pixels to a point."""
        rows, columns = round(height * scale), round(width * scale)
        depth = np.full((rows, columns), -np.inf, np.float32)
        image = np.tile(style.parse_colour(style.PAPER).astype(np.float32), (rows, columns, 1))
        pixels = np.ascontiguousarray(self.corners * (scale, -scale, 1.0) + (0.0, rows, 0.0))
        fill_triangles(pixels, np.ascontiguousarray(self.colours), depth, image)
        return image, depth


class Hiding:
    """What of a picture is hidden behind a solid."""

    def __init__(self, solid: Solid, width: float, height: float) -> None:
        depth = solid.image(width, height, 1.0 / COARSE)[1]
        self._nearest = spread_farthest(depth)
        self._slack = HIDDEN * solid.lift

    def visible(self, points: Points) -> NDArray[np.bool_]:
        """(...) which of (..., 3) seen points are not hidden, and within the picture."""
        rows, columns = self._nearest.shape
        j = np.floor(points[..., 0] / COARSE).astype(np.int64)
        i = np.floor(rows - points[..., 1] / COARSE).astype(np.int64)
        inside = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
        nearest = self._nearest[np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)]
        return inside & (points[..., 2] >= nearest - self._slack)


def shade_triangles(
    seen: Points,
    normals: Points,
    front: Points,
    back: Points,
    shade: float,
    *,
    light: Points = LIGHT,
    lit: float = LIT,
) -> Grid:
    """Shade triangles (t, 3, 3) with normals at their corners, from both sides: (t, 3, 3) colours.

    front, back: colours of the sides, (3,) or (t, 1, 3). shade: how bright is what no light
    reaches. light: (3,) where it comes from. lit: how much it brightens.
    """
    normals, away = turn_to_viewer(seen, normals)
    base = np.where(away[:, None, None], back, front)
    bright = shade + (1.0 - shade) * np.clip(lit * (normals @ light), 0.0, 1.0)
    return (base * bright[..., None]).astype(np.float32)


def turn_to_viewer(seen: Points, normals: Points) -> tuple[Points, NDArray[np.bool_]]:
    """Turn the normals (t, 3, 3) of triangles that are seen from behind; (t,) which these are."""
    a, b, c = (seen[:, e, :2] for e in range(3))
    along, across = b - a, c - a
    away = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] < 0.0
    return np.where(away[:, None, None], -normals, normals), away


def _triangles(patches: Points) -> Points:
    """(q * 2 (n - 1)**2, 3, 3) triangles of patches (q, n, n, 3), those of a patch together."""
    a, b = patches[:, :-1, :-1], patches[:, 1:, :-1]
    c, d = patches[:, 1:, 1:], patches[:, :-1, 1:]
    both = np.stack([np.stack([a, b, c], axis=3), np.stack([a, c, d], axis=3)], axis=3)
    return both.reshape(-1, 3, 3)
