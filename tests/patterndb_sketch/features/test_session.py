"""Files of networks, templates, shape models and sessions: what is written is read back."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import (
    FIT,
    read_network,
    spline_through,
    write_network,
)
from patterndb_sketch.features.files.shapearrays import (
    read_shapes,
    shape_bytes,
    shape_of,
    write_shapes,
)
from patterndb_sketch.features.files.templatejson import read_template, write_template
from patterndb_sketch.features.registration import FeatureCurves, Template
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines import Spline
from tests.support.features.registration import sheet
from tests.support.features.sessions import make_session, make_shape_model


def no_mesh(path: Path) -> PolygonMesh:
    raise AssertionError(f"{path} was asked for")


def same_spline(a: Spline, b: Spline) -> bool:
    return a.degree == b.degree and np.array_equal(a.knots, b.knots) and np.array_equal(
        a.control, b.control
    )  # fmt: skip


def same_network(a: FeatureCurves, b: FeatureCurves) -> bool:
    return (
        list(a.curves) == list(b.curves)
        and all(same_spline(a.curves[name], b.curves[name]) for name in a.curves)
        and a.meet == b.meet
        and a.tolerance == b.tolerance
        and list(a.near) == list(b.near)
        and all(np.array_equal(a.near[name], b.near[name]) for name in a.near)
    )


def same_template(a: Template, b: Template) -> bool:
    chains = zip(a.chains, b.chains, strict=True)
    return (
        (a.name, a.parts, a.bridged) == (b.name, b.parts, b.bridged)
        and np.array_equal(a.quads, b.quads)
        and np.array_equal(a.of_part, b.of_part)
        and np.array_equal(a.plane, b.plane)
        and all(
            (c.name, c.steps) == (d.name, d.steps) and np.array_equal(c.vertices, d.vertices)
            for c, d in chains
        )
    )


def same_shapes(a: ShapeModel, b: ShapeModel) -> bool:
    arrays = ("mean", "modes", "deviations", "coefficients", "quads")
    return (
        all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
        and (a.variance, a.names, a.template) == (b.variance, b.names, b.template)
        and all(
            c.name == d.name and np.array_equal(c.vertices, d.vertices)
            for c, d in zip(a.features, b.features, strict=True)
        )
    )


def test_a_session_is_read_back_bit_for_bit(tmp_path: Path) -> None:
    """Curves, constraints, networks, templates and shape models, in one file; and the same
    session gives the same bytes."""
    path, given_ = tmp_path / "work.session", make_session()
    FEATURE_SESSION.write(path, given_)
    found = FEATURE_SESSION.read(path)
    assert found.mesh == given_.mesh and found.settings == given_.settings
    for a, b in zip(found.curves, given_.curves, strict=True):
        assert a.name == b.name and same_spline(a.spline, b.spline) and a.settings == b.settings
        assert np.array_equal(a.clicked, b.clicked) and np.array_equal(a.samples, b.samples)
        assert [n for n, _ in a.constraints] == [n for n, _ in b.constraints]
        for (_, p), (_, q) in zip(a.constraints, b.constraints, strict=True):
            assert np.array_equal(p, q)
    for kind, same in (
        ("networks", same_network), ("templates", same_template), ("shapes", same_shapes)
    ):  # fmt: skip
        one, two = getattr(found, kind), getattr(given_, kind)
        assert list(one) == list(two) and all(same(one[name], two[name]) for name in one)
    assert (
        FEATURE_SESSION.encode(found) == path.read_bytes() == FEATURE_SESSION.encode(make_session())
    )


def test_an_empty_session_is_one() -> None:
    assert FEATURE_SESSION.decode(FEATURE_SESSION.encode(FeatureSession())).curves == ()


def test_single_files_are_read_back(tmp_path: Path) -> None:
    given_ = make_session()
    write_network(tmp_path / "n.json", given_.networks["one"])
    assert same_network(read_network(tmp_path / "n.json"), given_.networks["one"])
    write_template(tmp_path / "t.json", given_.templates["car"])
    assert same_template(read_template(tmp_path / "t.json", no_mesh), given_.templates["car"])
    write_shapes(tmp_path / "s.npz", given_.shapes["cars"])
    assert same_shapes(read_shapes(tmp_path / "s.npz"), given_.shapes["cars"])
    # Any numpy reads it, without running anything.
    with np.load(tmp_path / "s.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["mean"], given_.shapes["cars"].mean)


def test_a_template_may_be_a_name_or_have_its_quads_in_a_mesh_file(tmp_path: Path) -> None:
    assert read_template("box:roof?r=4", no_mesh).name == "box:roof?r=4"
    path = tmp_path / "dome.json"
    write_template(path, sheet(4))
    document = json.loads(path.read_text())
    quads = np.array(document.pop("quads"), np.int32)
    path.write_text(json.dumps(document | {"mesh": "dome.obj"}))
    asked: list[Path] = []

    def read(place: Path) -> PolygonMesh:
        asked.append(place)
        return PolygonMesh(np.zeros((16, 3)), quads.ravel(), 4 * np.arange(len(quads) + 1))

    assert same_template(read_template(path, read), sheet(4))
    assert asked == [tmp_path / "dome.obj"]

    def triangle(place: Path) -> PolygonMesh:
        return PolygonMesh(np.zeros((3, 3)), np.arange(3, dtype=np.int32), np.array([0, 3]))

    with pytest.raises(InvalidFeatureError, match=r"dome\.json: face 0 .* has 3 corners"):
        read_template(path, triangle)


@pytest.mark.parametrize("k", [2, 3, 7, 12, 40, 200])
def test_a_polyline_becomes_a_spline_that_follows_it(k: int) -> None:
    """At every point, to a small share of its length; its ends to the last digits."""
    t = np.linspace(0.0, 3.0, k)
    points: Points = np.stack([np.cos(2.0 * t), np.sin(3.0 * t), t], axis=1)
    curve = spline_through(points)
    dense = curve.sample(4_001)
    away = np.linalg.norm(dense[:, None] - points[None], axis=2).min(axis=0)
    assert away.max() < 1.05 * FIT * curve.length + curve.length / 4_000
    assert curve.control[[0, -1]] == pytest.approx(points[[0, -1]], abs=1e-9)


NETWORKS = {
    '{"curve": {}}': "curve: there is no such entry",
    "[]": "a list is not an object",
    "{}": '"curves" is missing',
    '{"curves": {}}': "there is no curve",
    '{"curves": {"a": [[0,0,0]]}}': r"curves\.a: a polyline needs two points",
    '{"curves": {"a": [[0,0,0],[0,0,0]]}}': r"curves\.a: all points of a curve are one",
    '{"curves": {"a": [[0,0,0],[1,"x",0]]}}': r'curves\.a\[1\]\[1\]: "x" is not a number',
    '{"curves": {"a": {"degree": 3}}}': r'curves\.a: "knots" is missing',
    '{"curves": {"a": {"degree": 1, "knots": [0,0,1], "control_points": [[0,0,0],[1,0,0]]}}}':
        r"curves\.a: a spline of degree 1",
    '{"curves": {"a": [[0,0],[1,1]]}, "tolerance": 0}': "tolerance: give a tolerance above 0",
    '{"curves": {"a": [[0,0],[1,1]]}, "meet": {"c": ["b"]}}':
        r"meet\.c\[0\]: there is no curve 'b'",
    '{"curves": {"a": [[0,0],[1,1]]}, "near": {"c": [1]}}': r"near\.c: .* is not a point",
    '{"curves": {"a": [[0,0],[1,1]], "a": [[0,0],[1,1]]}}': "is there twice",
    "{": "line 1, column 2",
}  # fmt: skip


@pytest.mark.parametrize("text", NETWORKS)
def test_wrong_networks_say_where_and_what(text: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(text)
    with pytest.raises(InvalidFeatureError, match=NETWORKS[text]) as raised:
        read_network(path)
    assert str(raised.value).startswith(f"{path}: ")


def changed(**entries: object) -> str:
    quads = [[0, 1, 4, 3], [1, 2, 5, 4]]
    feature = {"name": "low", "vertices": [0, 1, 2], "corners": ["a", "b"]}
    document: dict[str, object] = {"quads": quads, "features": [feature]}
    document |= entries
    return json.dumps({key: value for key, value in document.items() if value is not None})


FEATURE = {"name": "low", "vertices": [0, 1, 2], "corners": ["a", "b"]}
TEMPLATES = {
    changed(quads=None): 'give either "quads"',
    changed(mesh="a.obj"): 'give either "quads"',
    changed(features=None): '"features" is missing',
    changed(quads=[]): "no quads",
    changed(quads=[[0, 1, 2]]): r"quads\[0\]: a quad has 4",
    changed(quads=[[0, 1, 2, -1]]): "below 0",
    changed(quads=[[0, 1, 2, 2**40]]): r"quads\[0\]\[3\]: 1099511627776 is not a whole number from",
    changed(features=[{"name": "x"}]): r'features\[0\]: "vertices" is missing',
    changed(features=[FEATURE | {"corners": ["a"]}]): r"features\[0\]\.corners: 1 curves need 2",
    changed(features=[FEATURE | {"vertices": [0, -1]}]): "numbered from 0",
    changed(features=[FEATURE | {"vertices": [0, 2]}]): "there is no such edge",
    changed(plane=[6]): r"plane\[0\]: there is no vertex 6",
    changed(parts=[]): "the part around vertex 0 is missing",
    changed(parts=[{"name": "a", "vertex": 0}, {"name": "b", "vertex": 5}]): r"parts\[1\]: .* same",
    changed(parts=[{"name": "a"}]): '"vertex" is missing',
    changed(parts=[{"name": "a", "vertex": 0, "yields_to": ["b"]}]): "yields to 'b'",
    changed(parts=[{"name": "a", "vertex": 0, "hollow": 1}]): r"hollow: 1 is not true or false",
    changed(colour=1): "colour: there is no such entry",
}


@pytest.mark.parametrize("text", TEMPLATES)
def test_wrong_templates_say_where_and_what(text: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(text)
    with pytest.raises(InvalidFeatureError, match=TEMPLATES[text]):
        read_template(path, no_mesh)


def test_a_plain_template_is_read(tmp_path: Path) -> None:
    path = tmp_path / "strip.json"
    path.write_text(changed())
    found = read_template(path, no_mesh)
    assert (found.name, found.n_vertices, found.parts[0].name) == ("strip", 6, "part 1")


def with_arrays(**arrays: object) -> bytes:
    """A shape model's file with some arrays in place of its own; None leaves one out."""
    with np.load(io.BytesIO(shape_bytes(make_shape_model()))) as file:
        every: dict[str, object] = dict(file)
    every |= arrays
    data = io.BytesIO()
    np.savez(data, **{name: value for name, value in every.items() if value is not None})
    return data.getvalue()


