"""Shape models: principal components of shapes, and shapes that come close to what is dragged."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import Feature
from patterndb_sketch.features.shapemodel import (
    ShapeEdit,
    ShapeModel,
    edit,
    measure_errors,
    pull_feature,
)
from patterndb_sketch.features.shapemodel.edit import STIFFNESS, build_system
from tests.support.features.registration import car_template, grid_quads, laid

QUADS = grid_quads(6)
FEATURES = (
    Feature("low", np.arange(6, dtype=np.int32)),
    Feature("high", np.arange(30, 36, dtype=np.int32)),
)


def shapes(seed: int, k: int = 6) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(36, 3)) + 0.2 * rng.normal(size=(k, 36, 3)) * rng.uniform(
        0.1, 3.0, (k, 1, 1)
    )


def made(seed: int, k: int = 6, keep: int | None = None) -> ShapeModel:
    return ShapeModel.build(shapes(seed, k), QUADS, FEATURES, keep=keep)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 9))
def test_all_modes_give_the_shapes_back(seed: int, k: int) -> None:
    """k shapes have k - 1 modes; each shape is given back to 1e-10, from its own coefficients
    and from its projection."""
    model, given_ = made(seed, k), shapes(seed, k)
    assert model.n_modes == k - 1
    for shape, coefficients in zip(given_, model.coefficients, strict=True):
        assert np.abs(model.shape(coefficients) - shape).max() < 1e-10
        assert np.abs(model.shape(model.project(shape)) - shape).max() < 1e-10


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_modes_are_the_eigenvectors_of_the_covariance(seed: int) -> None:
    """Against numpy's: the largest eigenvalues, falling, and orthonormal vectors up to sign."""
    model = made(seed, 5)
    covariance = np.cov(shapes(seed, 5).reshape(5, -1).T)
    values, vectors = np.linalg.eigh(covariance)
    assert model.deviations**2 == pytest.approx(values[::-1][:4])
    assert (np.diff(model.deviations) <= 0.0).all()
    flat = model.modes.reshape(4, -1)
    assert flat @ flat.T == pytest.approx(np.eye(4), abs=1e-12)
    along = np.abs(np.einsum("ln,nl->l", flat, vectors[:, ::-1][:, :4]))
    assert along == pytest.approx(np.ones(4), abs=1e-6)
    assert model.coefficients.std(axis=0, ddof=1) == pytest.approx(model.deviations)
    assert model.variance == pytest.approx(np.trace(covariance))
    assert model.shares.sum() == pytest.approx(1.0)


def test_fewer_modes_are_the_first_ones() -> None:
    """And no other modes of their number have a smaller error: Eckart and Young."""
    whole, few = made(1), made(1, keep=2)
    assert np.array_equal(few.modes, whole.modes[:2])
    assert few.coefficients == pytest.approx(whole.kept(2).coefficients, abs=1e-12)
    data = shapes(1).reshape(6, -1)
    left = np.linalg.norm(data - data.mean(axis=0)) ** 2 - (few.coefficients**2).sum()
    rng = np.random.default_rng(0)
    for _ in range(200):
        other = np.linalg.qr(rng.normal(size=(data.shape[1], 2)))[0]
        rest = data - data.mean(axis=0)
        assert np.linalg.norm(rest - rest @ other @ other.T) ** 2 >= left - 1e-9


def test_shapes_that_depend_on_each_other_have_fewer_modes() -> None:
    three = shapes(2, 3)
    model = ShapeModel.build([*three, three.mean(axis=0), three[0]], QUADS, FEATURES)
    assert model.n_modes == 2
    with pytest.raises(InvalidFeatureError, match="all shapes are one"):
        ShapeModel.build([three[0], three[0]], QUADS, FEATURES)


def test_the_errors_fall_with_the_modes() -> None:
    """To rounding for the shapes of the model; and by hand for shapes that it has not seen."""
    model = made(3)
    table = measure_errors(model)
    assert table.share[0] == 0.0 and table.share[-1] == pytest.approx(1.0)
    assert (np.diff(table.known) < 0.0).all() and table.known[-1] < 1e-12
    assert (np.diff(table.unseen[:-1]) <= 1e-12).all() and np.isnan(table.unseen[-1])
    squares, most = [], 0.0
    for i, shape in enumerate(shapes(3)):
        less = ShapeModel.build(np.delete(shapes(3), i, axis=0), QUADS, FEATURES, keep=2)
        away = np.linalg.norm(less.shape(less.project(shape)) - shape, axis=1)
        squares.append((away**2).mean())
        most = max(most, away.max())
    assert table.unseen[2] == pytest.approx(np.sqrt(np.mean(squares)))
    assert table.unseen_most[2] == pytest.approx(most)
    with pytest.raises(InvalidFeatureError, match="build it with all modes"):
        measure_errors(model.kept(2))
    with pytest.raises(InvalidFeatureError, match="3 or more"):
        measure_errors(made(3, 2))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_samples_are_within_the_box(seed: int) -> None:
    model = made(4)
    low, high = model.box
    coefficients = model.sample(seed)
    assert (low <= coefficients).all() and (coefficients <= high).all()
    assert np.array_equal(coefficients, model.sample(seed))
    assert not np.array_equal(coefficients, model.sample(seed + 1))


