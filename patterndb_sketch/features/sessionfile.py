"""Files of feature curves: networks, templates, shape models, and sessions that have them all.

A session is one zip file. session.json in it is

    {"format": "patterndb feature session", "version": 1, "mesh": "sedan.obj",
     "curves": [{"name": "roof_rail", "clicked": [[1, -0.6, 1], ...], "samples": [[...], ...],
                 "constraints": [{"sample": 4, "point": [1.3, -0.6, 1.1]}],
                 "spline": {"degree": 3, "knots": [...], "control_points": [...]}}, ...],
     "settings": {"alpha": 0.5},
     "networks": {"sedan": {"curves": {...}}}, "templates": {"car": {"quads": [...], ...}},
     "shapes": {"cars": "shapes/0.npz"}}

with networks, templates and shape models as :mod:`patterndb_sketch.features.files` has them.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.system.archives import read_members
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    Point,
    complete_points,
    name_file,
    parse_json,
    read_limited,
)
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.curvesjson import constraints_of
from patterndb_sketch.features.files.networkjson import curve_of, drawn_network, network_document
from patterndb_sketch.features.files.shapearrays import MAX_BYTES as MAX_SHAPE_BYTES
from patterndb_sketch.features.files.shapearrays import shape_bytes, shape_of
from patterndb_sketch.features.files.templatejson import mesh_name, template_document, template_of
from patterndb_sketch.features.registration import FeatureCurves, Template, template_of_name
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines import Constraint, Spline
from patterndb_sketch.features.strokes import FeatureStroke, RecoveredCurve

#: Bytes that a file of JSON may have: a template of a million quads has some 40 million.
MAX_BYTES = 64_000_000

#: Entries of a zip, at most: one for each shape model.
MAX_ENTRIES = 1_000

FORMAT, VERSION = "patterndb feature session", 1
JSON_NAME = "session.json"

#: A mesh file's reader, which knows the formats.
MeshReader = Callable[[Path], PolygonMesh]


class FeatureCurveEntries(JsonModel):
    """constraints, spline: as :mod:`patterndb_sketch.features.files.curvesjson` has them."""

    name: str
    clicked: list[Point]
    samples: list[Point]
    constraints: Any
    spline: Any


class FeatureSessionEntries(JsonModel):
    """networks, templates: as :mod:`patterndb_sketch.features.files` has them."""

    format: str
    version: int
    mesh: Annotated[str, Meta(description="the name of a mesh file")]
    curves: list[FeatureCurveEntries]
    settings: dict[str, Number]
    networks: dict[str, Any]
    templates: dict[str, Any]
    shapes: dict[str, Annotated[str, Meta(description="the name of an entry of the zip")]]


@dataclass(frozen=True, slots=True, eq=False)
class SessionCurve:
    """A curve while it is worked on: what was clicked (c, 3), its samples (m, 3), the samples
    that were dragged and where to, and the spline through them, closed if the curve is."""

    name: str
    clicked: Points
    samples: Points
    constraints: tuple[Constraint, ...]
    spline: Spline


@dataclass(frozen=True, slots=True, eq=False)
class FeatureSession:
    """All that work on feature curves gives.

    mesh:     the name of the file of the model that the curves are on, "" if there is none.
    settings: numbers by name, such as those of sliders.
    """

    mesh: str = ""
    curves: tuple[SessionCurve, ...] = ()
    settings: Mapping[str, float] = field(default_factory=dict)
    networks: Mapping[str, FeatureCurves] = field(default_factory=dict)
    templates: Mapping[str, Template] = field(default_factory=dict)
    shapes: Mapping[str, ShapeModel] = field(default_factory=dict)


def read_network(path: Path | str) -> FeatureCurves:
    """The network of curves in a JSON file, see :mod:`patterndb_sketch.features.files.networkjson`.

    Raises InvalidFeatureError that names the file and the place in it, says what is wrong and
    what would mend it; OSError as reading does.
    """
    path = Path(path)
    with name_file(path, InvalidFeatureError):
        return drawn_network(_json(_content(path), "a network of curves"))


def write_network(path: Path | str, network: FeatureCurves) -> None:
    """Write a network; :func:`read_network` gives it back. OSError as writing does."""
    _write_json(Path(path), network_document(network))


def read_template(name: Path | str, read_mesh: MeshReader) -> Template:
    """The template of a name such as box:car?r=11, else that in a JSON file.

    See :func:`patterndb_sketch.features.registration.boxes.template_of_name` and
    :mod:`patterndb_sketch.features.files.templatejson`. read_mesh: reads the mesh that the file
    names. Raises as :func:`read_network` does, and what read_mesh does.
    """
    if isinstance(name, str) and name.startswith("box:"):
        return template_of_name(name)
    path = Path(name)
    with name_file(path, InvalidFeatureError):
        document = _json(_content(path), "a template")
        mesh = mesh_name(document)
        return template_of(document, read_mesh(path.parent / mesh) if mesh else None, path.stem)


def write_template(path: Path | str, template: Template) -> None:
    """Write a template with its quads; :func:`read_template` gives it back."""
    _write_json(Path(path), template_document(template))


def read_shapes(path: Path | str) -> ShapeModel:
    """The shape model in a file, see :mod:`patterndb_sketch.features.files.shapearrays`.

    Raises as :func:`read_network` does.
    """
    path = Path(path)
    with name_file(path, InvalidFeatureError):
        limit = MAX_SHAPE_BYTES
        return shape_of(read_limited(path, limit, InvalidFeatureError, "keep fewer modes"))


def write_shapes(path: Path | str, model: ShapeModel) -> None:
    """Write a shape model; :func:`read_shapes` gives it back bit for bit."""
    replace_file(Path(path), shape_bytes(model))


def read_session(path: Path | str) -> FeatureSession:
    """The session in a file. Raises as :func:`read_network` does."""
    path = Path(path)
    with name_file(path, InvalidFeatureError):
        limit = MAX_SHAPE_BYTES
        return parse_session(read_limited(path, limit, InvalidFeatureError, "keep fewer modes"))


def write_session(path: Path | str, session: FeatureSession) -> None:
    """Write a session; :func:`read_session` gives it back bit for bit. OSError as writing does."""
    replace_file(Path(path), session_bytes(session))


def session_bytes(session: FeatureSession) -> bytes:
    """The file of a session; the same session gives the same bytes."""
    places = {name: f"shapes/{i}.npz" for i, name in enumerate(session.shapes)}
    document: dict[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "mesh": session.mesh,
        "curves": [_curve_document(one) for one in session.curves],
        "settings": dict(session.settings),
        "networks": {name: network_document(one) for name, one in session.networks.items()},
        "templates": {name: template_document(one) for name, one in session.templates.items()},
        "shapes": places,
    }
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        # An entry without a date of its own is of 1980: the same session gives the same file.
        _add(archive, JSON_NAME, _text(document).encode())
        for name, place in places.items():
            _add(archive, place, shape_bytes(session.shapes[name]))
    return file.getvalue()


def parse_session(data: bytes) -> FeatureSession:
    """As :func:`read_session`, of a file's content; messages do not name a file."""
    content = read_members(
        data,
        InvalidFeatureError,
        "a session",
        max_bytes=MAX_SHAPE_BYTES,
        max_members=MAX_ENTRIES,
    )
    if JSON_NAME not in content:
        raise InvalidFeatureError(f"{JSON_NAME} is missing in the session's zip")
    document = _json(content.pop(JSON_NAME), "a session")
    entries = document.read(FeatureSessionEntries)
    if (entries.format, entries.version) != (FORMAT, VERSION):
        document.fail(
            f"the format is {entries.format!r} {entries.version}; this reads {FORMAT!r} {VERSION}"
        )
    curves = tuple(_curve(document.at("curves", i), one) for i, one in enumerate(entries.curves))
    names = [one.name for one in curves]
    if len(set(names)) < len(names):
        document.at("curves").fail("two curves have one name")
    shapes: dict[str, ShapeModel] = {}
    for name, at in entries.shapes.items():
        place = document.at("shapes", name)
        if at not in content:
            place.fail(f"there is no entry {at!r} in the zip that is not taken yet")
        with place.named():
            shapes[name] = shape_of(content.pop(at))
    if content:
        raise InvalidFeatureError(
            f"the session's zip has {sorted(content)[0]!r}, which {JSON_NAME} does not name"
        )
    return FeatureSession(
        entries.mesh,
        curves,
        entries.settings,
        {name: drawn_network(document.at("networks", name)) for name in entries.networks},
        {name: _template(name, document.at("templates", name)) for name in entries.templates},
        shapes,
    )


