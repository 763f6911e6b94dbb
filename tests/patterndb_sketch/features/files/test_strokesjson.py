"""Files of strokes and of recovered curves: read back as written, and wrong ones refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bodies import body, stroke
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs
from scipy.spatial import KDTree

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb.system.documents import JsonValue, encode_json
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import (
    DrawnCurveModel,
    FoundModel,
    NetworkModel,
    SplineModel,
    model_of_curve,
    read_curves,
    read_network,
    write_curves,
    write_network,
)
from patterndb_sketch.features.files.strokesjson import (
    SettingsModel,
    model_of_settings,
    read_strokes,
    settings_of_model,
    write_strokes,
)
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.strokes import (
    FeatureStroke,
    RecoveredCurve,
    find_held_samples,
    measure_distances,
    recover_curve,
)

NAMES = ("roof_rail", "shoulder")

some_settings = st.builds(
    SnapSettings,
    alpha=st.floats(0, 1),
    axis=st.tuples(st.just(1.0), st.floats(-2, 2), st.floats(-2, 2)),
    beta=st.floats(0, np.pi),
    stiffness=st.floats(1, 1e6),
    theta=st.floats(0, 1e6),
    continuity=st.floats(0, 1e6),
    strict=st.booleans(),
    window=st.floats(1e-9, 1),
    nearness=st.floats(1e-9, 1) | st.none(),
    degree=st.integers(1, 9),
    radius=st.floats(1e-6, 1),
    n_samples=st.integers(5, 500),
    rounds=st.integers(1, 100),
)

some_points = st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), min_size=2, max_size=5)


@pytest.fixture(scope="module")
def model() -> Surface:
    car = body("sedan", 0.5, whole=True)
    return Surface.from_soup(PolygonMesh.from_faces(car.points, car.triangles))


@pytest.fixture(scope="module")
def found(model: Surface) -> list[RecoveredCurve]:
    car = body("sedan", 0.5, whole=True)
    rail, shoulder = (FeatureStroke(name, stroke(car, name)) for name in NAMES)
    held = car.feature("roof_rail").points[[5]]
    kept = FeatureStroke(rail.name, rail.points, held, SnapSettings(alpha=0.75, stiffness=2.0))
    return [recover_curve(model, kept), recover_curve(model, shoulder)]


def close(a: SnapSettings, b: SnapSettings) -> bool:
    """The same but for the last digit of beta, which files have in degrees."""
    one, two = (structs.asdict(model_of_settings(settings)) for settings in (a, b))
    return one.pop("beta") == pytest.approx(two.pop("beta"), rel=1e-14) and one == two


@settings(max_examples=50, deadline=None)
@given(some_settings, some_settings)
def test_settings_are_read_back(one: SnapSettings, usual: SnapSettings) -> None:
    """From JSON, and from what they have other than the usual."""
    written = JsonValue(json.loads(encode_json(model_of_settings(one))), "", InvalidFeatureError)
    again = settings_of_model(written.read(SettingsModel), usual, written)
    assert close(again, one)
    assert replace(usual, **one.list_differences(usual)) == one


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(some_points, some_points, some_settings), min_size=1, max_size=3))
def test_strokes_are_read_back(
    tmp_path_factory: pytest.TempPathFactory,
    parts: list[tuple[list[object], list[object], SnapSettings]],
) -> None:
    path = tmp_path_factory.mktemp("strokes") / "a.json"
    given_ = [
        FeatureStroke(f"ä {k}", np.array(points), np.array(held), chosen)
        for k, (points, held, chosen) in enumerate(parts)
    ]
    write_strokes(path, given_)
    again = read_strokes(path)
    for one, other in zip(given_, again, strict=True):
        assert one.name == other.name
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.held, other.held)
        assert close(one.settings, other.settings)


def test_an_angle_is_written_whole(tmp_path: Path) -> None:
    """What a file says of it does not depend on what is usual for others."""
    one = FeatureStroke("a", np.eye(3), settings=SnapSettings(alpha=0.0, axis=(0.0, 1.0, 0.0)))
    other = SnapSettings(beta=1.0, stiffness=3.0)
    write_strokes(tmp_path / "a.json", [one])
    (again,) = read_strokes(tmp_path / "a.json", other)
    assert close(again.settings, SnapSettings(alpha=0.0, axis=(0.0, 1.0, 0.0), stiffness=3.0))
    plain = FeatureStroke("a", np.eye(3), settings=SnapSettings(degree=2))
    write_strokes(tmp_path / "a.json", [plain])
    (entry,) = json.loads((tmp_path / "a.json").read_text())["strokes"]
    assert entry["settings"] == {"degree": 2}


def test_a_stroke_is_no_more_than_points(tmp_path: Path) -> None:
    """The rest is the usual: a name by its place, the settings that were given."""
    path = tmp_path / "a.json"
    path.write_text('{"strokes": [{"points": [[0,0],[1,1,1]]}, {"points": [[0,0],[1,1]]}]}')
    usual = SnapSettings(alpha=0.25)
    one, two = read_strokes(path, usual)
    assert (one.name, two.name) == ("stroke 1", "stroke 2")
    assert one.points.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert one.held.shape == (0, 3)
    assert one.settings is usual


POINTS = [[0, 0, 0], [1, 1, 1]]
STROKES = {
    r"a list is not an object": [],
    r'"strokes" is missing': {},
    r"lines: there is no such entry": {"strokes": [{"points": POINTS}], "lines": []},
    r"strokes: there is no stroke": {"strokes": []},
    r'strokes\[0\]: "points" is missing': {"strokes": [{}]},
    r"strokes\[0\]\.points: a polyline needs two": {"strokes": [{"points": [[0, 0, 0]]}]},
    r"strokes\[0\]\.open: there is no such entry": {
        "strokes": [{"points": POINTS, "open": True}]
    },
    r"strokes\[0\]\.closed: 1 is not true or false": {
        "strokes": [{"points": POINTS, "closed": 1}]
    },
    r"strokes\[0\]\.name: the name is empty": {"strokes": [{"points": POINTS, "name": ""}]},
    r"strokes\[1\]: there is another stroke 'a'": {
        "strokes": [{"points": POINTS, "name": "a"}] * 2
    },
    r'constraints\[0\]: "at" is missing': {"strokes": [{"points": POINTS, "constraints": [{}]}]},
    r"constraints\[0\]\.on: there is no such entry": {
        "strokes": [{"points": POINTS, "constraints": [{"on": 1}]}]
    },
    r"settings\.speed: there is no such entry": {
        "strokes": [{"points": POINTS, "settings": {"speed": 1}}]
    },
    r"strokes\[0\]\.settings: alpha is 2": {
        "strokes": [{"points": POINTS, "settings": {"alpha": 2}}]
    },
    r"settings: degree is 10; give 1 to 9": {
        "strokes": [{"points": POINTS, "settings": {"degree": 10}}]
    },
    r"settings\.axis: the axis has no length": {
        "strokes": [{"points": POINTS, "settings": {"axis": [0, 0, 0]}}]
    },
    r"settings\.strict: 1 is not true or false": {
        "strokes": [{"points": POINTS, "settings": {"strict": 1}}]
    },
}  # fmt: skip


@pytest.mark.parametrize("match", STROKES)
def test_wrong_strokes_say_where_and_what(match: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(STROKES[match]))
    with pytest.raises(InvalidFeatureError, match=match) as raised:
        read_strokes(path)
    assert str(raised.value).startswith(f"{path}: ")


def test_a_curve_passes_through_what_is_held(found: list[RecoveredCurve]) -> None:
    (number, point), *more = found[0].curve.constraints
    assert not more
    at = found[0].curve.spline.evaluate(found[0].curve.parameters[number])
    assert at[0] == pytest.approx(point, abs=1e-9)


def test_figures_are_distances(model: Surface, found: list[RecoveredCurve]) -> None:
    """As another way of measuring gives them: to a dense cloud of points of the curve."""
    for one in found:
        dense = one.curve.spline.sample(20_001)
        off = np.asarray(KDTree(dense).query(one.curve.samples)[0])
        assert np.allclose(
            measure_distances(one.curve.samples, one.curve.spline, 2_000), off, atol=2e-3, rtol=0
        )
        assert one.figures.fit.most >= off.max() - 1e-4
        assert one.figures.length == pytest.approx(one.curve.spline.length)
        away = model.measure_distances(dense)
        assert one.figures.off.most == pytest.approx(away.max(), rel=0.05, abs=1e-4)
        assert one.figures.moved.mean <= one.figures.moved.most
        # The stroke was at most twice 1 % of the diagonal off, and the curve is on the feature.
        assert 0.0 < one.figures.moved.most < 0.03 * model.diagonal


def test_two_held_points_at_one_sample_are_refused() -> None:
    samples = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    assert [number for number, _ in find_held_samples(samples, [[0.9, 1, 0], [0.1, 0, 0]])] == [
        1,
        0,
    ]
    with pytest.raises(InvalidFeatureError, match="constraints 0 and 1 are at one sample"):
        find_held_samples(samples, [[0.9, 1, 0], [1.1, 0, 0]])


def test_an_error_names_the_stroke(model: Surface) -> None:
    far = FeatureStroke("far", np.array([[90.0, 0, 0], [91.0, 0, 0]]))
    with pytest.raises(InvalidFeatureError, match=r"stroke 'far': none of its points is near"):
        recover_curve(model, far)


def test_what_is_far_off_the_model_is_refused(model: Surface) -> None:
    points = model.vertices[:2]
    with pytest.raises(InvalidFeatureError, match="none of its points is near the model"):
        recover_curve(model, FeatureStroke("far", points + 3.0 * model.diagonal))
    # In another unit all strokes are one place, which ribs may reach.
    top = model.vertices[model.vertices[:, 2].argmax()] + [0.0, 0.0, 0.02 * model.diagonal]
    small = top + 1e-4 * model.diagonal * np.arange(3.0)[:, None]
    with pytest.raises(
        InvalidFeatureError,
        match=r"the nearest is .* times the diagonal of the model",
    ):
        recover_curve(model, FeatureStroke("small", small))
    pin = points[:1] + 3.0 * model.diagonal
    with pytest.raises(InvalidFeatureError, match=r"constraint 0 at .* off the model"):
        recover_curve(model, FeatureStroke("pinned", points, held=pin))


def test_curves_are_read_back(found: list[RecoveredCurve], tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_curves(path, found, "sedan.obj")
    assert json.loads(path.read_text())["model"] == "sedan.obj"
    again = read_curves(path)
    assert [model_of_curve(one) for one in again] == [model_of_curve(one) for one in found]
    for one, other in zip(found, again, strict=True):
        assert np.array_equal(one.curve.samples, other.curve.samples)
        assert np.array_equal(one.curve.parameters, other.curve.parameters)
        assert one.figures == other.figures
        assert np.array_equal(one.curve.spline.control, other.curve.spline.control)


def test_curves_are_a_network(found: list[RecoveredCurve], tmp_path: Path) -> None:
    """The same network as of their splines alone, with what is said of where they meet."""
    path = tmp_path / "a.json"
    write_curves(path, found, "sedan.obj")
    whole = json.loads(path.read_text()) | {"tolerance": 0.1, "near": {"c": [0, 0, 1]}}
    path.write_text(json.dumps(whole))
    network = read_network(path)
    assert list(network.curves) == list(NAMES)
    for one in found:
        assert np.array_equal(network.curves[one.name].control, one.curve.spline.control)
    assert network.tolerance == 0.1
    assert network.near["c"].tolist() == [0, 0, 1]
    assert len(read_curves(path)) == 2
    plain = tmp_path / "b.json"
    drawn = FeatureCurves({one.name: one.curve.spline for one in found})
    write_network(plain, drawn)
    assert NetworkModel.of(read_network(plain)) == NetworkModel.of(drawn)


def broken(found: list[RecoveredCurve], **entries: object) -> object:
    (one,) = (one for one in found if one.name == "shoulder")
    curve = json.loads(encode_json(model_of_curve(one))) | entries
    return {"curves": {"a": {key: value for key, value in curve.items() if value is not None}}}


CURVES: dict[str, dict[str, object]] = {
    r'curves\.a: "figures" is missing': {"figures": None},
    r'curves\.a: "knots" is missing': {"knots": None},
    r"curves\.a\.colour: there is no such entry": {"colour": 1},
    r"curves\.a\.parameters: there are 1": {"parameters": [0]},
    r"curves\.a\.samples: a polyline needs": {"samples": [[0, 0, 0]]},
    r"failed\[0\]: there is no sample 9999": {"failed": [9999]},
    r"settings: alpha is 7": {"settings": {"alpha": 7}},
    r'figures: "moved" is missing': {"figures": {"length": 1}},
    r'constraints\[0\]: "point" is missing: the point where': {"constraints": [{"sample": 1}]},
}


@pytest.mark.parametrize("match", CURVES)
def test_wrong_curves_say_where_and_what(
    match: str, found: list[RecoveredCurve], tmp_path: Path
) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(broken(found, **CURVES[match])))
    with pytest.raises(InvalidFeatureError, match=match) as raised:
        read_curves(path)
    assert str(raised.value).startswith(f"{path}: ")


def test_wrong_networks_are_refused_as_ever(found: list[RecoveredCurve], tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    for content, match in (
        (broken(found, colour=1), r"curves\.a\.colour: there is no such entry"),
        ([], "a list is not an object"),
        ({"curves": []}, "a list is not an object"),
    ):
        path.write_text(json.dumps(content))
        with pytest.raises(InvalidFeatureError, match=match):
            read_network(path)
    path.write_text('{"curves": {"a": [[0,0],[1,1]]}}')
    assert list(read_network(path).curves) == ["a"]
    with pytest.raises(InvalidFeatureError, match="a list is not a curve recovered from a stroke"):
        read_curves(path)


def test_parameters_must_ascend_on_the_curve(found: list[RecoveredCurve], tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    m = len(found[1].curve.samples)
    path.write_text(json.dumps(broken(found, parameters=[2.0] * m)))
    with pytest.raises(InvalidFeatureError, match="must ascend within"):
        read_curves(path)
    entries = set(DrawnCurveModel.__struct_fields__) - set(SplineModel.__struct_fields__)
    assert entries == set(FoundModel.__struct_fields__) - set(SplineModel.__struct_fields__)


def test_two_curves_of_one_name_are_not_written(
    found: list[RecoveredCurve], tmp_path: Path
) -> None:
    with pytest.raises(InvalidFeatureError, match="two curves have one name"):
        write_curves(tmp_path / "a.json", [found[0], found[0]])
    assert not (tmp_path / "a.json").exists()