def targets(model: ShapeModel, seed: int, size: float) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {"low": model.mean[FEATURES[0].vertices] + size * rng.normal(size=(6, 3))}


def assert_nearest(
    model: ShapeModel, wanted: Mapping[str, ArrayLike], found: ShapeEdit, **options: Any
) -> None:
    """Karush, Kuhn and Tucker's conditions: the gradient is 0 within the box, and points out of
    it at a bound: since the sum is convex, no shape in the box is nearer to the targets."""
    low, high = model.box
    assert (low <= found.coefficients).all() and (found.coefficients <= high).all()
    begin, matrix, right = build_system(model, wanted, **options)
    gradient = matrix.T @ (matrix @ (found.coefficients - begin) - right)
    scale = np.abs(matrix.T @ right).max() + 1e-12
    assert (np.abs(gradient[found.at_bound == 0]) < 1e-7 * scale).all()
    assert (gradient[found.at_bound < 0] > -1e-7 * scale).all()
    assert (gradient[found.at_bound > 0] < 1e-7 * scale).all()
    assert (found.coefficients[found.at_bound < 0] == low[found.at_bound < 0]).all()
    assert (found.coefficients[found.at_bound > 0] == high[found.at_bound > 0]).all()
    assert np.array_equal(found.points, model.shape(found.coefficients))


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10**6),
    st.sampled_from([0.01, 0.3, 3.0]),
    st.sampled_from([0.0, 0.5, 4.0]),
    st.sampled_from([0.0, 1e-3, 0.5]),
)
def test_an_edit_meets_the_conditions_of_optimality(
    seed: int, size: float, weight: float, stiffness: float
) -> None:
    model = made(seed % 50, 8)
    start = model.sample(seed)
    options = {"held": {"high": weight}, "start": start, "stiffness": stiffness}
    wanted = targets(model, seed, size)
    found = edit(model, wanted, **options)
    assert_nearest(model, wanted, found, **options)
    assert found.misses["low"] == pytest.approx(
        np.linalg.norm(found.points[:6] - wanted["low"], axis=1).max()
    )


#: A stiffness with which modes go to their limits as if there were none.
FREE = 1e-3


def pulled(seed: int) -> tuple[ShapeModel, dict[str, np.ndarray]]:
    """Ten shapes that differ less and less, three vertices of them and where these shall be:
    few numbers to meet with nine modes, so that modes come to their limits and leave them."""
    rng = np.random.default_rng(seed)
    fading = 0.8 ** np.arange(10)[:, None, None]
    many = rng.normal(size=(36, 3)) + fading * rng.normal(size=(10, 36, 3))
    model = ShapeModel.build(many, QUADS, (Feature("three", np.arange(3, dtype=np.int32)),))
    return model, {"three": model.mean[:3] + rng.normal(size=(3, 3))}


