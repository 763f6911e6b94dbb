"""A session of features with something of every kind in it, and a shape model."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import Feature, FeatureCurves, box_template
from patterndb_sketch.features.session import FeatureSession, SessionCurve
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import SnapSettings
from tests.support.features.registration import grid_quads, rim, sheet

FEATURES = (Feature("low", np.arange(5, dtype=np.int32)),)


def make_shape_model(seed: int = 0) -> ShapeModel:
    """Build a model of five random shapes of a sheet."""
    shapes = np.random.default_rng(seed).normal(size=(5, 25, 3))
    return ShapeModel.build(shapes, grid_quads(5), FEATURES, names=tuple("äbcde"), template="sheet")


def make_session() -> FeatureSession:
    """Make a session that has something of every kind."""
    rng = np.random.default_rng(1)
    samples = np.cumsum(rng.normal(size=(30, 3)), axis=0)
    curve = SessionCurve(
        "roof rail", samples[::7].copy(), samples, ((4, samples[4] + 0.1), (29, samples[29])),
        spline_through(samples), SnapSettings(alpha=0.5, nearness=None),
    )  # fmt: skip
    network = FeatureCurves(
        rim(), {"ne": ("east", "north")}, {"se": np.array([0.5, -0.5, 1 / 3])}, 0.0625
    )
    return FeatureSession(
        "models/sedan.obj",
        (curve,),
        SnapSettings(alpha=0.1 + 0.2, beta=1 / 3),
        {"one": network, "none": FeatureCurves({"a": curve.spline})},
        {"sheet": sheet(4), "car": box_template(3)},
        {"cars": make_shape_model(), "others": make_shape_model(1)},
    )
