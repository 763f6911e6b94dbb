"""Strokes along features as plain JSON.

    {"strokes": [{"name": "roof_rail", "points": [[1.28, -0.64, 1.06], [1.9, -0.65, 1.08]],
                  "constraints": [{"at": [1.6, -0.65, 1.07]}],
                  "settings": {"alpha": 0.5, "axis": [0, 0, 1], "beta": 60}},
                 {"points": [[0.55, -0.8, 0.63], [1.28, -0.64, 1.06]]}]}

points: two or more near the model, in the order of drawing. name: of the curve, by default its
place, "stroke 2". constraints: where the curve passes exactly. settings: what this stroke has
other than the rest, by the names of :class:`patterndb_sketch.features.snap.SnapSettings`; beta is
in degrees.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from patterndb.system.documents import JsonValue, parse_json, read_limited
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.sessioncurves import WHOLE
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines.spline import MAX_DEGREE
from patterndb_sketch.features.strokes import FeatureStroke

#: Bytes that a file may have: a million points have some 40 million.
MAX_BYTES = 64_000_000

KEYS = ("strokes",)
STROKE_KEYS = ("name", "points", "constraints", "settings")
SETTINGS = tuple(one.name for one in fields(SnapSettings))

#: Settings that mean something only together: a file has all of them, or none.
ANGLE = {"alpha", "axis", "beta"}


def read_strokes(
    path: Path | str, settings: SnapSettings | None = None
) -> tuple[FeatureStroke, ...]:
    """The strokes in a JSON file; settings: those of strokes that have none of their own.

    Raises InvalidFeatureError that names the file and the place in it, says what is wrong and
    what would mend it; OSError as reading does.
    """
    with file_named(Path(path)):
        data = read_limited(Path(path), MAX_BYTES, InvalidFeatureError, "give fewer points")
        return strokes_of(parse_json(data, InvalidFeatureError, "strokes"), settings)


def write_strokes(path: Path | str, strokes: Sequence[FeatureStroke]) -> None:
    """Write strokes; :func:`read_strokes` gives them back. OSError as writing does."""
    text = json.dumps(strokes_document(strokes), separators=(",", ":"), allow_nan=False)
    replace_file(Path(path), text + "\n")


def strokes_of(
    document: JsonValue, settings: SnapSettings | None = None
) -> tuple[FeatureStroke, ...]:
    """The strokes in a document. Raises InvalidFeatureError that names the place in it."""
    entries = document.entries(KEYS, 'an object such as {"strokes": [{"points": [...]}]}')
    if "strokes" not in entries:
        document.fail('"strokes" is missing: a list of strokes')
    usual = SnapSettings() if settings is None else settings
    result: list[FeatureStroke] = []
    for number, one in enumerate(entries["strokes"].items("a list of strokes"), 1):
        stroke = _stroke(one, f"stroke {number}", usual)
        if any(stroke.name == other.name for other in result):
            one.fail(f"there is another stroke {stroke.name!r}; give each a name of its own")
        result.append(stroke)
    if not result:
        entries["strokes"].fail("there is no stroke; give one or more")
    return tuple(result)


def strokes_document(strokes: Sequence[FeatureStroke]) -> dict[str, object]:
    """Strokes as plain JSON has them; settings that are the usual ones are
    left out, but for those of an angle that has others."""
    return {"strokes": [_document(stroke) for stroke in strokes]}


def settings_of(value: JsonValue, usual: SnapSettings) -> SnapSettings:
    """Settings with those of an object in place of the usual ones."""
    changes: dict[str, object] = {}
    for name, entry in value.entries(SETTINGS).items():
        if name == "axis":
            changes[name] = tuple(entry.point())
            if not any(entry.point()):
                entry.fail("the axis has no length; give a direction such as [0, 0, 1]")
        elif name == "strict":
            changes[name] = entry.truth()
        elif name in WHOLE:
            changes[name] = entry.whole()
        elif name == "beta":
            changes[name] = float(np.deg2rad(entry.number()))
        elif name == "nearness" and entry.value is None:
            changes[name] = np.inf
        else:
            changes[name] = entry.number()
    with in_place(value):
        found = replace(usual, **changes)
        if not 1 <= found.degree <= MAX_DEGREE:
            raise InvalidFeatureError(f"degree is {found.degree}; give 1 to {MAX_DEGREE}")
        return found


def settings_document(settings: SnapSettings) -> dict[str, object]:
    """All settings as JSON has them: beta in degrees, a nearness without end as null."""
    document: dict[str, object] = {name: getattr(settings, name) for name in SETTINGS}
    document["axis"] = list(settings.axis)
    document["beta"] = float(np.rad2deg(settings.beta))
    if settings.nearness == np.inf:
        document["nearness"] = None
    return document


@contextmanager
def in_place(value: JsonValue) -> Generator[None]:
    """What goes wrong inside is about a value of a document."""
    try:
        yield
    except InvalidFeatureError as error:
        if value.where and str(error).startswith(value.where):
            raise
        value.fail(str(error))


@contextmanager
def file_named(path: Path) -> Generator[None]:
    """What goes wrong inside is about a file."""
    try:
        yield
    except InvalidFeatureError as error:
        raise InvalidFeatureError(f"{path}: {error}") from None


def _stroke(value: JsonValue, name: str, usual: SnapSettings) -> FeatureStroke:
    entries = value.entries(STROKE_KEYS)
    if "points" not in entries:
        value.fail('"points" is missing: a list of two points or more')
    points = np.array(entries["points"].polyline())
    held: list[list[float]] = []
    for one in entries["constraints"].items() if "constraints" in entries else ():
        parts = one.entries(("at",), 'an object such as {"at": [x, y, z]}')
        if "at" not in parts:
            one.fail('"at" is missing: the point where the curve passes')
        held.append(parts["at"].point())
    if "name" in entries:
        name = entries["name"].text("the name of a curve")
        if not name:
            entries["name"].fail("the name is empty; leave it out")
    chosen = settings_of(entries["settings"], usual) if "settings" in entries else usual
    return FeatureStroke(name, points, np.array(held).reshape(-1, 3), chosen)


def _document(stroke: FeatureStroke) -> dict[str, object]:
    document: dict[str, object] = {"name": stroke.name, "points": stroke.points.tolist()}
    if len(stroke.held):
        document["constraints"] = [{"at": point} for point in stroke.held.tolist()]
    ours, usual = settings_document(stroke.settings), settings_document(SnapSettings())
    other = {name: value for name, value in ours.items() if value != usual[name]}
    if not ANGLE.isdisjoint(other):
        other = {name: value for name, value in ours.items() if name in other or name in ANGLE}
    if other:
        document["settings"] = other
    return document