def _curve_document(curve: SessionCurve) -> dict[str, object]:
    return {
        "name": curve.name,
        "clicked": curve.clicked.tolist(),
        "samples": curve.samples.tolist(),
        "constraints": [
            {"sample": number, "point": np.asarray(point, np.float64).tolist()}
            for number, point in curve.constraints
        ],
        "spline": curve.spline.as_document(),
    }


def _curve(place: JsonValue, entries: FeatureCurveEntries) -> SessionCurve:
    clicked, samples = (
        np.array(complete_points(points)).reshape(-1, 3)
        for points in (entries.clicked, entries.samples)
    )
    constraints = constraints_of(place.at("constraints"), len(samples))
    spline = curve_of(place.at("spline"))
    return SessionCurve(entries.name, clicked, samples, constraints, spline)


def _template(name: str, value: JsonValue) -> Template:
    if mesh_name(value) is not None:
        value.fail('a session has the "quads" of its templates itself, not a mesh file\'s name')
    with value.named():
        return template_of(value, None, name)


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name)
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, content)


def _content(path: Path) -> bytes:
    return read_limited(path, MAX_BYTES, InvalidFeatureError, "give fewer points")


def _json(data: bytes, what: str) -> JsonValue:
    return parse_json(data, InvalidFeatureError, what)