def with_header(**entries: object) -> bytes:
    with np.load(io.BytesIO(shape_bytes(make_shape_model()))) as file:
        header = json.loads(file["header"].tobytes()) | entries
    text = json.dumps({key: value for key, value in header.items() if value is not None})
    return with_arrays(header=np.frombuffer(text.encode(), np.uint8))


SHAPES = {
    "this is not a shape model": lambda: b"nothing",
    "has the arrays": lambda: with_arrays(mean=None),
    "mean must be": lambda: with_arrays(mean=np.zeros((25, 3), np.float32)),
    "not finite": lambda: with_arrays(mean=np.full((25, 3), np.nan)),
    "do not fit": lambda: with_arrays(mean=np.zeros((24, 3))),
    "not orthonormal": lambda: with_arrays(modes=np.ones((4, 25, 3))),
    "a deviation above 0": lambda: with_arrays(deviations=np.zeros(4)),
    "about 0 and differ": lambda: with_arrays(coefficients=np.ones((5, 4))),
    "outside 0..24": lambda: with_arrays(quads=np.full((1, 4), 25, np.int32)),
    "this is not a shape model.*Object arrays": lambda: with_arrays(mean=np.array([{}], object)),
    "this is not JSON": lambda: with_arrays(header=np.frombuffer(b"{", np.uint8)),
    "the format is": lambda: with_header(version=2),
    '"names" is missing': lambda: with_header(names=None),
    "5 different names": lambda: with_header(names=["a"]),
    "below that of the modes": lambda: with_header(variance=1e-9),
    "the feature x needs one vertex of 0..24": lambda: with_header(
        features=[{"name": "x", "vertices": [25]}]
    ),
    "needs one vertex": lambda: with_header(features=[{"name": "x", "vertices": []}]),
}