def test_modes_that_leave_their_limits_again_are_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Some pulls take more steps than there are modes: with so few they are refused, and with
    those that there are all end in the optimum."""
    module = importlib.import_module("patterndb_sketch.features.shapemodel.edit")
    pulls = [pulled(seed) for seed in range(600)]
    for model, wanted in pulls:
        assert_nearest(model, wanted, edit(model, wanted, stiffness=FREE), stiffness=FREE)
    monkeypatch.setattr(module, "STEPS_EACH", 1)
    refused = 0
    for model, wanted in pulls:
        try:
            assert_nearest(model, wanted, edit(model, wanted, stiffness=FREE), stiffness=FREE)
        except InvalidFeatureError as error:
            assert "the edit found no shape" in str(error)
            refused += 1
    assert refused > 0


def test_bounds_are_not_clipping() -> None:
    """Where the box binds, the bounded optimum is nearer to the targets than the free optimum
    put into the box; and no general solver finds a nearer one."""
    better = 0
    for seed in range(8):
        model = made(seed, 8)
        wanted = targets(model, seed, 1.0)
        found = edit(model, wanted, stiffness=0.0)
        _, matrix, right = build_system(model, wanted, stiffness=0.0)
        clipped = np.clip(np.linalg.lstsq(matrix, right, rcond=None)[0], *model.box)

        def cost(a: np.ndarray, matrix: np.ndarray = matrix, right: np.ndarray = right) -> float:
            return float(((matrix @ a - right) ** 2).sum())

        bounds = list(zip(*model.box, strict=True))
        other = minimize(cost, found.coefficients * 0.0, bounds=bounds, tol=1e-15)
        assert cost(found.coefficients) <= other.fun * (1.0 + 1e-9)
        assert cost(found.coefficients) <= cost(clipped) + 1e-12
        better += cost(found.coefficients) < 0.999 * cost(clipped)
    assert better >= 4


def test_an_edit_that_asks_for_a_known_shape_gets_it() -> None:
    """All features at a training shape's: Eq. 6 as printed, nothing else to weigh."""
    model, known = made(5), shapes(5)
    for shape, coefficients in zip(known, model.coefficients, strict=True):
        wanted = {one.name: shape[one.vertices] for one in FEATURES}
        found = edit(model, wanted, stiffness=0.0)
        assert found.coefficients == pytest.approx(coefficients, abs=1e-9)
        assert max(found.misses.values()) < 1e-9


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([1e-3, STIFFNESS, 0.5]))
def test_an_edit_is_the_most_likely_shape(seed: int, stiffness: float) -> None:
    """Its definition, minimised by another solver: squared misses of dragged vertices, and of modes
    the squares of their deviations from the start, each as dear as its variance is small."""
    model = made(seed % 50, 8)
    start = model.sample(seed)
    wanted = targets(model, seed, 0.2)
    low = FEATURES[0].vertices
    span = np.sqrt((model.deviations[0] * model.modes[0]) ** 2).ravel()
    unit = stiffness * float(np.sqrt((span**2).sum() / len(model.mean)))

    def cost(a: np.ndarray) -> float:
        missed = ((model.shape(a)[low] - wanted["low"]) ** 2).sum()
        return float(
            missed
            + len(low)
            * (unit * (a - start) / model.deviations)
            @ (unit * (a - start) / model.deviations)
        )

    found = edit(model, wanted, start=start, stiffness=stiffness)
    bounds = list(zip(*model.box, strict=True))
    other = minimize(cost, start, bounds=bounds, tol=1e-16)
    assert cost(found.coefficients) <= other.fun * (1.0 + 1e-9)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_an_edit_does_not_depend_on_how_fine_the_template_is(seed: int) -> None:
    """Every vertex twice, in features too: the same shape."""
    twice = np.repeat(np.arange(36), 2)
    many = shapes(seed % 50, 8)
    fine = ShapeModel.build(
        many[:, twice], (2 * QUADS).astype(np.int32),
        [
            Feature(one.name, np.flatnonzero(np.isin(twice, one.vertices)).astype(np.int32))
            for one in FEATURES
        ],
    )  # fmt: skip
    coarse = ShapeModel.build(many, QUADS, FEATURES)
    wanted = targets(coarse, seed, 0.3)["low"]
    one = edit(coarse, {"low": wanted}, held={"high": 0.5})
    other = edit(fine, {"low": wanted[twice[:12]]}, held={"high": 0.5})
    assert other.points[::2] == pytest.approx(one.points, abs=1e-8)


def test_modes_of_next_to_no_variance_stay_where_they_are() -> None:
    """Shapes differ in a lift of all vertices, and by a thousandth of that in a row with a spike: a
    lift is met by the first mode, and the spike stays; without a prior a row that is held throws it
    up as far as it was ever seen."""
    lift = np.zeros((36, 3))
    lift[:, 2] = 1.0
    spike = np.zeros((36, 3))
    spike[FEATURES[0].vertices, 2], spike[20, 2] = 1e-3, 0.2
    flat = shapes(0, 1)[0]
    many = [flat + a * lift + b * spike for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1), (0, 0))]
    model = ShapeModel.build(many, QUADS, FEATURES)
    wanted = pull_feature(model, "low", (0.0, 0.0, 0.4))

    def spiked(stiffness: float) -> float:
        found = edit(model, wanted, held={"high": 1.0}, stiffness=stiffness)
        return float(found.points[20, 2] - found.points[21, 2] - flat[20, 2] + flat[21, 2])

    # The modes are nearly the lift and the spike.
    assert spiked(0.0) == pytest.approx(0.2, abs=0.01)
    assert abs(spiked(STIFFNESS)) < 0.02


def test_held_features_stay_the_better_the_more_they_weigh() -> None:
    model = made(6, 8)
    present = model.mean[FEATURES[1].vertices]
    wanted = targets(model, 6, 0.2)
    off = [
        np.linalg.norm(edit(model, wanted, held={"high": w}).points[FEATURES[1].vertices] - present)
        for w in (0.0, 0.5, 2.0, 100.0)
    ]
    assert off == sorted(off, reverse=True) and off[-1] < 0.05 * off[0]


