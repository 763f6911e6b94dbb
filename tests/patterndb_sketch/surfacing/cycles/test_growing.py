"""Growing sketches: every stage equals a run from scratch, and only what changed is done again."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing import SurfaceRequest, Surfacing, find_cycles, read_drawing, surface
from patterndb_sketch.surfacing.surfaces import GrowingSketch
from tests.support.shared import CHECKOUT
from tests.support.surfacing.networkfiles import list_graphs

TEACUP = CHECKOUT / "examples" / "networks" / "teacup.json"


#: Stages from one comparison with a run from scratch to the next.
EVERY = 4


def same(one: Surfacing, other: Surfacing) -> bool:
    """The same vertices and the same faces, bit for bit?"""
    return np.array_equal(one.points, other.points) and all(
        a.cycle == b.cycle
        and len(a.faces) == len(b.faces)
        and all(np.array_equal(f, g) for f, g in zip(a.faces, b.faces, strict=True))
        for a, b in zip(one.patches, other.patches, strict=True)
    )


def from_scratch(network: CurveNetwork, spacing: float) -> Surfacing:
    return surface(network, find_cycles(network).cycles, spacing=spacing)


@pytest.mark.parametrize("path", [TEACUP, *list_graphs("01-2-2")], ids=lambda path: path.stem)
def test_stages_equal_runs_from_scratch(path: object) -> None:
    drawing = read_drawing(str(path))
    growing = GrowingSketch()
    reused = 0
    for n in range(1, len(drawing.stages) + 1):
        network = drawing.after(n)
        stage = growing.stage(network)
        reused += sum(p.reused for p in stage.surfacing.patches) if stage.surfacing else 0
        if n % EVERY and n < len(drawing.stages):
            continue
        assert {c.key for c in stage.found.cycles} == {c.key for c in find_cycles(network).cycles}
        if stage.surfacing is None:
            assert not stage.found.cycles
            continue
        assert growing.spacing is not None
        assert same(stage.surfacing, from_scratch(network, growing.spacing))
    assert reused > 0
    # The same stage again is all known.
    again = growing.stage(drawing.network).surfacing
    assert again is not None
    assert all(patch.reused for patch in again.patches)


def test_only_loops_that_changed_are_surfaced_again() -> None:
    drawing = read_drawing(TEACUP)
    growing = GrowingSketch()
    before = growing.stage(drawing.after(5)).surfacing
    after = growing.stage(drawing.network).surfacing
    assert before is not None
    assert after is not None
    # The handle touches nothing: all that was there is as it was.
    new = [patch for patch in after.patches if not patch.reused]
    assert [after.network.names(patch.cycle) for patch in new] == [["handle"]]
    assert len(after.patches) == len(before.patches) + 1


def test_other_settings_make_other_surfaces() -> None:
    network = read_drawing(TEACUP).network
    growing = GrowingSketch()
    growing.stage(network)
    growing.options = SurfaceRequest(method="area")
    made = growing.stage(network).surfacing
    assert made is not None
    assert {patch.method for patch in made.patches} == {"area"}
    assert not any(patch.reused for patch in made.patches)


def test_cycles_are_banned_and_added_stage_by_stage() -> None:
    network = read_drawing(TEACUP).network
    growing = GrowingSketch()
    every = growing.stage(network).found.cycles
    (lid,) = [cycle for cycle in every if network.names(cycle) == ["rim"]]
    without = growing.stage(network, banned=[lid])
    assert {c.key for c in without.found.cycles} == {c.key for c in every} - {lid.key}
    assert len(growing.stage(network, added=[lid]).found.cycles) == len(every)


def test_nothing_closed_has_no_surface() -> None:
    network = read_drawing(TEACUP).after(1)
    stage = GrowingSketch().stage(network)
    assert stage.found.cycles == ()
    assert stage.surfacing is None
