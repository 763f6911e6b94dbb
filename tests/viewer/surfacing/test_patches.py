"""Patches in the viewer of surfaces: pieces, methods, stages."""

from __future__ import annotations

import numpy as np
import pytest

import patterndb
from patterndb_sketch.curvenetwork.network import Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.methods import SurfaceRequest
from patterndb_sketch.surfacing.patchsurface import (
    PatchSurface,
    choose_piece_tints,
    find_neighbours,
)
from patterndb_sketch.surfacing.surfaces import surface
from tests.support.viewer.domes import (
    CYCLES,
    Finder,
    at,
    click,
    dome,
    drag,
    growing_dome,
    keys,
    on_keys,
    opened,
    pieces,
    said,
)
from tests.support.viewer.layers import count_segments
from viewer.style import TINTS
from viewer.surfacing.commands import KEYS
from viewer.surfacing.picture import IDLE, RIM, compose_surface
from viewer.surfacing.state import ALPHA, SurfacingState


def test_the_slider_changes_the_pieces(state: SurfacingState) -> None:
    counts = {}
    for share in (0.0, 0.5, 1.0):
        state.surfaces.change_alpha(ALPHA.value(share))
        state.settle()
        assert state.surfaces.settings.alpha == pytest.approx(share**2, abs=1e-3)
        counts[share] = pieces(state)
        wanted = surface(
            dome(),
            request=state.surfaces.settings.having(spacing=state.surfaces.made.task.spacing),
        )  # type: ignore[union-attr]
        assert [len(p.faces) for p in wanted.patches] == [
            len(p.faces) for p in state.surfaces.patches
        ]
    assert counts[0.0] > counts[0.5] > counts[1.0]


def test_keys_move_the_slider_and_stop_at_its_ends(state: SurfacingState) -> None:
    keys(state, "+ +")
    assert state.surfaces.settings.alpha > 0.1
    for _ in range(40):
        KEYS.press(state, "-")
    state.settle()
    assert state.surfaces.settings.alpha == 0.0 and pieces(state) > 16


def test_a_click_switches_a_patch_off_and_on(state: SurfacingState) -> None:
    every = on_keys(state)
    assert every == {cycle.key for cycle in CYCLES}
    click(state, 0.4, 0.4, 0.8)
    assert on_keys(state) == every - {CYCLES[0].key} and len(state.surfaces.off) == 1
    assert state.surfaces.edits.banned == (CYCLES[0],)
    ring = state.surfaces.rings()[0]
    click(state, *ring)
    assert on_keys(state) == every and not state.surfaces.off
    click(state, 0.4, 0.4, 0.8)
    click(state, -0.4, 0.4, 0.8)
    assert len(state.surfaces.patches) == 2
    keys(state, "a")
    assert on_keys(state) == every
    keys(state, "u u")
    assert on_keys(state) == every - {CYCLES[0].key}


def test_open_rims_and_curves_without_a_patch_are_marked(state: SurfacingState) -> None:
    def count(colour: str) -> int:
        return count_segments(compose_surface(state, 1040.0, 860.0), colour)

    assert count(RIM) and not count(IDLE), "the dome is open below, and has a patch at each curve"
    openings = state.surfaces.openings
    assert openings is not None and [len(rim.steps) for rim in openings.rims] == [4]
    click(state, 0.4, 0.4, 0.8)
    click(state, -0.4, 0.4, 0.8)
    openings = state.surfaces.openings
    assert openings is not None and openings.idle == (0, 1, 5)
    assert count(RIM) and count(IDLE)
    keys(state, "b")
    assert not count(RIM) and not count(IDLE)


def test_what_is_seen_through_a_patch_that_is_off_can_be_clicked(state: SurfacingState) -> None:
    # From the side, patch 1 is behind patch 0.
    state.close()
    state = opened(toward=(1.0, 0.9, 0.2), up=(0.0, 0.0, 1.0))
    try:
        x, y = at(state, *(np.ones(3) / np.sqrt(3.0)))
        state.move(x, y + 40.0)
        under = state.under()
        assert under is not None and state.surfaces.cycle_of(*under) == CYCLES[0]
        keys(state, "x")
        behind = state.under()
        assert behind is not None and behind.on and state.surfaces.cycle_of(*behind) != CYCLES[0]
        keys(state, "w")
        off = state.under()
        assert off is not None and not off.on
    finally:
        state.close()


