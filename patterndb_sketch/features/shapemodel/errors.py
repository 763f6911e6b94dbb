"""How well a shape model gives back shapes: those it is from, and those it has not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Floats
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.shapemodel.model import ShapeModel


@dataclass(frozen=True, slots=True, eq=False)
class ErrorTable:
    """By number of modes, from 0: distances of vertices, in the shapes' unit.

    share:       (m,) float64, the share of the variance that so many modes have.
    known:       (m,) the root of the mean squared distance of the shapes that the model is from.
    known_most:  (m,) the greatest.
    unseen, unseen_most: the same of shapes that were left out, each from a model of all others;
                 nan for as many modes as such a model does not have.
    """

    share: Floats
    known: Floats
    known_most: Floats
    unseen: Floats
    unseen_most: Floats


def error_table(model: ShapeModel) -> ErrorTable:
    """The errors of a model with all its modes, and of those without one of its shapes.

    Raises InvalidFeatureError for a model that does not have all modes, so that its shapes are
    no more known, and for fewer than 3 shapes.
    """
    k, n = len(model.coefficients), len(model.mean)
    if k < 3:
        raise InvalidFeatureError(f"leaving one out of {k} shapes leaves no model; give 3 or more")
    if float(model.shares.sum()) < 1.0 - 1e-9:
        raise InvalidFeatureError(
            "modes were left out of the model, so the shapes that it is from are lost; build it "
            "with all modes"
        )
    flat = model.modes.reshape(model.n_modes, -1)
    shapes = model.mean.ravel() + model.coefficients @ flat
    known = np.stack([_errors(shape, model.mean.ravel(), flat) for shape in shapes])
    unseen = np.full((k, model.n_modes + 1, 2), np.nan)
    for i in range(k):
        others = np.delete(shapes, i, axis=0).reshape(k - 1, n, 3)
        try:
            less = ShapeModel.build(others, model.quads, model.features)
            modes, mean = less.modes.reshape(less.n_modes, -1), less.mean.ravel()
        except InvalidFeatureError:
            # All others are one shape.
            modes, mean = np.empty((0, 3 * n)), others.mean(axis=0).ravel()
        errors = _errors(shapes[i], mean, modes)[: model.n_modes + 1]
        unseen[i, : len(errors)] = errors
    return ErrorTable(
        np.r_[0.0, np.cumsum(model.shares)],
        np.sqrt((known[..., 0] ** 2).mean(axis=0)),
        known[..., 1].max(axis=0),
        np.sqrt((unseen[..., 0] ** 2).mean(axis=0)),
        unseen[..., 1].max(axis=0),
    )


def _errors(shape: Floats, mean: Floats, modes: Floats) -> Floats:
    """(l + 1, 2) root of the mean squared and greatest distance of vertices, by modes from 0."""
    rest = shape - mean
    result: list[tuple[float, float]] = []
    for count in range(len(modes) + 1):
        if count:
            rest = rest - (rest @ modes[count - 1]) * modes[count - 1]
        away = np.linalg.norm(rest.reshape(-1, 3), axis=1)
        result.append((float(np.sqrt((away**2).mean())), float(away.max())))
    return np.array(result)
