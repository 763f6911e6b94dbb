"""Editing a shape by its feature curves: the coefficients that come closest to what was dragged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import lsq_linear

from patterndb.geometry.points import Floats, Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.shapemodel.model import ShapeModel

#: What it costs to leave the present shape by one standard deviation of a mode: as much as if all
#: dragged vertices missed by this share of how far the first mode's deviation moves a vertex. On
#: four bodies that the model had not seen a dragged feature goes 97 % as far with it as without,
#: and where another is held the farthest vertex two fifths as far (benchmarks/feature_edits.py).
STIFFNESS = 0.05

#: How exactly the bounded least squares are solved, in shares of the cost.
TOLERANCE = 1e-14

#: Steps for every mode that the solver may take. By itself it takes one, but a mode may come to
#: its limit and leave it again.
STEPS_EACH = 50


@dataclass(frozen=True, slots=True, eq=False)
class ShapeEdit:
    """A shape that came closest to its targets.

    coefficients: (l,) float64, within the box. points: (n, 3) float64, their shape.
    at_bound:     (l,) int, -1 or 1 where a coefficient is at its least or greatest, else 0.
    misses:       by feature, the greatest distance of its vertices from their targets.
    """

    coefficients: Floats
    points: Points
    at_bound: NDArray[np.int64]
    misses: Mapping[str, float]


def pull_feature(
    model: ShapeModel, name: str, by: ArrayLike, *, start: ArrayLike | None = None,
    vertex: int | None = None,
) -> dict[str, Points]:  # fmt: skip
    """Targets for :func:`edit`: a feature, displaced by (3,) from where the shape start has it.

    vertex: the place in the feature of the one vertex that is displaced, -1 for the last; the
    others fall behind towards the feature's ends, which stay, as the curve that is pulled; of a
    closed feature towards the vertex opposite.
    """
    feature = model.feature(name)
    offset = as_points(np.asarray(by)[None], "the displacement", InvalidFeatureError)[0]
    places = _shape(model, start)[1][feature.vertices]
    if vertex is None:
        return {name: places + offset}
    n = len(places)
    if not -n <= vertex < n:
        raise InvalidFeatureError(f"the feature {name} has {n} vertices; there is no {vertex}")
    at = vertex % n
    along = np.arange(n, dtype=np.float64)
    if feature.vertices[0] == feature.vertices[-1] and n > 2:
        # The last vertex is the first again, n - 1 steps on.
        away = np.abs(along - at)
        share = 1.0 - np.minimum(away, n - 1 - away) / ((n - 1) / 2.0)
        return {name: places + (share**2 * (3.0 - 2.0 * share))[:, None] * offset}
    before = along / at if at else np.ones(n)
    after = (n - 1 - along) / (n - 1 - at) if at < n - 1 else np.ones(n)
    share = np.minimum(before, after)
    return {name: places + (share**2 * (3.0 - 2.0 * share))[:, None] * offset}


def edit(
    model: ShapeModel,
    targets: Mapping[str, ArrayLike],
    *,
    held: Mapping[str, float] | None = None,
    start: ArrayLike | None = None,
    stiffness: float = STIFFNESS,
) -> ShapeEdit:
    """The shape within the model's box whose features are nearest to the targets.

    targets:   by feature, (m, 3) where its vertices shall be.
    held:      by feature, the weight with which its vertices shall stay where start has them; 1
               weighs as much as a target. Features that are in neither follow.
    start:     (l,) coefficients of the present shape, by default the mean; into the box.
    stiffness: see STIFFNESS.

    Source: feature curve recovery paper, section 5.2, equation 6, with its bounds. Differs from
    the paper: it holds all features that were not dragged, with weight 1, so that a drag has
    little effect; here the user says which. And modes are normally distributed with the variances
    that they were found with, a prior (Tikhonov's): without it those of next to no variance go to
    their bounds for a millimetre of a target, and throw up spikes far from what was dragged.

    Raises InvalidFeatureError for features that are not there, for targets of another number of
    vertices, and for weights that are negative.
    """
    begin, matrix, wanted = build_system(
        model, targets, held=held, start=start, stiffness=stiffness
    )
    low, high = model.box
    found = lsq_linear(
        matrix,
        wanted,
        (low - begin, high - begin),
        method="bvls",
        tol=TOLERANCE,
        max_iter=STEPS_EACH * model.n_modes,
    )
    if not found.success:
        raise InvalidFeatureError(f"the edit found no shape: {found.message}; give nearer targets")
    coefficients = np.clip(begin + found.x, low, high)
    side = np.asarray(found.active_mask, np.int64)
    coefficients = np.where(side < 0, low, np.where(side > 0, high, coefficients))
    points = model.shape(coefficients)
    misses = {
        name: float(
            np.linalg.norm(points[model.feature(name).vertices] - np.asarray(places), axis=1).max()
        )
        for name, places in targets.items()
    }
    return ShapeEdit(coefficients, points, side, misses)


def build_system(
    model: ShapeModel,
    targets: Mapping[str, ArrayLike],
    *,
    held: Mapping[str, float] | None = None,
    start: ArrayLike | None = None,
    stiffness: float = STIFFNESS,
) -> tuple[Floats, Floats, Floats]:
    """The least squares of an edit: (l,) where it starts, the matrix (r, l) and the right side
    (r,) for steps from there. Arguments and errors as of :func:`edit`."""
    if not targets:
        raise InvalidFeatureError("nothing was dragged; give targets for a feature")
    if not (np.isfinite(stiffness) and stiffness >= 0.0):
        raise InvalidFeatureError(f"the stiffness is {stiffness}; give 0 or more")
    begin, present = _shape(model, start)
    rows: list[Floats] = []
    right: list[Floats] = []
    for name, places in targets.items():
        vertices = model.feature(name).vertices
        given = as_points(places, f"targets of {name}", InvalidFeatureError)
        if len(given) != len(vertices):
            raise InvalidFeatureError(
                f"the feature {name} has {len(vertices)} vertices and {len(given)} targets; sample "
                "the dragged curve at equal arc length"
            )
        rows.append(_rows(model, vertices))
        right.append((given - present[vertices]).ravel())
    for name, weight in (held or {}).items():
        if name in targets:
            raise InvalidFeatureError(f"the feature {name} is dragged and held; do one of both")
        if not (np.isfinite(weight) and weight >= 0.0):
            raise InvalidFeatureError(f"the weight of {name} is {weight}; give 0 or more")
        rows.append(weight * _rows(model, model.feature(name).vertices))
        right.append(np.zeros(len(rows[-1])))
    # The first mode's deviation moves vertices by this much, in the mean of squares.
    span = model.deviations[0] / np.sqrt(len(model.mean))
    if stiffness > 0.0:
        # As if so many vertices missed by as much: finer templates give the same edit.
        count = sum(len(model.feature(name).vertices) for name in targets)
        rows.append(np.diag(stiffness * span * np.sqrt(count) / model.deviations))
        right.append(np.zeros(model.n_modes))
    return begin, np.concatenate(rows), np.concatenate(right)


def _rows(model: ShapeModel, vertices: NDArray[np.int32]) -> Floats:
    """(3 m, l) what each coefficient does to the places of vertices (m,)."""
    return model.modes[:, vertices].reshape(model.n_modes, -1).T


def _shape(model: ShapeModel, start: ArrayLike | None) -> tuple[Floats, Points]:
    """Coefficients in the box, and their shape."""
    given = np.zeros(model.n_modes) if start is None else np.asarray(start, np.float64)
    # Says what is wrong with them before they are put into the box.
    model.shape(given)
    begin = np.clip(given, *model.box)
    return begin, model.shape(begin)