def test_a_drag_turns_and_is_no_click(state: SurfacingState) -> None:
    before = state.camera.view.axes.copy()
    x, y = at(state, 0.4, 0.4, 0.8)
    drag(state, (x, y), (x + 30.0, y + 10.0))
    state.settle()
    assert len(state.surfaces.patches) == 4 and not np.allclose(state.camera.view.axes, before)
    turned = state.camera.view.axes.copy()
    state.press(x, y, turn=True)
    state.move(x + 2.0, y)
    state.release(x + 2.0, y)
    assert not np.allclose(state.camera.view.axes, turned) and len(state.surfaces.patches) == 4


def test_cycles_that_are_found_are_banned_and_kept(growing: SurfacingState) -> None:
    assert len(growing.surfaces.patches) == 4
    click(growing, 0.4, 0.4, 0.8)
    assert len(growing.surfaces.patches) == 3 and len(growing.surfaces.off) == 1
    assert growing.surfaces.made is not None and growing.surfaces.made.notes == (
        "found by the tests",
    )
    click(growing, *growing.surfaces.rings()[0])
    assert len(growing.surfaces.patches) == 4 and growing.surfaces.edits.added == (CYCLES[0],)


def test_stages_are_stepped_through(growing: SurfacingState) -> None:
    counts = {}
    keys(growing, "Ctrl+Home")
    for stage in range(4):
        assert growing.surfaces.edits.stage == stage
        counts[stage] = (len(growing.surfaces.network.curves), len(growing.surfaces.patches))
        keys(growing, "Right")
    # Meridians 4 and 6 are opposite: no quarter has both of its own before the last stage.
    assert counts == {0: (0, 0), 1: (4, 0), 2: (6, 0), 3: (8, 4)}
    keys(growing, "Left Left Left Left")
    assert growing.surfaces.edits.stage == 0
    keys(growing, "End")
    assert growing.surfaces.edits.stage == 3
    texts = " ".join(said(growing))
    assert "3 of 3" in texts


def test_choices_survive_a_walk_through_the_stages(growing: SurfacingState) -> None:
    click(growing, 0.4, 0.4, 0.8)
    x, y = at(growing, -0.4, 0.4, 0.8)
    growing.move(x, y)
    keys(growing, "n")
    methods = {
        growing.surfaces.cycle_of(True, i).key: p.method
        for i, p in enumerate(growing.surfaces.patches)
    }
    assert sorted(methods.values()) == ["area", "chords", "chords"]  # type: ignore[type-var]
    keys(growing, "Left Right")
    again = {
        growing.surfaces.cycle_of(True, i).key: p.method
        for i, p in enumerate(growing.surfaces.patches)
    }
    assert again == methods


def test_cycles_are_not_looked_for_again_when_only_alpha_changes() -> None:
    finder = Finder()
    state = opened(growing_dome(), find=finder)
    try:
        keys(state, "+ + m m")
        assert finder.calls == 1
        keys(state, "Left")
        assert finder.calls == 2
    finally:
        state.close()


def test_taking_a_stroke_back_makes_nothing_anew(state: SurfacingState) -> None:
    keys(state, "d")
    drag(state, at(state, 0.3, 0.3, 0.0), at(state, 0.5, 0.4, 0.0))
    made = state.surfaces.made
    keys(state, "u")
    assert state.surfaces.made is made and state.surfaces.edits.inks == ()
    keys(state, "u")
    assert "nothing to take back" in state.message


def test_a_drawing_without_stages_says_so(state: SurfacingState) -> None:
    keys(state, "Left")
    assert "no stages" in state.message and len(state.surfaces.patches) == 4


def test_methods_for_all_and_for_one() -> None:
    with patterndb.open() as db:
        state = opened(db=db)
        try:
            keys(state, "m")
            assert {patch.method for patch in state.surfaces.patches} == {"area"}
            keys(state, "m")
            assert {patch.method for patch in state.surfaces.patches} == {
                "quads"
            } and state.edges_shown
            assert all(p.shape[1] == 4 for patch in state.surfaces.patches for p in patch.faces)
            keys(state, "m")
            assert {patch.method for patch in state.surfaces.patches} == {"smooth"}
            keys(state, "m")
            assert {patch.method for patch in state.surfaces.patches} == {"chords"}
            state.move(*at(state, 0.4, 0.4, 0.8))
            keys(state, "n")
            assert [patch.method for patch in state.surfaces.patches].count("area") == 1
            keys(state, "u u u")
            assert {patch.method for patch in state.surfaces.patches} == {"quads"}
        finally:
            state.close()


