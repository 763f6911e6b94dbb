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
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.system.documents import JsonValue, parse_json, read_limited
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import curve_of, drawn_network, network_document
from patterndb_sketch.features.files.shapearrays import MAX_BYTES as MAX_SHAPE_BYTES
from patterndb_sketch.features.files.shapearrays import shape_bytes, shape_of
from patterndb_sketch.features.files.templatejson import mesh_name, template_document, template_of
from patterndb_sketch.features.registration import DrawnNetwork, Template, template_of_name
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.splines import Constraint, Spline

#: Bytes that a file of JSON may have: a template of a million quads has some 40 million.
MAX_BYTES = 64_000_000

#: Entries of a zip, at most: one for each shape model.
MAX_ENTRIES = 1_000

FORMAT, VERSION = "patterndb feature session", 1
JSON_NAME = "session.json"
KEYS = ("format", "version", "mesh", "curves", "settings", "networks", "templates", "shapes")
CURVE_KEYS = ("name", "clicked", "samples", "constraints", "spline")
CONSTRAINT_KEYS = ("sample", "point")

#: A mesh file's reader, which knows the formats.
MeshReader = Callable[[Path], PolygonMesh]


@dataclass(frozen=True, slots=True, eq=False)
class SessionCurve:
    """A curve while it is worked on: what was clicked (c, 3), its samples (m, 3), the samples
    that were dragged and where to, and the spline through them."""

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
    networks: Mapping[str, DrawnNetwork] = field(default_factory=dict)
    templates: Mapping[str, Template] = field(default_factory=dict)
    shapes: Mapping[str, ShapeModel] = field(default_factory=dict)


def read_network(path: Path | str) -> DrawnNetwork:
    """The network of curves in a JSON file, see :mod:`patterndb_sketch.features.files.networkjson`.

    Raises InvalidFeatureError that names the file and the place in it, says what is wrong and
    what would mend it; OSError as reading does.
    """
    path = Path(path)
    with _named(path):
        return drawn_network(_json(_content(path), "a network of curves"))


def write_network(path: Path | str, network: DrawnNetwork) -> None:
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
    with _named(path):
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
    with _named(path):
        limit = MAX_SHAPE_BYTES
        return shape_of(read_limited(path, limit, InvalidFeatureError, "keep fewer modes"))


def write_shapes(path: Path | str, model: ShapeModel) -> None:
    """Write a shape model; :func:`read_shapes` gives it back bit for bit."""
    replace_file(Path(path), shape_bytes(model))


def read_session(path: Path | str) -> FeatureSession:
    """The session in a file. Raises as :func:`read_network` does."""
    path = Path(path)
    with _named(path):
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
    content = _members(data)
    if JSON_NAME not in content:
        raise InvalidFeatureError(f"{JSON_NAME} is missing in the session's zip")
    document = _json(content.pop(JSON_NAME), "a session")
    entries = document.entries(KEYS)
    for key in KEYS:
        if key not in entries:
            document.fail(f'"{key}" is missing in {JSON_NAME}')
    if entries["format"].text() != FORMAT or entries["version"].whole() != VERSION:
        document.fail(
            f"the format is {entries['format'].value!r} {entries['version'].value}; this reads "
            f"{FORMAT!r} {VERSION}"
        )
    curves = tuple(_curve(one) for one in entries["curves"].items())
    names = [one.name for one in curves]
    if len(set(names)) < len(names):
        entries["curves"].fail("two curves have one name")
    shapes: dict[str, ShapeModel] = {}
    for name, place in entries["shapes"].entries().items():
        at = place.text("the name of an entry of the zip")
        if at not in content:
            place.fail(f"there is no entry {at!r} in the zip that is not taken yet")
        shapes[name] = _shape(content.pop(at), place)
    if content:
        raise InvalidFeatureError(
            f"the session's zip has {sorted(content)[0]!r}, which {JSON_NAME} does not name"
        )
    return FeatureSession(
        entries["mesh"].text("the name of a mesh file"),
        curves,
        {name: one.number() for name, one in entries["settings"].entries().items()},
        {name: drawn_network(one) for name, one in entries["networks"].entries().items()},
        {name: _template(name, one) for name, one in entries["templates"].entries().items()},
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


def _curve(value: JsonValue) -> SessionCurve:
    entries = value.entries(CURVE_KEYS)
    for key in CURVE_KEYS:
        if key not in entries:
            value.fail(f'"{key}" is missing; a curve has {", ".join(CURVE_KEYS)}')
    samples = np.array(entries["samples"].points()).reshape(-1, 3)
    constraints: list[Constraint] = []
    for one in entries["constraints"].items():
        parts = one.entries(CONSTRAINT_KEYS)
        if len(parts) < len(CONSTRAINT_KEYS):
            one.fail("a constraint has the number of a sample and a point")
        number = parts["sample"].whole("the number of a sample")
        if not 0 <= number < len(samples):
            parts["sample"].fail(f"there is no sample {number}; there are {len(samples)}, from 0")
        constraints.append((number, np.array(parts["point"].point())))
    return SessionCurve(
        entries["name"].text(),
        np.array(entries["clicked"].points()).reshape(-1, 3),
        samples,
        tuple(constraints),
        curve_of(entries["spline"]),
    )


def _template(name: str, value: JsonValue) -> Template:
    if mesh_name(value) is not None:
        value.fail('a session has the "quads" of its templates itself, not a mesh file\'s name')
    try:
        return template_of(value, None, name)
    except InvalidFeatureError as error:
        raise InvalidFeatureError(f"{value.where}: {error}") from None


def _shape(data: bytes, place: JsonValue) -> ShapeModel:
    try:
        return shape_of(data)
    except InvalidFeatureError as error:
        place.fail(str(error))


def _members(data: bytes) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len({one.filename for one in members}) < len(members):
                raise InvalidFeatureError("the session's zip has two entries of one name")
            size = sum(one.file_size for one in members)
            if len(members) > MAX_ENTRIES or size > MAX_SHAPE_BYTES:
                raise InvalidFeatureError(
                    f"the session's zip has {len(members)} entries of {size:,} bytes; limits are "
                    f"{MAX_ENTRIES} and {MAX_SHAPE_BYTES:,}"
                )
            return {one.filename: archive.read(one) for one in members}
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as reason:
        raise InvalidFeatureError(
            f"this is no session, which is a zip file with {JSON_NAME}: {reason}"
        ) from None


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


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """What goes wrong inside is about a file."""
    try:
        yield
    except PatternDBError as error:
        raise InvalidFeatureError(f"{path}: {error}") from None
