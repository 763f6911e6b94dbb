"""What is seen at a place of the picture: the model, curves on it, and their pins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import find_nearest_on
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.drag import MatrixCamera
from patterndb_sketch.features.edits import DrawnCurve
from viewer.camera import View
from viewer.pointer import FEATURE_REACH, PIN_REACH

Place = tuple[float, float]

#: From a pin's foot to the middle of its head, in points to the right and up.
PIN = (4.0, 17.0)

#: What lies deeper than the model's surface by more than this share of the diagonal is hidden:
#: splines are off the samples that they are fitted to by less.
BENEATH = 0.006

#: How far around a place gaps are looked for, in points: two rings of directions, each with its
#: opposite half a turn on. What lies deeper than what is around by this share of the diagonal is
#: seen through a gap.
AROUND = (3.0, 7.0)
RING = np.stack([np.cos(np.arange(8) * np.pi / 4.0), np.sin(np.arange(8) * np.pi / 4.0)], axis=1)
DROP = 0.02

#: Near and far planes are so many times as far from the eye as the farthest point.
ROOM = 1.05


class CurveUnderPointer(NamedTuple):
    """What is under the pointer: a curve by its key, and of its pins the sample's number."""

    key: int
    pin: int | None = None


def make_matrix_camera(view: View, model: Surface, room: tuple[float, float]) -> MatrixCamera:
    """Make the camera that sees the model as the picture of this size, in points, shows it."""
    middle = (model.vertices.min(axis=0) + model.vertices.max(axis=0)) / 2.0
    far = ROOM * (model.diagonal + float(np.linalg.norm(view.focus - middle)))
    eye = view.focus + far * view.axes[2]
    height = room[1] / view.scale
    return MatrixCamera.parallel(eye, view.focus, view.axes[1], height, room, (0.0, 2.0 * far))


def to_picture_place(room: tuple[float, float], x: float, y: float) -> NDArray[np.float64]:
    """(2,) a place of a camera's window, of one in points from the picture's middle."""
    return np.array([x + room[0] / 2.0, y + room[1] / 2.0])


def find_surface_point(
    view: View, model: Surface, room: tuple[float, float], x: float, y: float
) -> Points | None:
    """Find (3,) the front-most point of the model at a place of the picture.

    Features run along the borders of patches, and patches leave gaps: what is seen through a
    narrow gap does not count, but the surface beside it.
    """
    places = to_picture_place(room, x, y) + np.concatenate(
        [np.zeros((1, 2)), *(r * RING for r in AROUND)]
    )
    hits = model.cast_rays(*make_matrix_camera(view, model, room).rays(places))
    depth = hits.distances
    half = len(RING) // 2
    for first in range(1, len(depth), len(RING)):
        for one in range(first, first + half):
            pair = [one, one + half]
            before = depth[pair].max() < depth[0] - DROP * model.diagonal
            if before and abs(depth[pair[0]] - depth[pair[1]]) < DROP * model.diagonal:
                return model.nearest(hits.points[pair].mean(axis=0)[None]).points[0]
    return hits.points[0] if hits.found[0] else None


def find_under_pointer(
    view: View,
    model: Surface,
    room: tuple[float, float],
    drawn: Sequence[tuple[DrawnCurve, Points]],
    place: Place,
    *,
    through: bool,
) -> CurveUnderPointer | None:
    """Find the pin, else the curve, at a place of the picture.

    drawn: curves with their lines (k, 3). through: what the model hides counts, too.
    """
    found: list[tuple[float, CurveUnderPointer, Points]] = []
    for curve, line in drawn:
        if curve.constraints:
            feet = np.stack([np.asarray(point, np.float64) for _, point in curve.constraints])
            seen = view.seen(feet)[:, :2]
            away = np.minimum(
                np.linalg.norm(seen - place, axis=1),
                np.linalg.norm(seen + np.array(PIN) - place, axis=1),
            )
            for i in np.flatnonzero(away <= PIN_REACH).tolist():
                # Pins stand on curves: they come first.
                found.append(
                    (
                        away[i] - PIN_REACH,
                        CurveUnderPointer(curve.key, curve.constraints[i][0]),
                        feet[i],
                    )
                )
        away, piece, share = find_nearest_on(view.seen(line)[:, :2], place)
        if away <= FEATURE_REACH:
            foot = line[piece] + share * (line[piece + 1] - line[piece])
            found.append((away, CurveUnderPointer(curve.key), foot))
    found.sort(key=lambda one: one[0])
    if through:
        return found[0][1] if found else None
    return next((under for _, under, at in found if is_visible(view, model, room, at)), None)


def is_visible(view: View, model: Surface, room: tuple[float, float], point: Points) -> bool:
    """Is a point (3,) on the model or before it, as it is seen?"""
    origins, directions = make_matrix_camera(view, model, room).rays(
        to_picture_place(room, *view.seen(point)[:2].tolist())[None]
    )
    depth = float((point - origins[0]) @ directions[0])
    front = float(model.cast_rays(origins, directions).distances[0])
    return front >= depth - BENEATH * model.diagonal
