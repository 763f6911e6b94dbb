"""Templates: quads of any resolution whose features follow the curves of a network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import (
    ChainStep,
    FeatureChain,
    FeatureCurves,
    TemplatePart,
    box_template,
    join_features,
    template_of_name,
)
from patterndb_sketch.features.registration.boxes import read_car
from patterndb_sketch.features.registration.template import find_parts, list_edges, sample_features
from tests.support.features.registration import R, car_template, laid, rim, sheet


def euler(quads: np.ndarray) -> int:
    return len(np.unique(quads)) - len(list_edges(quads)) + len(quads)


@settings(max_examples=20, deadline=None)
@given(st.integers(2, 9), st.integers(2, 12))
def test_boxes_have_four_five_and_four_faces(r: int, along: int) -> None:
    """Each component is a disk, its quads turned alike, with the count of vertices that its
    faces, edges and corners add up to; the body has the bottom besides the roof's four faces."""
    template = box_template(r, along)
    a, b = r - 2, along - 2
    # Faces: front, top, rear, side, bottom; r x r or r x along inner vertices.
    counts = {
        # Edges along: the rail, the belt and the profile of the roof; of 11 the rest across or up.
        "roof": 8 + (8 * a + 3 * b) + (2 * a * a + 2 * a * b),
        # The shoulder, the sill, the upper and the lower profile of 12.
        "body": 8 + (8 * a + 4 * b) + (2 * a * a + 3 * a * b),
        # The two arches' tops and the inner sill of 11.
        "front_wheelhouse": 8 + (8 * a + 3 * b) + (2 * a * a + 2 * a * b),
    }
    counts["rear_wheelhouse"] = counts["front_wheelhouse"]
    for number, part in enumerate(template.parts):
        assert int((template.of_part == number).sum()) == counts[part.name]
        assert euler(template.part_quads(part.name)) == 1
        assert (
            len(set(find_parts(template.quads, template.n_vertices)[template.of_part == number]))
            == 1
        )
    if r == along:
        assert template.n_vertices == 32 + 45 * a + 17 * a * a
    assert {len(chain.vertices) for chain in template.chains} <= {r, along}


def test_the_plane_has_the_border_that_is_mirrored() -> None:
    """Of roof and body the whole border but the openings; of wheelhouses nothing."""
    template = car_template()
    in_plane = [c.name for c in template.chains if template.plane[c.vertices].all()]
    assert sorted(in_plane) == [
        "bottom_profile", "front_profile", "rear_profile", "rear_window_profile", "roof_profile",
        "upper_profile", "windscreen_profile",
    ]  # fmt: skip
    assert template.in_plane()[1] == {corner for box in read_car().boxes for corner in box.middle}


def test_the_joints_are_the_corners_of_the_network() -> None:
    """Derived from the features alone, and none other than what the network says."""
    template = car_template()
    joints = {joint.name: set(joint.curves) for joint in template.joints(template.curves)}
    corners = read_car().corners
    assert set(joints) == set(corners)
    for corner, curves in corners.items():
        assert set(curves) <= joints[corner]


def test_feature_vertices_sample_their_curves_uniformly() -> None:
    """At equal arc length, ends included, on the curve itself; corners bit for bit."""
    template, found = car_template(), laid()
    for chain in template.chains:
        places = found.points[chain.vertices]
        assert np.array_equal(places[0], found.network.nodes[chain.steps[0].start])
        assert np.array_equal(places[-1], found.network.nodes[chain.steps[-1].end])
        if len(chain.steps) > 1:
            continue
        step = chain.steps[0]
        curve = found.network.curves[step.curve]
        ends = (found.network.parameters[step.curve, corner] for corner in (step.start, step.end))
        t = np.linspace(*ends, 20_001)
        dense = curve(t)
        k = [int(np.linalg.norm(dense - place, axis=1).argmin()) for place in places]
        lengths = arc_length(dense)
        assert lengths[k] == pytest.approx(
            np.linspace(0.0, lengths[-1], len(places)), abs=2e-4 * lengths[-1]
        )
        step_length = lengths[-1] / 20_000
        assert np.linalg.norm(dense[k] - places, axis=1).max() < step_length


def test_a_feature_along_several_curves_is_uniform_along_all() -> None:
    found = laid()
    sill = next(chain for chain in car_template().chains if chain.name == "sill")
    steps = np.linalg.norm(np.diff(found.points[sill.vertices], axis=0), axis=1)
    assert len(sill.steps) == 5
    assert steps == pytest.approx(np.full(R - 1, steps.mean()), rel=0.01)


