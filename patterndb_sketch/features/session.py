"""Sessions of feature curves: curves with their settings, networks, templates and shape models.

The content of the file is :class:`SavedFeatures`; :mod:`patterndb_sketch.sessions` reads and
writes it. Networks, templates and shape models are as their own files have them, see
:mod:`patterndb_sketch.features.files`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, NoReturn

from msgspec import Meta

from patterndb.geometry.points import Points
from patterndb.system.documents import JsonModel, JsonValue
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import (
    ConstraintModel,
    NetworkModel,
    constraints_of_models,
    models_of_constraints,
)
from patterndb_sketch.features.files.shapearrays import shape_bytes, shape_of
from patterndb_sketch.features.files.templatejson import TemplateModel
from patterndb_sketch.features.registration import FeatureCurves, Template
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines import Constraint, Spline
from patterndb_sketch.features.strokes import FeatureStroke, RecoveredCurve
from patterndb_sketch.sessions import SessionFormat


class SavedCurve(JsonModel):
    """A curve while it is worked on, see :class:`SessionCurve`."""

    name: str
    clicked: Points
    samples: Points
    constraints: list[ConstraintModel]
    spline: Spline
    settings: SnapSettings


class SavedFeatures(JsonModel):
    """What a session has. shapes: the bytes of the shape models' own files (.npz)."""

    mesh: Annotated[str, Meta(description="the name of a mesh file")]
    curves: list[SavedCurve]
    settings: SnapSettings
    networks: dict[str, NetworkModel]
    templates: dict[str, TemplateModel]
    shapes: dict[str, bytes]


@dataclass(frozen=True, slots=True, eq=False)
class SessionCurve:
    """A curve while it is worked on: what was clicked (c, 3), its samples (m, 3), the samples
    that were dragged and where to, the spline through them, closed if the curve is, its settings.
    """

    name: str
    clicked: Points
    samples: Points
    constraints: tuple[Constraint, ...]
    spline: Spline
    settings: SnapSettings = field(default_factory=SnapSettings)

    @property
    def stroke(self) -> FeatureStroke:
        """What was clicked, with the curve's settings; closed if the curve is."""
        return FeatureStroke(
            self.name, self.clicked, settings=self.settings, closed=self.spline.closed
        )


@dataclass(frozen=True, slots=True, eq=False)
class FeatureSession:
    """All that work on feature curves gives.

    mesh:     the name of the file of the model that the curves are on, "" if there is none.
    settings: of the next curve.
    """

    mesh: str = ""
    curves: tuple[SessionCurve, ...] = ()
    settings: SnapSettings = field(default_factory=SnapSettings)
    networks: Mapping[str, FeatureCurves] = field(default_factory=dict)
    templates: Mapping[str, Template] = field(default_factory=dict)
    shapes: Mapping[str, ShapeModel] = field(default_factory=dict)

    def with_curves(
        self, found: Sequence[RecoveredCurve], settings: SnapSettings
    ) -> FeatureSession:
        """Return the session with curves in place of those of their names, or after them.

        settings: of the next curve from now on; curves that stay keep their own.
        """
        curves = {one.name: one for one in self.curves}
        for one in found:
            curve = one.curve
            curves[one.name] = SessionCurve(
                one.name, one.stroke, curve.samples, curve.constraints, curve.spline,
                curve.settings,
            )  # fmt: skip
        return replace(self, curves=tuple(curves.values()), settings=settings)


def _save(session: FeatureSession) -> SavedFeatures:
    return SavedFeatures(
        session.mesh,
        [
            SavedCurve(
                one.name, one.clicked, one.samples, models_of_constraints(one.constraints),
                one.spline, one.settings,
            )
            for one in session.curves
        ],
        session.settings,
        {name: NetworkModel.of(one) for name, one in session.networks.items()},
        {name: TemplateModel.of(one) for name, one in session.templates.items()},
        {name: shape_bytes(one) for name, one in session.shapes.items()},
    )  # fmt: skip


def _open(saved: SavedFeatures, place: JsonValue) -> FeatureSession:
    """Return the session that a file has; raises InvalidFeatureError with the place in it."""
    if len({one.name for one in saved.curves}) < len(saved.curves):
        place.at("curves").fail("two curves have one name")
    shapes: dict[str, ShapeModel] = {}
    for name, content in saved.shapes.items():
        with place.at("shapes", name).named():
            shapes[name] = shape_of(content)
    templates: dict[str, Template] = {}
    for name, one in saved.templates.items():
        at = place.at("templates", name)
        with at.named():
            templates[name] = one.template(at, name, _refuse_mesh)
    return FeatureSession(
        saved.mesh,
        tuple(_open_curve(one, place.at("curves", i)) for i, one in enumerate(saved.curves)),
        saved.settings,
        {name: one.network(place.at("networks", name)) for name, one in saved.networks.items()},
        templates,
        shapes,
    )


def _open_curve(saved: SavedCurve, place: JsonValue) -> SessionCurve:
    for key, points in (("clicked", saved.clicked), ("samples", saved.samples)):
        if points.shape != (len(points), 3):
            place.at(key).fail("it must be a list of points [x, y, z]")
    at = place.at("constraints")
    constraints = constraints_of_models(saved.constraints, len(saved.samples), at)
    return SessionCurve(
        saved.name, saved.clicked, saved.samples, constraints, saved.spline, saved.settings
    )


def _refuse_mesh(path: Path) -> NoReturn:
    raise InvalidFeatureError(
        f'a session has the "quads" of its templates itself, not the name of a mesh file, {path}'
    )


FEATURE_SESSION: SessionFormat[FeatureSession, SavedFeatures] = SessionFormat(
    "feature curves", InvalidFeatureError, SavedFeatures, _save, _open
)