@pytest.mark.parametrize("match", SHAPES)
def test_wrong_shape_models_are_refused(match: str) -> None:
    """Arrays that would have to be unpickled among them: nothing in a file is run."""
    with pytest.raises(InvalidFeatureError, match=match):
        shape_of(SHAPES[match]())


def with_content(change: dict[str, object]) -> bytes:
    """A session with entries in place of its own; None leaves one out."""
    document = json.loads(FEATURE_SESSION.encode(make_session()))
    whole = document["content"] | change
    document["content"] = {key: value for key, value in whole.items() if value is not None}
    return json.dumps(document).encode()


LINE = {"degree": 1, "knots": [0, 0, 1, 1], "control": [[0, 0, 0], [1, 0, 0]]}
CURVE = {
    "name": "a", "clicked": [[0, 0, 0]], "samples": [[0, 0, 0], [1, 0, 0]], "constraints": [],
    "spline": LINE, "settings": {},
}  # fmt: skip
SESSIONS: dict[str, dict[str, object]] = {
    'content: "mesh" is missing': {"mesh": None},
    r'curves\[0\]: "spline" is missing': {
        "curves": [{key: value for key, value in CURVE.items() if key != "spline"}]
    },
    r"curves\[0\]\.spline: a spline of degree 1": {
        "curves": [CURVE | {"spline": LINE | {"knots": []}}]
    },
    "two curves have one name": {"curves": [CURVE] * 2},
    r"curves\[0\]\.clicked: it must be a list of points": {"curves": [CURVE | {"clicked": [1]}]},
    r"constraints\[0\]: there is no sample 2": {
        "curves": [CURVE | {"constraints": [{"sample": 2, "point": [0, 0, 0]}]}]
    },
    r'content\.settings\.alpha: "x" is not a number': {"settings": {"alpha": "x"}},
    r"content\.settings: alpha is 7": {"settings": {"alpha": 7}},
    r"shapes\.a: this is not a shape": {"shapes": {"a": "eA=="}},
    r"templates\.a: .*itself, not the name of a mesh": {
        "templates": {"a": {"mesh": "a.obj", "features": []}}
    },
    r"templates\.a: .*features": {"templates": {"a": {"quads": [[0, 1, 2, 3]]}}},
    r"networks\.a": {"networks": {"a": {}}},
}