def test_every_model_has_the_same_connectivity() -> None:
    one, other = laid("sedan"), laid("pickup")
    assert np.array_equal(one.quads, other.quads)
    assert [f.name for f in one.features] == [f.name for f in other.features]
    assert one.points.shape == other.points.shape
    assert not np.allclose(one.points, other.points, atol=0.1)


def test_names_of_templates() -> None:
    assert template_of_name("box:car?r=6").n_vertices == car_template().n_vertices
    assert template_of_name("box:car").n_vertices == 1814
    assert template_of_name("box:roof+body?r=4&along=7").name == "box:roof+body?r=4&along=7"
    assert [part.name for part in template_of_name("box:body?r=3").parts] == ["body"]
    for wrong in ("car", "box:", "sphere:car", "box:car?q=3", "box:car?r=-3", "box:car?r=1"):
        with pytest.raises(InvalidFeatureError):
            template_of_name(wrong)
    with pytest.raises(InvalidFeatureError, match="components are roof"):
        template_of_name("box:boot")


def test_a_curve_that_may_be_missing_is_bridged() -> None:
    template = replace(sheet(5), bridged=("north",))
    curves = rim()
    del curves["north"]
    # The corners ne and nw are left with a curve each; another says where it ends.
    with pytest.raises(InvalidFeatureError, match="only east ends at ne"):
        join_features(FeatureCurves(curves), template.joints(list(curves)))
    chains = tuple(
        FeatureChain(c.name, c.vertices, (ChainStep("tie", "ne", "nw"),))
        if c.name == "north"
        else c
        for c in template.chains
    )
    tied = replace(template, chains=chains, bridged=())
    full = curves | {"tie": rim()["north"]}
    network = join_features(FeatureCurves(full), tied.joints(list(full)))
    places, notes = sample_features(template, network)
    assert notes == ("there is no curve north: a straight line takes its place",)
    line = places[template.chains[2].vertices]
    assert line == pytest.approx(np.linspace(network.nodes["ne"], network.nodes["nw"], 5))


def test_what_is_no_template_is_refused() -> None:
    good = sheet(4)
    quads = good.quads.copy()
    quads[0] = quads[0][::-1]
    chain = good.chains[0]
    wrong = {
        "run through twice": {"quads": quads},
        "outside 0..15": {"quads": good.quads + 1},
        "in no quad": {"quads": good.quads[1:]},
        "quads \\(q, 4\\)": {"quads": good.quads[:, :3]},
        "plane must be": {"plane": np.zeros(3, bool)},
        "needs features": {"chains": ()},
        "there is no such edge": {"chains": (FeatureChain("x", np.array([0, 5]), chain.steps),)},
        "each once": {"chains": (FeatureChain("x", np.array([0, 1, 0]), chain.steps),)},
        "have the name south": {"chains": (chain, chain)},
        "one corner": {
            "chains": (
                FeatureChain(
                    "x", chain.vertices, (ChainStep("a", "1", "2"), ChainStep("b", "3", "4"))
                ),
            )
        },
        "is at sw and at": {
            "chains": (chain, FeatureChain("x", np.array([0, 4]), (ChainStep("a", "up", "down"),)))
        },
        "runs through vertex 1": {
            "chains": (chain, FeatureChain("x", np.array([1, 5]), (ChainStep("a", "up", "down"),)))
        },
        "yields to": {"parts": (TemplatePart("sheet", ("lid",)),)},
    }
    for match, change in wrong.items():
        with pytest.raises(InvalidFeatureError, match=match):
            replace(good, **change)
    crossing = FeatureChain("x", np.array([5, 1, 2]), (ChainStep("a", "up", "down"),))
    with pytest.raises(InvalidFeatureError, match="cross at vertex 1"):
        replace(good, chains=(FeatureChain("s", np.array([0, 1, 2, 3]), chain.steps), crossing))


def test_a_part_without_a_feature_is_refused() -> None:
    """Nothing would hold its vertices: the membrane's system would be singular."""
    good = sheet(3)
    quads = np.concatenate([good.quads, good.quads + 9])
    with pytest.raises(InvalidFeatureError, match="no feature holds the part"):
        replace(good, quads=quads, of_part=np.zeros(18, np.int32), plane=np.zeros(18, bool))
