"""Closed curves in networks, templates and shape models: a tube between two rings and a seam."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.files.templatejson import read_template, write_template
from patterndb_sketch.features.registration import (
    ChainStep,
    CurveJoint,
    FeatureChain,
    FeatureCurves,
    Registration,
    Template,
    TemplatePart,
    join_features,
    register,
)
from patterndb_sketch.features.shapemodel import ShapeModel, edit, pull_feature
from patterndb_sketch.features.splines import Spline
from tests.support.features.rings import can

#: Vertices around the tube, and rings of them.
AROUND, RINGS = 16, 5


def tube() -> Template:
    """Rings of quads between a closed feature above and one below, and a seam between them."""
    at = np.arange(RINGS * AROUND, dtype=np.int32).reshape(RINGS, AROUND)
    on = np.roll(at, -1, axis=1)
    quads = np.stack([at[:-1], on[:-1], on[1:], at[1:]], axis=-1).reshape(-1, 4)
    loops = {"low": at[0], "high": at[-1]}
    chains = [
        FeatureChain(
            name, np.append(loop, loop[0]), (ChainStep(name, f"{name}_end", f"{name}_end"),)
        )
        for name, loop in loops.items()
    ]
    seam = ChainStep("seam", "low_end", "high_end")
    chains.append(FeatureChain("seam", np.ascontiguousarray(at[:, 0]), (seam,)))
    of_part = np.zeros(RINGS * AROUND, np.int32)
    return Template("tube", quads, (TemplatePart("tube"),), of_part, tuple(chains), of_part > 0)


def loop(height: float, start: float, sense: int = 1) -> Spline:
    """A circle of radius 1, drawn from an angle on."""
    turn = start + sense * np.linspace(0.0, 2.0 * np.pi, 80)
    return spline_through(np.stack([np.cos(turn), np.sin(turn), np.full(80, height)], axis=1))


def network(start: float = 2.0, angle: float = 0.5) -> dict[str, Spline]:
    """Two circles that begin anywhere, and a seam at an angle that passes both."""
    heights = np.array([[-0.85], [0.95]])
    ends = np.append(np.tile([np.cos(angle), np.sin(angle)], (2, 1)), heights, axis=1)
    return {
        "low": loop(-0.8, start),
        "high": loop(0.9, -start),
        "seam": spline_through(ends),
    }


@pytest.fixture(scope="module")
def laid() -> Registration:
    return register(can(), network(), tube())


@pytest.mark.parametrize("start", [0.0, 0.5, 0.5 + 1e-9, 3.0, 5.9])
def test_rings_are_followed_from_the_seam_all_round(start: float) -> None:
    """Wherever each was begun, at the seam itself as well: at equal angles from there."""
    made = register(can(), network(start), tube())
    points = made.points.reshape(RINGS, AROUND, 3)
    angle = 0.5 + np.arange(AROUND) * 2.0 * np.pi / AROUND
    for ring, height in ((points[0], -0.8), (points[-1], 0.9)):
        wanted = np.stack([np.cos(angle), np.sin(angle), np.full(AROUND, height)], axis=1)
        assert ring == pytest.approx(wanted, abs=2e-3)
    assert np.linalg.norm(points[..., :2], axis=-1) == pytest.approx(1.0, abs=0.02)
    assert (np.diff(points[..., 2], axis=0) > 0.0).all()


SPOKES = (0.3, 2.0, 4.5)


@pytest.mark.parametrize(("start", "sense"), [(1.0, 1), (3.0, -1), (0.3, 1), (6.0, -1)])
def test_a_closed_curve_is_followed_between_its_corners(start: float, sense: int) -> None:
    """Of three corners: past no other one, whichever way it was drawn; of two: as it was drawn,
    and of one all round. It passes through all of them and stays closed."""
    for count in (1, 2, 3):
        spokes = {
            f"spoke{i}": spline_through(np.outer([0.9, 2.1], [np.cos(a), np.sin(a), 0.0]))
            for i, a in enumerate(SPOKES[:count])
        }
        inner, outer = loop(0.0, start, sense), loop(0.0, start, sense)
        outer = Spline(outer.degree, outer.knots, 2.0 * outer.control, closed=True)
        joints = [CurveJoint(f"in{i}", ("inner", f"spoke{i}")) for i in range(count)]
        joints += [CurveJoint(f"out{i}", ("outer", f"spoke{i}")) for i in range(count)]
        found = join_features(FeatureCurves({"inner": inner, "outer": outer, **spokes}), joints)
        for name, radius, corner in (("inner", 1.0, "in"), ("outer", 2.0, "out")):
            assert found.curves[name].closed
            for i in range(count):
                here = found.curves[name](found.parameters[name, f"{corner}{i}"])[0]
                assert here == pytest.approx(found.nodes[f"{corner}{i}"], abs=1e-9)
                turn = sense if count < 3 else 1
                to = SPOKES[(i + 1) % count]
                angle = turn * (to - SPOKES[i]) % (2.0 * np.pi) or 2.0 * np.pi
                t, lengths = found.interval(name, f"{corner}{i}", f"{corner}{(i + 1) % count}")
                assert lengths[-1] == pytest.approx(radius * angle, rel=2e-3)
                middle = found.curves[name](t[len(t) // 2])[0]
                wanted = SPOKES[i] + turn * angle / 2.0
                assert middle[:2] == pytest.approx(
                    radius * np.array([np.cos(wanted), np.sin(wanted)]), abs=5e-3
                )


def test_joints_at_one_place_of_a_closed_curve_are_refused() -> None:
    rings = {"inner": loop(0.0, 0.0), "outer": loop(1.0, 0.0)}
    ends = np.array([[1.0, 0.0, -0.1], [1.0, 0.0, 1.1]])
    curves = rings | {"one": spline_through(ends), "two": spline_through(ends)}
    joints = [
        CurveJoint(f"{ring}_{line}", (ring, line)) for ring in rings for line in ("one", "two")
    ]
    with pytest.raises(InvalidFeatureError, match="at one place of the curve inner"):
        join_features(FeatureCurves(curves), joints)


def test_a_template_with_closed_features_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "tube.json"
    write_template(path, tube())

    def no_mesh(_: Path) -> None:
        raise AssertionError

    again = read_template(path, no_mesh)  # type: ignore[arg-type]
    assert (again.quads == tube().quads).all()
    for one, other in zip(again.chains, tube().chains, strict=True):
        assert (one.vertices == other.vertices).all() and one.steps == other.steps
    wrong = json.loads(path.read_text())
    wrong["features"][0]["vertices"][3] = 0
    path.write_text(json.dumps(wrong))
    with pytest.raises(InvalidFeatureError, match="each once but for the first"):
        read_template(path, no_mesh)  # type: ignore[arg-type]


def test_shapes_with_closed_features_are_edited(laid: Registration) -> None:
    """A ring is dragged as a whole, and by one vertex: that one goes all the way, its opposite
    stays, and the vertex that is first and last has one place."""
    wide = laid.points * [1.5, 1.2, 1.0]
    model = ShapeModel.build(
        [laid.points, wide, laid.points * [1.0, 1.0, 1.4]], laid.quads, laid.features
    )
    lifted = edit(model, pull_feature(model, "high", (0.0, 0.0, 0.05)))
    high = model.feature("high").vertices
    assert (lifted.points[high, 2] > model.mean[high, 2]).all()
    offset = np.array([0.1, 0.0, 0.2])
    for vertex in (0, 3, AROUND, -1, AROUND // 2):
        moved = pull_feature(model, "high", offset, vertex=vertex)["high"] - model.mean[high]
        share = moved[:, 0] / offset[0]
        at = vertex % (AROUND + 1)
        assert share[at] == pytest.approx(1.0) and (moved[0] == moved[-1]).all()
        assert share[(at + AROUND // 2) % AROUND] == pytest.approx(0.0, abs=1e-12)
        steps = np.abs((np.arange(AROUND + 1) - at + AROUND // 2) % AROUND - AROUND // 2)
        assert (np.diff(share[np.argsort(steps, kind="stable")]) <= 1e-12).all()