def test_the_price_of_chords_cuts_loops_along_chords() -> None:
    state = opened(settings=SurfaceRequest())
    try:
        assert {patch.method for patch in state.surfaces.patches} == {"smooth"}
        keys(state, "+")
        assert {patch.method for patch in state.surfaces.patches} == {"chords"}
        assert "alpha" in state.message
    finally:
        state.close()


def test_patches_are_faired_and_left_by_themselves() -> None:
    state = opened(settings=SurfaceRequest())
    try:
        seen: list[np.ndarray] = []
        for key in ("", "f", "f"):
            keys(state, key)
            made = state.surfaces.made
            assert made is not None and made.surfacing is not None
            seen.append(made.surfacing.points)
            settings = SurfaceRequest(fair=key == "f" and len(seen) == 2)
            wanted = surface(dome(), request=settings.having(spacing=made.task.spacing))
            assert np.array_equal(made.surfacing.points, wanted.points)
            assert made.surfacing.notes == wanted.notes
        assert not np.array_equal(seen[0], seen[1])
    finally:
        state.close()


def test_fairing_needs_smooth_patches(state: SurfacingState) -> None:
    keys(state, "f")
    assert {patch.method for patch in state.surfaces.patches} == {"smooth"}
    assert "smooth" in state.message


def test_without_a_database_there_are_no_quads(state: SurfacingState) -> None:
    keys(state, "m m m")
    assert {patch.method for patch in state.surfaces.patches} == {"chords"}
    state.move(-state.camera.room[0] / 2.0 + 5.0, 0.0)
    keys(state, "n")
    assert "pointer" in state.message


def test_what_fails_is_told_and_leaves_the_last_surface() -> None:
    def broken(*_: object) -> tuple[list[Cycle], list[str]]:
        raise InvalidNetworkError("no cycles today")

    with pytest.raises(InvalidNetworkError, match="no cycles today"):
        opened(growing_dome(), find=broken)
    state = SurfacingState(growing_dome(), find=broken)
    try:
        with pytest.raises(InvalidNetworkError):
            state.settle()
        texts = " ".join(said(state))
        assert "no cycles today" in texts and "0 patches" in texts
    finally:
        state.close()


def test_neighbours_differ_and_colours_stay(state: SurfacingState) -> None:
    def colours() -> dict[object, tuple[int, ...]]:
        body = state.surfaces.body
        assert body is not None
        return {state.surfaces.cycle_of(True, i).key: t for i, t in enumerate(body.tint_of)}

    made = state.surfaces.made
    assert made is not None and made.surfacing is not None
    faces = [piece for patch in made.surfacing.patches for piece in patch.faces]
    owners = [i for i, patch in enumerate(made.surfacing.patches) for _ in patch.faces]
    tints = choose_piece_tints(faces, owners)
    beside = find_neighbours(faces)
    assert all(tints[a] != tints[b] for a in range(len(faces)) for b in beside[a])
    assert max(map(len, beside)) < len(TINTS)
    before = colours()
    click(state, 0.4, 0.4, 0.8)
    assert all(colours()[key] == before[key] for key in colours())
    keys(state, "u")
    assert colours() == before


def test_a_body_has_every_face_once() -> None:
    made = surface(dome(), method="chords", alpha=0.05)
    body = PatchSurface.of(made, {})
    assert len(body.corners) == len(made.triangles) == len(body.owners) == len(body.tints)
    assert (body.corners == made.points[made.triangles]).all()
    lengths = np.linalg.norm(body.normals, axis=2)
    assert np.allclose(lengths, 1.0)
    sides = body.corners[:, 1:] - body.corners[:, :1]
    own = np.cross(sides[:, 0], sides[:, 1])
    assert ((body.normals * own[:, None]).sum(axis=2) > 0.0).all(), "smooth, but not turned over"
    assert len(body.chords) == sum(len(patch.chords) for patch in made.patches)
