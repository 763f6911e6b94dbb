"""patterndb features and register: strokes in, curves out, and quads that follow them."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bodies import body

from ingest.formats import read_mesh, write_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import read_curves, read_network
from patterndb_sketch.features.initial import interpolate_points
from patterndb_sketch.features.registration import register, template_of_name
from patterndb_sketch.features.session import FEATURE_SESSION
from tests.support.cli.commandline import assert_refused, run
from tests.support.features.drawnbodies import TEMPLATE, car_bodies, write_bodies

#: Strokes that most tests do with.
FEW = ("roof_rail", "shoulder", "hood_edge")

#: A template of one part, which is laid in a fraction of the time.
ROOF = "box:roof?r=4"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bodies(tmp_path_factory.mktemp("bodies"), "sedan")


@pytest.fixture(scope="module")
def sedan(folder: Path) -> Path:
    return folder / "sedan.obj"


@pytest.fixture(scope="module")
def few(folder: Path) -> Path:
    """A few of the sedan's strokes, the first of them with a constraint."""
    every = json.loads((folder / "sedan.strokes.json").read_text())["strokes"]
    strokes = [one for one in every if one["name"] in FEW]
    rail = body("sedan", 0.5).feature("roof_rail").points
    strokes[0]["constraints"] = [{"at": rail[len(rail) // 2].tolist()}]
    path = folder / "few.json"
    path.write_text(json.dumps({"strokes": strokes}))
    return path


@pytest.fixture(scope="module")
def curves(folder: Path, sedan: Path) -> Path:
    """All curves of the sedan."""
    path = folder / "sedan.curves.json"
    result = run("features", sedan, "--strokes", folder / "sedan.strokes.json", "-o", path)
    assert result.code == 0, result.err
    return path


def document(*args: object) -> dict[str, Any]:
    result = run(*args, "--json")
    assert result.code == 0, result.err
    return result.document()


@pytest.fixture(scope="module")
def usual(sedan: Path, few: Path) -> dict[str, Any]:
    """The curves of the few strokes with the usual settings, as JSON."""
    return document("features", sedan, "--strokes", few)["curves"]


def test_writes_what_it_tells(sedan: Path, few: Path, tmp_path: Path) -> None:
    """Table, JSON and file agree, and every curve is on its feature."""
    output = tmp_path / "curves.json"
    told = document("features", sedan, "--strokes", few, "-o", output)
    assert told["triangles"] == len(Surface.from_soup(read_mesh(sedan)).triangles)
    assert (told["components"], told["lost"], told["output"]) == (1, {}, str(output))
    written = json.loads(output.read_text())
    assert written["curves"] == told["curves"]
    assert set(told["curves"]) == set(FEW)
    car = body("sedan", 0.5)
    for one in read_curves(output):
        smooth = car.feature(one.name).smooth
        along = one.curve.spline.sample(100)
        away = np.linalg.norm(along[:, None] - smooth[None], axis=2).min(axis=1)
        assert away.max() < 0.03
        assert one.figures.moved.most > away.max()
    ((_, point),) = [c for one in read_curves(output) for c in one.curve.constraints]
    rail = read_curves(output)[0].curve
    number = rail.constraints[0][0]
    assert rail.spline.evaluate(rail.parameters[number])[0] == pytest.approx(point, abs=1e-9)
    result = run("features", sedan, "--strokes", few)
    head, *rows = result.out.splitlines()
    assert head.split() == ["curve", "length", "samples", "mended", "failed", "moved", "at", "most"]
    for row, (name, curve) in zip(rows, told["curves"].items(), strict=True):
        cells = row.split()
        assert cells[0] == name
        assert float(cells[1]) == pytest.approx(curve["figures"]["length"], rel=1e-3)
        assert int(cells[2]) == len(curve["samples"])
        assert float(cells[-1]) == pytest.approx(curve["figures"]["moved"]["most"], rel=1e-2)
    assert "3 curves recovered" in result.err


@pytest.mark.parametrize(
    ("option", "setting", "value"),
    [
        (("--alpha", "0.25"), "alpha", 0.25),
        (("--beta", "40", "--alpha", "0"), "beta", pytest.approx(40)),
        (("--axis", "y", "--alpha", "0"), "axis", [0, 1, 0]),
        (("--axis", "1,0.5,0", "--alpha", "0"), "axis", [1, 0.5, 0]),
        (("--stiffness", "8"), "stiffness", 8),
        (("--degree", "2"), "degree", 2),
        (("--reach", "0.02"), "radius", 0.02),
        (("--rounds", "1"), "rounds", 1),
        (("--strict",), "strict", True),
    ],
)
def test_every_setting_changes_the_curve(
    option: tuple[str, ...],
    setting: str,
    value: object,
    sedan: Path,
    few: Path,
    usual: dict[str, Any],
) -> None:
    """And stands with it; settings of a stroke's own come before it."""
    changed = document("features", sedan, "--strokes", few, *option)["curves"]
    for name in FEW:
        assert changed[name]["settings"][setting] == value
    assert any(changed[n]["control_points"] != usual[n]["control_points"] for n in FEW)
    strokes = json.loads(few.read_text())
    strokes["strokes"][1]["settings"] = {setting: usual["shoulder"]["settings"][setting]}
    own = few.with_name("own.json")
    own.write_text(json.dumps(strokes))
    mixed = document("features", sedan, "--strokes", own, *option)["curves"]
    second = strokes["strokes"][1]["name"]
    assert mixed[second]["settings"][setting] == usual[second]["settings"][setting]
    assert mixed["roof_rail"] == changed["roof_rail"]


def test_a_session_is_gone_on_with(sedan: Path, few: Path, tmp_path: Path) -> None:
    """Its curves are found again from what was clicked, dragged and set; others join them."""
    session = tmp_path / "a.session"
    first = document("features", sedan, "--strokes", few, "--session", session, "--stiffness", 3)
    kept = FEATURE_SESSION.read(session)
    assert kept.mesh == "sedan.obj"
    assert [one.name for one in kept.curves] == list(first["curves"])
    again = document("features", sedan, "--session", session)
    for name, curve in first["curves"].items():
        assert again["curves"][name] == curve
    other = document("features", sedan, "--session", session, "--stiffness", 1)
    assert other["curves"]["shoulder"]["settings"]["stiffness"] == 1
    strokes = json.loads(few.read_text())["strokes"]
    one = tmp_path / "one.json"
    one.write_text(json.dumps({"strokes": [strokes[1] | {"name": "another"}]}))
    run("features", sedan, "--session", session, "--strokes", one)
    assert [curve.name for curve in FEATURE_SESSION.read(session).curves] == [
        *first["curves"],
        "another",
    ]
    wheels = tmp_path / "other.obj"
    wheels.write_bytes(sedan.read_bytes())
    assert "drawn on sedan.obj" in run("features", wheels, "--session", session).err


def test_a_stroke_without_a_curve_is_told(sedan: Path, few: Path, tmp_path: Path) -> None:
    """The others are found; without any nothing is."""
    strokes = json.loads(few.read_text())["strokes"][:1]
    lost = {"name": "lost", "points": [[50, 0, 0], [51, 0, 0]]}
    path = tmp_path / "some.json"
    path.write_text(json.dumps({"strokes": [*strokes, lost]}))
    result = run("features", sedan, "--strokes", path, "--json")
    assert result.code == 1
    told = result.document()
    assert list(told["curves"]) == ["roof_rail"]
    assert list(told["lost"]) == ["lost"]
    assert "stroke 'lost'" in result.err
    path.write_text(json.dumps({"strokes": [lost]}))
    output = tmp_path / "none.json"
    assert_refused(run("features", sedan, "--strokes", path, "-o", output), 1, "no curve")
    assert not output.exists()


def test_pictures_show_the_curves(sedan: Path, few: Path, tmp_path: Path) -> None:
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    assert run("features", sedan, "--strokes", few, "--picture", one).code == 0
    assert run("features", sedan, "--strokes", few, "--picture", two, "--alpha", 0).code == 0
    assert one.read_bytes()[:4] == b"\x89PNG"
    assert one.read_bytes() != two.read_bytes()


@pytest.mark.usefixtures("screen")
def test_the_window_opens_with_what_there_is(
    sedan: Path, few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Empty, with a session as it is, or with what was just found."""
    shown: list[dict[str, Any]] = []
    monkeypatch.setattr("viewer.features.show", lambda model, **given: shown.append(given))
    session = tmp_path / "a.session"
    assert run("features", sedan, "--view", "--alpha", "0.5").code == 0
    assert run("features", sedan, "--view", "--session", session).code == 0
    assert not session.exists()
    assert run("features", sedan, "--view", "--session", session, "--strokes", few).code == 0
    before = session.read_bytes()
    result = run("features", sedan, "--view", "--session", session)
    assert (result.code, result.out) == (0, "")
    assert session.read_bytes() == before
    assert [len(one["session"].curves) for one in shown] == [0, 0, 3, 3]
    assert [one["session_path"] for one in shown] == [None, session, session, session]
    assert shown[0]["settings"].alpha == 0.5
    assert shown[0]["title"] == "sedan.obj"


@pytest.mark.usefixtures("screen")
def test_slips_are_refused(sedan: Path, few: Path, tmp_path: Path) -> None:
    missing = tmp_path / "missing"
    assert_refused(run("features", sedan), 2, "--strokes, --session or --view")
    assert_refused(run("features", sedan, "--view", "-o", tmp_path / "a.json"), 2, "no curves")
    assert_refused(run("features", sedan, "--session", missing), 3, "missing", "No such file")
    assert_refused(run("features", sedan, "--strokes", missing), 3, "missing", "No such file")
    assert_refused(run("features", missing, "--strokes", few), 3, "missing")
    assert_refused(run("features", sedan, "--strokes", few, "-o", "a.obj"), 2, "end in .json")
    for option, value in (
        ("--alpha", "2"), ("--beta", "200"), ("--axis", "q"), ("--axis", "0,0,0"),
        ("--stiffness", "0"), ("--degree", "10"), ("--reach", "0"), ("--rounds", "0"),
    ):  # fmt: skip
        assert_refused(run("features", sedan, "--strokes", few, option, value), 2, option)
    broken = tmp_path / "broken.json"
    broken.write_text('{"strokes": [{"points": [[0,0,0]]}]}')
    assert_refused(run("features", sedan, "--strokes", broken), 3, "broken.json", "strokes[0]")
    broken.write_text("{")
    assert_refused(
        run("features", sedan, "--session", broken), 3, "broken.json", "this is not JSON"
    )


class TestRegister:
    def test_lays_what_the_curves_say(self, sedan: Path, curves: Path, tmp_path: Path) -> None:
        """The file is what registering gives, to the last bit, and the counts add up."""
        output = tmp_path / "quads.obj"
        args = ("register", sedan, "--network", curves, "--template", TEMPLATE, "-o", output)
        told = document(*args)
        model, template = Surface.from_soup(read_mesh(sedan)), template_of_name(TEMPLATE)
        made = register(model, read_network(curves), template)
        mesh = read_mesh(output)
        assert np.array_equal(mesh.points, made.points)
        assert np.array_equal(mesh.corners.reshape(-1, 4), made.quads)
        assert (told["vertices"], told["quads"]) == (len(made.points), len(made.quads))
        assert told["notes"] == list(made.notes)
        assert told["gaps"] == {name: gap for name, gap in made.network.gaps.items() if gap}
        parts = told["parts"]
        assert [one["part"] for one in parts] == [part.name for part in template.parts]
        for key in ("on curves", "drawn to it", "hidden", "no hit"):
            assert sum(one[key] for one in parts) <= told["vertices"]
        for one in parts:
            kinds = sum(one[key] for key in ("on curves", "drawn to it", "hidden", "no hit"))
            assert one["vertices"] == kinds
        groups = [line for line in output.read_text().splitlines() if line.startswith("g ")]
        assert groups == 2 * [f"g {part.name}" for part in template.parts]

    def test_the_table_has_the_parts_of_the_document(self, sedan: Path, curves: Path) -> None:
        args = ("register", sedan, "--network", curves, "--template", ROOF, "-o")
        parts = document(*args, curves.with_name("a.obj"))["parts"]
        result = run(*args, curves.with_name("b.obj"))
        assert [row.split()[:3] for row in result.out.splitlines()[1:]] == [
            [one["part"], str(one["quads"]), str(one["vertices"])] for one in parts
        ]

    def test_every_option_changes_the_quads(
        self, sedan: Path, curves: Path, tmp_path: Path
    ) -> None:
        args = ("register", sedan, "--network", curves, "--template", TEMPLATE)
        found: set[bytes] = set()
        options = ((), ("--delta", 0.05), ("--delta", 0.05, "--rounds", 3))
        for k, more in enumerate(options):
            output = tmp_path / f"{k}.obj"
            assert run(*args, "-o", output, *more).code == 0
            found.add(output.read_bytes())
        assert len(found) == len(options)
        refused = run(*args, "-o", tmp_path / "a.obj", "--tolerance", 1e-6)
        assert_refused(refused, 3, "beyond the tolerance of 1e-06")

    def test_a_template_may_be_a_file(self, sedan: Path, curves: Path, tmp_path: Path) -> None:
        from patterndb_sketch.features.files.templatejson import write_template

        path, output, named = (tmp_path / name for name in ("roof.json", "a.obj", "b.obj"))
        write_template(path, template_of_name(ROOF))
        args = ("register", sedan, "--network", curves)
        assert run(*args, "--template", path, "-o", output).code == 0
        assert run(*args, "--template", ROOF, "-o", named).code == 0
        assert output.read_bytes() == named.read_bytes()

    def test_draws_the_quads(self, sedan: Path, curves: Path, tmp_path: Path) -> None:
        args = ("register", sedan, "--network", curves, "-o", tmp_path / "a.obj")
        drawn: set[bytes] = set()
        for template in (ROOF, "box:roof?r=6"):
            picture = tmp_path / "a.png"
            assert run(*args, "--template", template, "--picture", picture).code == 0
            drawn.add(picture.read_bytes())
        assert len(drawn) == 2

    def test_a_wrong_frame_is_refused_and_turned(
        self, sedan: Path, curves: Path, tmp_path: Path
    ) -> None:
        """The message names the turn, with which the quads are those of the model as it was."""
        right, output, away = (tmp_path / name for name in ("right.obj", "a.obj", "away.obj"))
        mesh = read_mesh(sedan)
        x, y, z = mesh.points.T
        write_mesh(away, replace(mesh, points=np.stack([-y, x, z], axis=1)))
        args = ("--network", curves, "--template", ROOF)
        assert run("register", sedan, *args, "-o", right).code == 0
        refused = run("register", away, *args, "-o", output)
        assert_refused(refused, 3, "do not lie on the model", "--turn y,-x,z")
        assert not output.exists()
        for turn in ("y,-x,z", "find"):
            told = document("register", away, *args, "-o", output, "--turn", turn)
            assert told["turn"] == "y,-x,z"
            assert np.abs(read_mesh(output).points - read_mesh(right).points).max() < 1e-6
        assert_refused(run("register", away, *args, "-o", output, "--turn", "x,y"), 3, "no turn")

    def test_slips_are_refused(self, sedan: Path, curves: Path, tmp_path: Path) -> None:
        output = tmp_path / "a.obj"
        args = ("register", sedan, "--network", curves, "-o", output)
        assert_refused(run(*args), 2, "--template")
        assert_refused(run(*args, "--template", "box:boat"), 3, "components are")
        assert_refused(run(*args, "--template", tmp_path / "no.json"), 3, "no.json")
        assert_refused(run(*args, "--template", TEMPLATE, "--delta", "0"), 2, "--delta")
        assert_refused(run(*args, "--template", TEMPLATE, "--rounds", "21"), 2, "--rounds")
        few = tmp_path / "few.json"
        few.write_text('{"curves": {"roof_rail": [[0,0,0],[1,1,1]]}}')
        lacking = ("register", sedan, "--network", few, "--template", TEMPLATE, "-o", output)
        assert_refused(run(*lacking), 3, "the network lacks the curves", "draw them")
        assert not output.exists()


def test_faults_of_a_body_are_those_that_were_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the files are the same on every run."""
    # Strokes and networks take longest, and have no faults.
    points = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    monkeypatch.setattr(car_bodies(), "stroke", lambda *_: points.copy())
    monkeypatch.setattr(car_bodies(), "spline_through", lambda _: interpolate_points(points))
    monkeypatch.setattr(car_bodies(), "body", cache(body))
    found: set[bytes] = set()
    every: list[str] = []
    least = ("coupe", "--resolution", "0.4")
    for faults in (
        (), ("--gaps", "0.002"), ("--crossings", "0.004"), ("--flips", "0.5"), ("--clutter",),
        ("--uneven",), ("--soup",),
    ):  # fmt: skip
        every += faults
        found.add((write_bodies(tmp_path, *least, *faults) / "coupe.obj").read_bytes())
    assert len(found) == 7
    one, two = (write_bodies(tmp_path / c, *least, *every) for c in "ab")
    for path in one.iterdir():
        assert path.read_bytes() == (two / path.name).read_bytes()
    with pytest.raises(SystemExit):
        write_bodies(tmp_path, "boat")


def test_strokes_are_as_rough_as_asked(folder: Path, tmp_path: Path) -> None:
    rough = write_bodies(tmp_path, "sedan", "--error", "0.02", "--seed", "1")
    one, two = ((at / "sedan.strokes.json").read_bytes() for at in (folder, rough))
    assert one != two
    for name in ("sedan.obj", "sedan.network.json"):
        assert (rough / name).read_bytes() == (folder / name).read_bytes()
