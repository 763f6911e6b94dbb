"""Dragging a curve: from where the pointer goes to where on the model the curve must pass."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError

#: A sample is hidden if the model is in front of it by more than this share of the diagonal:
#: curves lie on the model, at most some of a sample's spacing beneath it.
BENEATH = 0.002

#: Pixels by which a visible sample may be farther from the pointer than a hidden one and still
#: be meant.
RATHER_VISIBLE = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class MatrixCamera:
    """A camera and its window.

    matrix: (4, 4) float64, from homogeneous places of space to clip coordinates as of OpenGL:
            x / w, y / w and z / w run from -1 to 1 from left to right, from bottom to top and
            from the near plane to the far plane. What a viewer's camera gives, with or without
            perspective.
    size:   width and height of the window in pixels. Places in the window are in pixels from
            its lower left, x to the right and y up.
    """

    matrix: NDArray[np.float64]
    size: tuple[float, float]

    def __post_init__(self) -> None:
        matrix = np.array(self.matrix, np.float64)
        object.__setattr__(self, "matrix", matrix)
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            raise InvalidFeatureError("a view's matrix must be (4, 4) finite numbers")
        if np.linalg.matrix_rank(matrix) < 4:
            raise InvalidFeatureError("a view's matrix cannot be inverted; take the camera's own")
        if not (self.size[0] > 0 and self.size[1] > 0):
            raise InvalidFeatureError(f"a window of {self.size} pixels shows nothing")

    @classmethod
    def perspective(
        cls,
        eye: ArrayLike,
        focus: ArrayLike,
        up: ArrayLike,
        angle: float,
        size: tuple[float, float],
        depth: tuple[float, float],
    ) -> MatrixCamera:
        """From an eye (3,) to a focus (3,); angle: radians from bottom to top of the window;
        depth: distances of the near and the far plane from the eye, the near above 0."""
        near, far = depth
        scale = 1.0 / np.tan(angle / 2.0)
        lens = np.zeros((4, 4))
        lens[0, 0], lens[1, 1] = scale * size[1] / size[0], scale
        lens[2, 2], lens[2, 3] = (far + near) / (near - far), 2.0 * far * near / (near - far)
        lens[3, 2] = -1.0
        return cls(lens @ _facing(eye, focus, up), size)

    @classmethod
    def parallel(
        cls,
        eye: ArrayLike,
        focus: ArrayLike,
        up: ArrayLike,
        height: float,
        size: tuple[float, float],
        depth: tuple[float, float],
    ) -> MatrixCamera:
        """The same without perspective; height: units of space from bottom to top."""
        near, far = depth
        lens = np.diag([2.0 * size[1] / (height * size[0]), 2.0 / height, 2.0 / (near - far), 1.0])
        lens[2, 3] = (far + near) / (near - far)
        return cls(lens @ _facing(eye, focus, up), size)

    def seen_at(self, points: Points) -> NDArray[np.float64]:
        """(n, 2) where in the window points (n, 3) are; nan for those behind the eye."""
        clip = np.c_[points, np.ones(len(points))] @ self.matrix.T
        w = np.where(clip[:, 3:] > 0.0, clip[:, 3:], np.nan)
        return (clip[:, :2] / w + 1.0) / 2.0 * np.array(self.size)

    def rays(self, places: NDArray[np.float64]) -> tuple[Points, Points]:
        """Origins (n, 3) on the near plane and unit directions (n, 3) of what is seen at places
        (n, 2) of the window."""
        flat = 2.0 * places / np.array(self.size) - 1.0
        back = np.linalg.inv(self.matrix)
        ends: list[Points] = []
        for depth in (-1.0, 1.0):
            deep = np.c_[flat, np.full(len(flat), depth), np.ones(len(flat))] @ back.T
            ends.append(deep[:, :3] / deep[:, 3:])
        along = ends[1] - ends[0]
        return ends[0], along / np.linalg.norm(along, axis=1, keepdims=True)


@dataclass(frozen=True, slots=True, eq=False)
class Drag:
    """A sample of a curve that is being dragged.

    sample:  its number.
    pressed: (2,) float64, where the pointer was pressed, in pixels.
    begun:   (2,) float64, where the sample was seen then.
    point:   (3,) float64, where it is now: the last hit on the model, at first the sample.
    missed:  did the last ray miss the model, so that the point stayed?
    """

    view: MatrixCamera
    sample: int
    pressed: NDArray[np.float64]
    begun: NDArray[np.float64]
    point: Points
    missed: bool = False

    @property
    def constraint(self) -> tuple[int, Points]:
        """What the curve has to meet: the sample's number and the point."""
        return self.sample, self.point


def begin_drag(view: MatrixCamera, model: Surface, samples: ArrayLike, pressed: ArrayLike) -> Drag:
    """The drag of the one of a curve's (m, 3) samples that is seen nearest to a place (2,).

    Samples hidden by the model count only if visible ones are RATHER_VISIBLE pixels farther
    from the place. Raises InvalidFeatureError if all samples are behind the eye.

    Source: feature curve recovery paper, section 4.2. Differs from the paper: where a curve runs
    round the model, its back is not taken for its front.
    """
    given = as_points(samples, "samples of a curve", InvalidFeatureError)
    place = _place(pressed)
    seen = view.seen_at(given)
    away = np.linalg.norm(seen - place, axis=1)
    ahead = np.flatnonzero(np.isfinite(away))
    if not len(ahead):
        raise InvalidFeatureError("no sample of the curve is in front of the camera; turn the view")
    origins, directions = view.rays(seen[ahead])
    deep = np.einsum("nc,nc->n", given[ahead] - origins, directions)
    front = model.cast_rays(origins, directions).distances
    cost = away[ahead] + np.where(front < deep - BENEATH * model.diagonal, RATHER_VISIBLE, 0.0)
    chosen = int(ahead[np.argmin(cost)])
    return Drag(view, chosen, place, seen[chosen], given[chosen])


def move_drag(drag: Drag, model: Surface, place: ArrayLike) -> Drag:
    """The drag after the pointer went to a place (2,) of the window.

    The sample is moved in the window as the pointer was, and goes to the front-most point of
    the model that is seen there, or stays where it is if there is none.

    Source: feature curve recovery paper, section 4.2.
    """
    moved = drag.begun + (_place(place) - drag.pressed)
    hit = model.cast_rays(*drag.view.rays(moved[None]))
    if not hit.found[0]:
        return replace(drag, missed=True)
    return replace(drag, point=hit.points[0], missed=False)


def _place(place: ArrayLike) -> NDArray[np.float64]:
    result = np.array(place, np.float64)
    if result.shape != (2,) or not np.isfinite(result).all():
        raise InvalidFeatureError(f"a place in the window is two numbers of pixels, got {place!r}")
    return result


def _facing(eye: ArrayLike, focus: ArrayLike, up: ArrayLike) -> NDArray[np.float64]:
    """(4, 4) from space to the eye's own axes: right, up and backwards."""
    at = np.asarray(eye, np.float64)
    back = at - np.asarray(focus, np.float64)
    right = np.cross(np.asarray(up, np.float64), back)
    if not (np.linalg.norm(back) > 0.0 and np.linalg.norm(right) > 0.0):
        raise InvalidFeatureError("the eye is at the focus, or up is along the line of sight")
    back /= np.linalg.norm(back)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back])
    result = np.eye(4)
    result[:3, :3] = axes
    result[:3, 3] = -axes @ at
    return result
