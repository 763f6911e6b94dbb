"""Shape models: the mean and the principal components of registered shapes, and how well they give
back shapes, those they are from and those they have not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb.verbs import PlotVerbs
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import Feature, Registration

#: Singular values below this share of the largest are rounding: shapes that say nothing new.
RANK = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class ShapeModel(PlotVerbs):
    """S = mean + coefficients @ modes, over vertices that mean the same in every shape.

    mean:         (n, 3) float64.
    modes:        (l, n, 3) float64, orthonormal as vectors of 3 n, by falling variance.
    deviations:   (l,) float64, the standard deviations of the coefficients, above 0.
    coefficients: (k, l) float64, those of the shapes that it was built from.
    variance:     of all modes, those that were not kept too.
    quads:        (q, 4) int32. features: named chains of vertices.
    names:        of the k shapes. template: the name of the template they were laid with.

    Source: feature curve recovery paper, section 5.2, equation 5.
    """

    mean: Points
    modes: Floats
    deviations: Floats
    coefficients: Floats
    variance: float
    quads: Int32Array
    features: tuple[Feature, ...]
    names: tuple[str, ...]
    template: str = ""

    @classmethod
    def build(
        cls,
        shapes: Sequence[ArrayLike] | Floats,
        quads: Int32Array,
        features: Sequence[Feature],
        *,
        names: Sequence[str] = (),
        template: str = "",
        keep: int | None = None,
    ) -> ShapeModel:
        """From k >= 2 shapes, each (n, 3) places of the same vertices.

        names: k, by default numbers. keep: modes to keep, those of the largest variance; by
        default all: k - 1, fewer if shapes depend on each other.

        Raises InvalidFeatureError for shapes of different sizes, for shapes that are all one,
        and for a keep that is not from 1 to k - 1.
        """
        every = [
            as_points(shape, f"shape {i}", InvalidFeatureError) for i, shape in enumerate(shapes)
        ]
        k = len(every)
        if k < 2:
            raise InvalidFeatureError(f"a shape model needs 2 shapes or more, got {k}")
        sizes = {len(shape) for shape in every}
        if len(sizes) > 1:
            raise InvalidFeatureError(
                f"the shapes have {sorted(sizes)} vertices; lay one template on all models"
            )
        titles = tuple(names) or tuple(str(i) for i in range(k))
        if len(titles) != k or len(set(titles)) < k:
            raise InvalidFeatureError(
                f"{k} shapes need {k} different names, got {len(set(titles))}"
            )
        if keep is not None and not 1 <= keep <= k - 1:
            raise InvalidFeatureError(
                f"keep is {keep}; {k} shapes have at most {k - 1} modes: give 1 to {k - 1}"
            )
        n = sizes.pop()
        check_features(features, quads, n)
        data = np.stack(every).reshape(k, 3 * n)
        mean = data.mean(axis=0)
        size, modes = _components(data - mean)
        if not len(size):
            raise InvalidFeatureError("all shapes are one; a shape model needs different ones")
        kept = len(size) if keep is None else min(keep, len(size))
        return cls(
            mean.reshape(n, 3),
            modes[:kept].reshape(kept, n, 3),
            size[:kept] / np.sqrt(k - 1),
            (data - mean) @ modes[:kept].T,
            float((size**2).sum() / (k - 1)),
            np.asarray(quads, np.int32),
            tuple(features),
            titles,
            template,
        )

    @classmethod
    def from_registrations(
        cls,
        registrations: Sequence[Registration],
        *,
        names: Sequence[str] = (),
        template: str = "",
        keep: int | None = None,
    ) -> ShapeModel:
        """From one template laid on several models; see :meth:`build`."""
        if not registrations:
            raise InvalidFeatureError("a shape model needs 2 shapes or more, got 0")
        first = registrations[0]
        for i, other in enumerate(registrations):
            if not np.array_equal(other.quads, first.quads):
                raise InvalidFeatureError(
                    f"registration {i} has other quads than the first; lay one template on all"
                )
        return cls.build(
            [one.points for one in registrations],
            first.quads,
            first.features,
            names=names,
            template=template,
            keep=keep,
        )

    @property
    def n_modes(self) -> int:
        return len(self.modes)

    @property
    def box(self) -> tuple[Floats, Floats]:
        """((l,), (l,)) the least and the greatest coefficients of the shapes that it is from."""
        return self.coefficients.min(axis=0), self.coefficients.max(axis=0)

    @property
    def shares(self) -> Floats:
        """(l,) the share of the variance that each mode has."""
        return self.deviations**2 / self.variance

    def kept(self, modes: int) -> ShapeModel:
        """The same with the first modes only."""
        if not 1 <= modes <= self.n_modes:
            raise InvalidFeatureError(f"keep is {modes}; the model has {self.n_modes} modes")
        return ShapeModel(
            self.mean, self.modes[:modes], self.deviations[:modes], self.coefficients[:, :modes],
            self.variance, self.quads, self.features, self.names, self.template,
        )  # fmt: skip

    def shape(self, coefficients: ArrayLike) -> Points:
        """(n, 3) the shape of coefficients (l,)."""
        given = np.asarray(coefficients, np.float64)
        if given.shape != (self.n_modes,) or not np.isfinite(given).all():
            raise InvalidFeatureError(
                f"coefficients must be {self.n_modes} finite numbers, got the shape {given.shape}"
            )
        return self.mean + np.einsum("l,lnc->nc", given, self.modes)

    def project(self, shape: ArrayLike) -> Floats:
        """(l,) the coefficients whose shape is nearest to places (n, 3), the box not looked at."""
        given = as_points(shape, "the shape", InvalidFeatureError)
        if given.shape != self.mean.shape:
            raise InvalidFeatureError(
                f"the shape has {len(given)} vertices, the model {len(self.mean)}; lay the "
                "template on it"
            )
        return np.einsum("nc,lnc->l", given - self.mean, self.modes)

    def sample(self, seed: int) -> Floats:
        """(l,) coefficients of a new shape: normally distributed as the known ones are, within
        their box. The same seed gives the same."""
        # Imported here: scipy's statistics take longer than recovering a curve.
        from scipy.stats import truncnorm

        low, high = (bound / self.deviations for bound in self.box)
        drawn = truncnorm.rvs(low, high, random_state=np.random.default_rng(seed))
        return np.clip(np.asarray(drawn, np.float64) * self.deviations, *self.box)

    def feature(self, name: str) -> Feature:
        """The named feature; raises InvalidFeatureError if there is none."""
        for one in self.features:
            if one.name == name:
                return one
        known = ", ".join(one.name for one in self.features)
        raise InvalidFeatureError(f"the shape model has no feature {name!r}; it has {known}")


def _components(data: Floats) -> tuple[Floats, Floats]:
    """Singular values (l,) of rows that sum to 0, and right singular vectors (l, 3 n).

    Each vector's largest entry is above 0, so that the same data give the same signs.
    """
    size, right = np.linalg.svd(data, full_matrices=False)[1:]
    # Rows that sum to 0 have one direction less than there are rows.
    count = int((size[: len(data) - 1] > RANK * size[0]).sum())
    right = right[:count]
    largest = np.take_along_axis(right, np.abs(right).argmax(axis=1)[:, None], axis=1)
    return size[:count], right * np.where(largest < 0.0, -1.0, 1.0)


def check_features(features: Sequence[Feature], quads: Int32Array, n: int) -> None:
    """Raises InvalidFeatureError for quads or features that name other vertices than n."""
    faces = np.asarray(quads)
    if faces.ndim != 2 or faces.shape[1] != 4 or faces.min(initial=0) < 0:
        raise InvalidFeatureError(f"a shape model's quads must be (q, 4), got {faces.shape}")
    if faces.max(initial=-1) >= n:
        raise InvalidFeatureError(f"a quad of the shape model names a vertex outside 0..{n - 1}")
    names = [one.name for one in features]
    if len(set(names)) < len(names):
        raise InvalidFeatureError("two features of the shape model have one name")
    for one in features:
        ids = np.asarray(one.vertices)
        if ids.ndim != 1 or not len(ids) or ids.min() < 0 or ids.max() >= n:
            raise InvalidFeatureError(
                f"the feature {one.name} needs one vertex of 0..{n - 1} or more"
            )


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


def measure_errors(model: ShapeModel) -> ErrorTable:
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