def test_nothing_that_no_target_decides_moves() -> None:
    """A shape dragged to where it is stays, also from a start that is not the mean."""
    model = made(7)
    start = model.sample(1)
    places = model.shape(start)[FEATURES[0].vertices]
    found = edit(model, {"low": places}, start=start)
    assert found.coefficients == pytest.approx(start, abs=1e-9)


def test_a_drag_moves_a_feature_or_pulls_it_by_one_vertex() -> None:
    model = made(8)
    start = model.sample(2)
    places = model.shape(start)[FEATURES[0].vertices]
    whole = pull_feature(model, "low", (1.0, 2.0, 3.0), start=start)["low"]
    assert whole - places == pytest.approx(np.tile([1.0, 2.0, 3.0], (6, 1)))
    pulled = pull_feature(model, "low", (0.0, 0.0, 1.0), start=start, vertex=2)["low"] - places
    assert pulled[2] == pytest.approx([0.0, 0.0, 1.0])
    assert np.abs(pulled[[0, 5]]).max() == 0.0
    assert (np.diff(pulled[:3, 2]) > 0.0).all() and (np.diff(pulled[2:, 2]) < 0.0).all()
    end = pull_feature(model, "low", (0.0, 0.0, 1.0), vertex=-1)["low"] - model.mean[:6]
    assert end[5] == pytest.approx([0.0, 0.0, 1.0]) and np.abs(end[0]).max() == 0.0
    with pytest.raises(InvalidFeatureError, match="there is no 6"):
        pull_feature(model, "low", (0.0, 0.0, 1.0), vertex=6)


def test_a_model_of_cars_is_symmetric_and_edited_by_its_rail() -> None:
    """Every shape of it is symmetric to 1e-12; a rail that is raised raises the roof."""
    found = [laid(name) for name in ("sedan", "pickup", "van")]
    model = ShapeModel.from_registrations(found, names=("a", "b", "c"), template="box")
    lifted = edit(model, pull_feature(model, "roof_rail", (0.0, 0.0, 0.1)))
    rail, profile = (model.feature(name).vertices for name in ("roof_rail", "roof_profile"))
    assert (lifted.points[rail, 2] > model.mean[rail, 2]).all()
    assert lifted.points[profile, 2].mean() > model.mean[profile, 2].mean() + 0.02
    for shape in (lifted.points, model.shape(model.sample(1))):
        template = car_template()
        v = template.n_vertices
        image = shape[:v][~template.plane] * [1.0, -1.0, 1.0]
        assert np.abs(shape[v:] - image).max() < 1e-12
        assert np.abs(shape[:v][template.plane, 1]).max() < 1e-12


def test_what_is_no_shape_model_is_refused() -> None:
    good = shapes(0)
    build = ShapeModel.build
    wrong = {
        "2 shapes or more": lambda: build(good[:1], QUADS, FEATURES),
        "lay one template": lambda: build([good[0], good[1][:30]], QUADS, FEATURES),
        "different names": lambda: build(good, QUADS, FEATURES, names=("a",) * 6),
        "at most 5 modes": lambda: build(good, QUADS, FEATURES, keep=6),
        "outside 0..35": lambda: build(good, QUADS + 1, FEATURES),
        "one name": lambda: build(good, QUADS, (*FEATURES, FEATURES[0])),
        "needs one vertex": lambda: build(good, QUADS, (Feature("x", np.array([40])),)),
        "got 0": lambda: ShapeModel.from_registrations([]),
        "no feature 'rail'": lambda: made(0).feature("rail"),
        "has 5 modes": lambda: made(0).kept(6),
        "5 finite numbers": lambda: made(0).shape([1.0]),
        "has 3 vertices": lambda: made(0).project(np.zeros((3, 3))),
        "the displacement have": lambda: pull_feature(made(0), "low", np.zeros((2, 3))),
        "nothing was dragged": lambda: edit(made(0), {}),
        "and 2 targets": lambda: edit(made(0), {"low": np.zeros((2, 3))}),
        "dragged and held": lambda: edit(made(0), {"low": np.zeros((6, 3))}, held={"low": 1.0}),
        "the weight of high": lambda: edit(made(0), {"low": np.zeros((6, 3))}, held={"high": -1.0}),
        "stiffness is -1": lambda: edit(made(0), {"low": np.zeros((6, 3))}, stiffness=-1.0),
    }
    for match, call in wrong.items():
        with pytest.raises(InvalidFeatureError, match=match):
            call()