def _text(document: dict[str, object]) -> str:
    return json.dumps(document, separators=(",", ":"), allow_nan=False) + "\n"


def _write_json(path: Path, document: dict[str, object]) -> None:
    replace_file(path, _text(document))


# Settings, as a session keeps them: numbers by name. "alpha" is that of curves that have none of
# their own, "roof_rail: alpha" that of one curve.


#

#: Settings that are one number each, whole numbers, and what the axis is written as. beta is in
#: degrees, strict 0 or 1.
NUMBERS = ("alpha", "stiffness", "theta", "continuity", "window", "nearness", "radius")
WHOLE = ("degree", "n_samples", "rounds")
AXES = ("axis x", "axis y", "axis z")

#: Stands for a nearness without end, as JSON has none.
ENDLESS = 1e300


def settings_numbers(settings: SnapSettings) -> dict[str, float]:
    """All settings as numbers by name."""
    numbers = {name: float(getattr(settings, name)) for name in (*NUMBERS, *WHOLE)}
    numbers["nearness"] = min(numbers["nearness"], ENDLESS)
    numbers["strict"] = float(settings.strict)
    numbers["beta"] = float(np.rad2deg(settings.beta))
    return numbers | dict(zip(AXES, map(float, settings.axis), strict=True))


def own_numbers(name: str, settings: SnapSettings, usual: SnapSettings) -> dict[str, float]:
    """What the curve of this name has other than usual, with its name before each."""
    known = settings_numbers(usual)
    return {
        f"{name}: {key}": value
        for key, value in settings_numbers(settings).items()
        if value != known[key]
    }


def settings_of_numbers(
    numbers: Mapping[str, float], usual: SnapSettings, name: str | None = None
) -> SnapSettings:
    """The settings in a session's numbers, the usual ones for those that it does not have.

    name: of a curve, for what it has of its own. Raises InvalidFeatureError for numbers out of
    range.
    """
    prefix = "" if name is None else f"{name}: "
    known = settings_numbers(usual)
    of = {key: numbers.get(prefix + key, value) for key, value in known.items()}
    for key in WHOLE:
        if of[key] % 1:
            raise InvalidFeatureError(f"settings.{prefix}{key} is {of[key]}; give a whole number")
    # An angle that is not changed keeps its last digit.
    beta = usual.beta if of["beta"] == known["beta"] else float(np.deg2rad(of["beta"]))
    return SnapSettings(
        alpha=of["alpha"],
        axis=(of["axis x"], of["axis y"], of["axis z"]),
        beta=beta,
        stiffness=of["stiffness"],
        theta=of["theta"],
        continuity=of["continuity"],
        strict=bool(of["strict"]),
        window=of["window"],
        nearness=np.inf if of["nearness"] >= ENDLESS else of["nearness"],
        degree=int(of["degree"]),
        radius=of["radius"],
        n_samples=int(of["n_samples"]),
        rounds=int(of["rounds"]),
    )


def session_strokes(
    session: FeatureSession, usual: SnapSettings
) -> list[tuple[FeatureStroke, tuple[Constraint, ...]]]:
    """What was clicked and what was dragged of every curve, closed if it is, with the curve's own
    settings, the usual ones where it has none.

    Raises InvalidFeatureError for settings out of range.
    """
    numbers = session.settings
    return [
        (
            FeatureStroke(
                one.name,
                one.clicked,
                settings=settings_of_numbers(numbers, usual, one.name),
                closed=one.spline.closed,
            ),
            one.constraints,
        )
        for one in session.curves
    ]


def with_curves(
    session: FeatureSession, found: Sequence[RecoveredCurve], usual: SnapSettings
) -> FeatureSession:
    """The session with curves in place of those of their names, or after them.

    usual: the settings that the session has from now on for all curves.
    """
    before = settings_of_numbers(session.settings, SnapSettings())
    numbers = dict(session.settings) | settings_numbers(usual)
    curves: dict[str, SessionCurve] = {}
    for one in session.curves:
        # Curves that stay have the settings that they had, whatever the others have now.
        own = settings_of_numbers(session.settings, before, one.name)
        numbers = _with_own(numbers, one.name, own, usual)
        curves[one.name] = one
    for one in found:
        curve = one.curve
        numbers = _with_own(numbers, one.name, curve.settings, usual)
        curves[one.name] = SessionCurve(
            one.name, one.stroke, curve.samples, curve.constraints, curve.spline
        )
    return replace(session, curves=tuple(curves.values()), settings=numbers)


def _with_own(
    numbers: dict[str, float], name: str, own: SnapSettings, usual: SnapSettings
) -> dict[str, float]:
    old = {f"{name}: {key}" for key in settings_numbers(usual)}
    kept = {key: value for key, value in numbers.items() if key not in old}
    return kept | own_numbers(name, own, usual)