@pytest.mark.parametrize("match", SESSIONS)
def test_wrong_sessions_are_refused(match: str) -> None:
    with pytest.raises(InvalidFeatureError, match=match):
        FEATURE_SESSION.decode(with_content(SESSIONS[match]))


def test_what_is_no_session_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.session"
    for data in (b"", b"text", FEATURE_SESSION.encode(make_session())[:-100], b'{"curves": {}}'):
        path.write_bytes(data)
        with pytest.raises(InvalidFeatureError, match=r"a\.session: .*this is"):
            FEATURE_SESSION.read(path)


def test_curves_that_stay_keep_their_settings() -> None:
    """Whatever the settings of the next curve become."""
    before = make_session()
    (old,) = before.curves
    made = before.with_curves([], SnapSettings(alpha=0.125))
    assert made.settings.alpha == 0.125
    assert made.curves == (old,) and old.stroke.settings == SnapSettings(alpha=0.5, nearness=None)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_damaged_files_are_refused_or_read(data: st.DataObject) -> None:
    """Never another error: neither for a session nor for a shape model with bytes changed."""
    for content, read in (
        (FEATURE_SESSION.encode(make_session()), FEATURE_SESSION.decode),
        (shape_bytes(make_shape_model()), shape_of),
    ):  # fmt: skip
        damaged = bytearray(content)
        for _ in range(data.draw(st.integers(1, 4))):
            at = data.draw(st.integers(0, len(damaged) - 1))
            damaged[at] = data.draw(st.integers(0, 255))
        try:
            read(bytes(damaged))
        except InvalidFeatureError:
            continue
