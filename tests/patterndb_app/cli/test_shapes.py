"""patterndb shape-model: a model of shapes is built, sampled and edited."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb_sketch.features.files.shapearrays import read_shapes
from patterndb_sketch.features.files.templatejson import write_template
from patterndb_sketch.features.shapemodel import edit, measure_errors, pull_feature
from tests.support.cli.commandline import Result, assert_refused, run
from tests.support.features.drawnbodies import TEMPLATE as WHOLE
from tests.support.features.drawnbodies import write_bodies

CARS = ("sedan", "wagon", "coupe")

#: A roof alone is laid sooner than a car.
TEMPLATE = "box:roof?r=4"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bodies(tmp_path_factory.mktemp("bodies"), *CARS)


def pairs(folder: Path, *names: str) -> list[str]:
    return [f"{folder / name}.obj={folder / name}.network.json" for name in names]


@pytest.fixture(scope="module")
def shapes(folder: Path) -> Path:
    path = folder / "cars.npz"
    result = verb("build", *pairs(folder, *CARS), "--template", TEMPLATE, "-o", path)
    assert result.code == 0, result.err
    return path


def verb(name: str, *args: object) -> Result:
    return run("shape-model", name, *args)


def document(name: str, *args: object) -> dict[str, Any]:
    result = verb(name, *args, "--json")
    assert result.code == 0, result.err
    return result.document()


class TestBuild:
    def test_from_models_and_networks_or_from_registered_meshes(
        self, folder: Path, shapes: Path, tmp_path: Path
    ) -> None:
        """The same to the last bit."""
        meshes: list[Path] = []
        for name in CARS:
            meshes.append(tmp_path / f"{name}.quads.obj")
            result = run(
                "register", folder / f"{name}.obj", "--network", folder / f"{name}.network.json",
                "--template", TEMPLATE, "-o", meshes[-1],
            )  # fmt: skip
            assert result.code == 0, result.err
        other = tmp_path / "cars.npz"
        assert verb("build", *meshes, "--template", TEMPLATE, "-o", other).code == 0
        assert other.read_bytes() == shapes.read_bytes()
        model = read_shapes(shapes)
        assert (model.names, model.template) == (CARS, TEMPLATE)
        for k, path in enumerate(meshes):
            assert model.shape(model.coefficients[k]) == pytest.approx(read_mesh(path).points)

    def test_tells_variance_and_errors(self, folder: Path, shapes: Path, tmp_path: Path) -> None:
        args = (*pairs(folder, *CARS), "--template", TEMPLATE)
        told = document("build", *args, "--modes", 1, "-o", tmp_path / "one.npz")
        model = read_shapes(shapes)
        table = measure_errors(model)
        assert [row["modes"] for row in told["errors"]] == [0, 1, 2]
        assert [row["variance"] for row in told["errors"]] == pytest.approx(table.share)
        assert [row["learned"] for row in told["errors"]] == pytest.approx(table.known, abs=1e-12)
        assert [row["left_out"] for row in told["errors"][:2]] == pytest.approx(table.unseen[:2])
        assert told["errors"][2]["left_out"] is None
        assert told["modes"] == 1
        kept = read_shapes(tmp_path / "one.npz")
        assert np.array_equal(kept.modes, model.modes[:1])
        assert set(told["features"]) == {one.name for one in model.features}
        assert list(told["notes"]) == list(CARS)
        result = verb("build", *args, "-o", tmp_path / "all.npz")
        assert (tmp_path / "all.npz").read_bytes() == shapes.read_bytes()
        assert [row.split()[0] for row in result.out.splitlines()[1:]] == ["0", "1", "2"]
        assert "3 shapes, 2 modes kept" in result.err

    def test_registers_as_it_is_told(self, folder: Path, shapes: Path, tmp_path: Path) -> None:
        args = ("build", *pairs(folder, *CARS[:2]), "--template", TEMPLATE, "-o")
        found: set[bytes] = set()
        options = ((), ("--delta", 0.05), ("--rounds", 3))
        for k, more in enumerate(options):
            result = verb(*args, tmp_path / f"{k}.npz", *more)
            assert result.code == 0 and "the table needs three" in result.err
            found.add((tmp_path / f"{k}.npz").read_bytes())
        assert len(found) == len(options)
        refused = verb(*args, tmp_path / "a.npz", "--tolerance", 1e-9)
        assert_refused(refused, 3, "sedan.obj and its network")

    def test_slips_are_refused(self, folder: Path, tmp_path: Path) -> None:
        output = tmp_path / "a.npz"
        both = pairs(folder, *CARS[:2])
        args = ("--template", TEMPLATE, "-o", output)
        assert_refused(verb("build", *args), 2, "SOURCE")
        assert_refused(verb("build", both[0], *args), 3, "2 shapes or more")
        assert_refused(verb("build", both[0], both[0], *args), 2, "two shapes would be named")
        assert_refused(verb("build", *both, *args, "--modes", 2), 3, "--modes is 2", "1 mode")
        bare = folder / "sedan.obj"
        assert_refused(verb("build", bare, both[1], *args), 3, "has not the quads of", "register")
        assert_refused(verb("build", f"{bare}=", both[1], *args), 2, "the name is empty")
        assert_refused(verb("build", *both, "--template", TEMPLATE, "-o", "a.obj"), 2, ".npz")
        assert not output.exists()


class TestSample:
    def test_modes_are_deviations(self, shapes: Path, tmp_path: Path) -> None:
        model = read_shapes(shapes)
        output = tmp_path / "a.obj"
        told = document("sample", shapes, "--mode", "1=2.5", "--mode", "2=-0.5", "-o", output)
        assert told["sigmas"] == pytest.approx([2.5, -0.5])
        expected = model.shape(np.array([2.5, -0.5]) * model.deviations)
        assert np.array_equal(read_mesh(output).points, expected)
        assert np.array_equal(read_mesh(output).corners.reshape(-1, 4), model.quads)
        assert told["notes"] == ["mode 1 is beyond all learned shapes"]
        low, high = (bound / model.deviations for bound in model.box)
        assert told["least"] == pytest.approx(low)
        assert told["greatest"] == pytest.approx(high)

    def test_random_shapes_follow_the_seed(self, shapes: Path) -> None:
        model = read_shapes(shapes)
        for seed in (0, 7):
            told = document("sample", shapes, "--random", "--seed", seed)
            assert told["coefficients"] == model.sample(seed).tolist()
            assert told["notes"] == []
        result = verb("sample", shapes, "--random")
        assert result.out.splitlines()[0].split() == [
            "mode", "sigmas", "least", "greatest", "variance"
        ]  # fmt: skip
        assert len(result.out.splitlines()) == 1 + model.n_modes

    def test_learned_shapes_and_fewer_modes(self, shapes: Path) -> None:
        model = read_shapes(shapes)
        assert document("sample", shapes)["coefficients"] == [0.0] * 2
        told = document("sample", shapes, "--like", "coupe")
        assert told["coefficients"] == model.coefficients[2].tolist()
        told = document("sample", shapes, "--like", "coupe", "--modes", 1)
        assert told["coefficients"] == model.coefficients[2, :1].tolist()

    @pytest.mark.usefixtures("screen")
    def test_pictures_and_windows_show_the_shape(
        self, shapes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        one, two = tmp_path / "one.png", tmp_path / "two.png"
        assert verb("sample", shapes, "--picture", one).code == 0
        assert verb("sample", shapes, "--picture", two, "--mode", "1=1").code == 0
        assert one.read_bytes()[:4] == b"\x89PNG"
        assert one.read_bytes() != two.read_bytes()
        shown: list[tuple[Any, dict[str, Any]]] = []
        monkeypatch.setattr(
            "viewer.shapes.show", lambda model, laid, **given: shown.append((laid, given))
        )
        output = tmp_path / "a.obj"
        assert verb("sample", shapes, "--view", "--mode", "2=1", "-o", output).code == 0
        assert verb("edit", shapes, "--view", "--drag", "roof_rail=0,0,0.1").code == 0
        assert verb("edit", shapes, "--view", "--like", "sedan", "--hold", "roof_rail").code == 0
        (template, given), (_, edited), (_, begun) = shown
        assert begun["held"] == {"roof_rail": 1.0}
        assert template.name == TEMPLATE
        assert (given["title"], given["output"]) == ("cars.npz", output)
        assert given["coefficients"][1] > 0
        assert np.any(edited["coefficients"])

    def test_the_template_may_be_named(self, folder: Path, shapes: Path, tmp_path: Path) -> None:
        """A model built with a file needs the file to be drawn."""
        from patterndb_sketch.features.registration import template_of_name

        file, moved_to = tmp_path / "car.json", tmp_path / "other.json"
        write_template(file, template_of_name(TEMPLATE))
        output, picture = tmp_path / "a.npz", tmp_path / "a.png"
        sources = pairs(folder, *CARS[:2])
        assert verb("build", *sources, "--template", file, "-o", output).code == 0
        assert read_shapes(output).template == str(file)
        assert verb("sample", output, "--picture", picture).code == 0
        file.rename(moved_to)
        assert verb("sample", output, "--picture", picture).code == 3
        named = ("--template", moved_to)
        assert verb("sample", output, "--picture", picture, *named).code == 0

    def test_slips_are_refused(self, shapes: Path, tmp_path: Path) -> None:
        assert_refused(verb("sample", shapes, "--mode", "3=1"), 2, "there are 2 modes")
        for wrong in ("0=1", "1", "1=x", "1=nan", "=1"):
            assert_refused(verb("sample", shapes, "--mode", wrong), 2, "--mode")
        assert_refused(verb("sample", shapes, "--random", "--mode", "1=1"), 2, "leave --mode")
        assert_refused(verb("sample", shapes, "--like", "boat"), 2, "sedan, wagon, coupe")
        assert_refused(verb("sample", shapes, "--modes", 9), 3, "the model has 2 modes")
        assert_refused(verb("sample", tmp_path / "no.npz"), 3, "no.npz")
        broken = tmp_path / "broken.npz"
        broken.write_bytes(b"nothing")
        assert_refused(verb("sample", broken), 3, "not a shape model")


class TestEdit:
    def test_does_what_editing_does(self, shapes: Path, tmp_path: Path) -> None:
        model = read_shapes(shapes)
        output = tmp_path / "a.obj"
        told = document(
            "edit", shapes, "--like", "sedan", "--drag", "roof_rail=0,0,0.1", "--drag",
            "roof_front=0.1,0,0", "--hold", "belt_line=0.5", "--hold", "roof_rear", "-o", output,
        )  # fmt: skip
        start = model.coefficients[0]
        targets = pull_feature(model, "roof_rail", [0, 0, 0.1], start=start)
        targets |= pull_feature(model, "roof_front", [0.1, 0, 0], start=start)
        found = edit(model, targets, held={"belt_line": 0.5, "roof_rear": 1.0}, start=start)
        assert told["coefficients"] == found.coefficients.tolist()
        assert told["misses"] == dict(found.misses)
        assert np.array_equal(read_mesh(output).points, found.points)
        bound = [k + 1 for k, side in enumerate(found.at_bound) if side]
        for number in bound:
            assert any(note.startswith(f"mode {number} is at its") for note in told["notes"])
        assert sum("off its target" in note for note in told["notes"]) == 2

    def test_one_vertex_is_pulled(self, shapes: Path) -> None:
        model = read_shapes(shapes)
        told = document("edit", shapes, "--drag", "belt_line=0,0,0.05", "--vertex", -1)
        targets = pull_feature(model, "belt_line", [0, 0, 0.05], vertex=-1)
        assert told["coefficients"] == edit(model, targets).coefficients.tolist()
        whole = document("edit", shapes, "--drag", "belt_line=0,0,0.05")
        assert whole["coefficients"] != told["coefficients"]

    def test_slips_are_refused(self, shapes: Path) -> None:
        drag = ("--drag", "roof_rail=0,0,0.1")
        assert_refused(verb("edit", shapes), 2, "--drag")
        for wrong in ("roof_rail", "roof_rail=1,2", "=1,2,3", "a=1,2,x", "a=1,2,inf"):
            assert_refused(verb("edit", shapes, "--drag", wrong), 2, "roof_rail=0,0,0.1")
        for wrong in ("=1", "a=x", "a=-1", "a=nan"):
            assert_refused(verb("edit", shapes, *drag, "--hold", wrong), 2, "--hold")
        assert_refused(verb("edit", shapes, *drag, *drag), 2, "--drag names a feature twice")
        other = ("--drag", "belt_line=0,0,1")
        assert_refused(verb("edit", shapes, *drag, *other, "--vertex", 1), 2, "one --drag")
        assert_refused(verb("edit", shapes, "--drag", "keel=0,0,1"), 3, "no feature 'keel'")
        assert_refused(verb("edit", shapes, *drag, "--hold", "roof_rail"), 3, "do one of both")
        assert_refused(verb("edit", shapes, *drag, "--vertex", 99), 3, "there is no 99")


def test_all_verbs_end_to_end(folder: Path, tmp_path: Path) -> None:
    """Strokes become curves, curves a registration, registrations a model, the model a shape."""
    quads: list[Path] = []
    for name in CARS[:2]:
        curves, model = tmp_path / f"{name}.curves.json", folder / f"{name}.obj"
        strokes = folder / f"{name}.strokes.json"
        assert run("features", model, "--strokes", strokes, "-o", curves).code == 0
        quads.append(tmp_path / f"{name}.obj")
        laid = run("register", model, "--network", curves, "--template", WHOLE, "-o", quads[-1])
        assert laid.code == 0, laid.err
        # Curves from rough strokes and the true ones give nearly the same quads.
        true = tmp_path / "true.obj"
        network = folder / f"{name}.network.json"
        run("register", model, "--network", network, "--template", WHOLE, "-o", true)
        off = np.linalg.norm(read_mesh(quads[-1]).points - read_mesh(true).points, axis=1)
        assert np.median(off) < 0.02
    built, shape = tmp_path / "cars.npz", tmp_path / "new.obj"
    assert verb("build", *quads, "--template", WHOLE, "-o", built).code == 0
    edited = verb("edit", built, "--drag", "roof_rail=0.1,0,0", "-o", shape)
    assert edited.code == 0, edited.err
    assert read_mesh(shape).n_faces == read_mesh(quads[0]).n_faces
