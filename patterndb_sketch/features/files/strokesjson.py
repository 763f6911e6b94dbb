"""Strokes along features as plain JSON.

    {"strokes": [{"name": "roof_rail", "points": [[1.28, -0.64, 1.06], [1.9, -0.65, 1.08]],
                  "constraints": [{"at": [1.6, -0.65, 1.07]}],
                  "settings": {"alpha": 0.5, "axis": [0, 0, 1], "beta": 60}},
                 {"points": [[0.55, -0.8, 0.63], [1.28, -0.64, 1.06]]},
                 {"points": [[2, 0, 0.3], [2.3, 0, 0], [2, 0, -0.3], [1.7, 0, 0]], "closed": true}]}

points: two or more near the model, in the order of drawing. name: of the curve, by default its
place, "stroke 2". closed: whether the curve goes on from the last point to the first; by default
if the last point is the first again, as in rings of polygons. constraints: where the curve passes
exactly. settings: what this stroke has other than the rest, by the names of
:class:`patterndb_sketch.features.snap.SnapSettings`; beta is in degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import UNSET, Meta, UnsetType, structs
from msgspec import field as entry

from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    Point,
    Polyline,
    complete_points,
    encode_json,
    read_document,
)
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines.spline import MAX_DEGREE
from patterndb_sketch.features.strokes import FeatureStroke

#: Bytes that a file may have: a million points have some 40 million.
MAX_BYTES = 64_000_000

SETTINGS = tuple(one.name for one in fields(SnapSettings))

#: Settings that mean something only together: a file has all of them, or none.
ANGLE = {"alpha", "axis", "beta"}


class HeldModel(JsonModel):
    """A point where the curve passes."""

    at: Annotated[Point, Meta(extra={"missing": "the point where the curve passes"})]


class SettingsModel(JsonModel):
    """Settings that differ from the usual ones; beta in degrees, a nearness without end null."""

    alpha: Number | UnsetType = UNSET
    axis: Point | UnsetType = UNSET
    beta: Number | UnsetType = UNSET
    stiffness: Number | UnsetType = UNSET
    theta: Number | UnsetType = UNSET
    continuity: Number | UnsetType = UNSET
    strict: bool | UnsetType = UNSET
    window: Number | UnsetType = UNSET
    nearness: Number | UnsetType | None = UNSET
    degree: int | UnsetType = UNSET
    radius: Number | UnsetType = UNSET
    n_samples: int | UnsetType = UNSET
    rounds: int | UnsetType = UNSET


class FeatureStrokeModel(JsonModel):
    """A stroke and its curve's settings."""

    points: Annotated[Polyline, Meta(extra={"missing": "a list of two points or more"})]
    name: Annotated[str, Meta(description="the name of a curve")] | UnsetType = UNSET
    constraints: list[
        Annotated[HeldModel, Meta(description='an object such as {"at": [x, y, z]}')]
    ] = entry(default_factory=list)
    settings: SettingsModel | UnsetType = UNSET
    closed: bool | UnsetType = UNSET


class StrokesModel(JsonModel):
    """All strokes of a file."""

    strokes: Annotated[list[FeatureStrokeModel], Meta(extra={"missing": "a list of strokes"})]


def read_strokes(
    path: Path | str, settings: SnapSettings | None = None
) -> tuple[FeatureStroke, ...]:
    """Return the strokes in a JSON file; settings: those of strokes that have none of their own.

    Raises InvalidFeatureError with the file, the place in it and what is wrong; OSError.
    """

    def read(document: JsonValue) -> tuple[FeatureStroke, ...]:
        return _strokes(document, SnapSettings() if settings is None else settings)

    return read_document(Path(path), MAX_BYTES, InvalidFeatureError, "strokes", read)


def write_strokes(path: Path | str, strokes: Sequence[FeatureStroke]) -> None:
    """Write strokes; :func:`read_strokes` gives them back. Raises OSError.

    Settings that are the usual ones are left out, except those of an angle that has others.
    """
    replace_file(Path(path), encode_json({"strokes": [_document(stroke) for stroke in strokes]}))


def _strokes(document: JsonValue, usual: SnapSettings) -> tuple[FeatureStroke, ...]:
    found = document.read(StrokesModel, 'an object such as {"strokes": [{"points": [...]}]}')
    result: list[FeatureStroke] = []
    for i, one in enumerate(found.strokes):
        place = document.at("strokes", i)
        name = f"stroke {i + 1}" if one.name is UNSET else one.name
        if not name:
            place.at("name").fail("the name is empty; leave it out")
        if any(name == other.name for other in result):
            place.fail(f"there is another stroke {name!r}; give each a name of its own")
        chosen = usual
        if one.settings is not UNSET:
            chosen = settings_of_model(one.settings, usual, place.at("settings"))
        held = np.array(complete_points(held.at for held in one.constraints)).reshape(-1, 3)
        points = np.array(complete_points(one.points))
        closed = None if one.closed is UNSET else one.closed
        result.append(FeatureStroke(name, points, held, chosen, closed))
    if not result:
        document.at("strokes").fail("there is no stroke; give one or more")
    return tuple(result)


def model_of_settings(settings: SnapSettings) -> SettingsModel:
    """Return all settings as files have them."""
    values: dict[str, Any] = {name: getattr(settings, name) for name in SETTINGS}
    values["axis"] = list(settings.axis)
    values["beta"] = float(np.rad2deg(settings.beta))
    return SettingsModel(**values)


def settings_of_model(found: SettingsModel, usual: SnapSettings, place: JsonValue) -> SnapSettings:
    """Return the usual settings with those of a file in their place; raises its place's error."""
    changes: dict[str, Any] = {
        name: value for name, value in structs.asdict(found).items() if value is not UNSET
    }
    if found.axis is not UNSET:
        changes["axis"] = tuple(complete_points([found.axis])[0])
        if not any(found.axis):
            place.at("axis").fail("the axis has no length; give a direction such as [0, 0, 1]")
    if found.beta is not UNSET:
        changes["beta"] = float(np.deg2rad(found.beta))
    with place.named():
        result = replace(usual, **changes)
        if not 1 <= result.degree <= MAX_DEGREE:
            raise InvalidFeatureError(f"degree is {result.degree}; give 1 to {MAX_DEGREE}")
        return result


def _document(stroke: FeatureStroke) -> dict[str, object]:
    document: dict[str, object] = {"name": stroke.name, "points": stroke.points.tolist()}
    if stroke.closed is not None:
        document["closed"] = stroke.closed
    if len(stroke.held):
        document["constraints"] = [{"at": point} for point in stroke.held.tolist()]
    ours, usual = (
        structs.asdict(model_of_settings(one)) for one in (stroke.settings, SnapSettings())
    )
    other = {name: value for name, value in ours.items() if value != usual[name]}
    if not ANGLE.isdisjoint(other):
        other = {name: value for name, value in ours.items() if name in other or name in ANGLE}
    if other:
        document["settings"] = other
    return document
