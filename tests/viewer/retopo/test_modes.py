"""The modes of the window of retopology, and how it looks at things."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import Argument, Flag, Number, Vector, Word
from patterndb_sketch.retopo.editor import TOOLS
from patterndb_sketch.retopo.picking import find_upright
from patterndb_sketch.retopo.tool import Result, Tool
from query.engine import PatternSource
from tests.support.viewer.sheets import at, curves, keys, opened, press, square, tube
from viewer.retopo import RetopoState
from viewer.retopo.keys import KEYS
from viewer.retopo.modes import list_modes, make_mode
from viewer.retopo.pointing import find_visible, pick_foot


def test_every_tool_of_the_table_has_a_mode_and_a_key_of_its_own() -> None:
    made = list_modes()
    assert {mode.tool for mode in made} == {
        name for name, tool in TOOLS.items() if tool.control.mode
    }
    known = [mode.key for mode in made if mode.key]
    assert len(set(known)) == len(known)
    assert set(known) <= set(KEYS.actions)


def test_a_new_tool_is_a_mode_by_its_entry_in_the_table() -> None:
    def act(work: object, arguments: object) -> Result:
        raise AssertionError

    at_point = Argument(Vector(), "a point")
    click_one = make_mode(
        Tool(
            "shine",
            "Make it shine.",
            {
                "at": at_point,
                "how": Argument(Word(("a", "b")), "how", "b"),
                "times": Argument(Number(1, 9, whole=True), "times", 3),
                "twice": Argument(Flag(), "twice", False),
                "radius": Argument(Number(0.0), "reach", None),
            },
            act,
        )
    )
    assert click_one is not None
    assert (click_one.gesture, click_one.places, click_one.key) == ("click", ("at",), "")
    assert [(o.name, o.values[:2], o.number) for o in click_one.options] == [
        ("how", ("b", "a"), False),
        ("times", (3, 1), True),
        ("twice", (False, True), False),
    ]
    assert (click_one.brush, click_one.given_as) == ("brush", "radius")
    two = make_mode(Tool("shift", "Shift.", {"at": at_point, "to": at_point}, act))
    assert two is not None and (two.gesture, two.places) == ("drag", ("at", "to"))
    none = make_mode(Tool("tidy", "Tidy.", {}, act))
    assert none is not None and none.gesture == "act"
    wants = {"amount": Argument(Number(), "how much")}
    assert make_mode(Tool("measure", "Measure.", wants, act)) is None


def test_tools_and_options_are_gone_through(state: RetopoState) -> None:
    state.choose_mode("cylinder")
    number = state.tool.modes.index(state.tool.mode)
    caps = next(option for option in state.tool.mode.options if option.name == "caps")
    state.turn_option(caps, "always")
    assert state.tool.option(state.tool.mode, caps) == "always"
    for value in (*caps.values[caps.values.index("always") + 1 :], caps.values[0]):
        state.next_option()
        assert state.tool.option(state.tool.mode, caps) == value
    state.next_mode(-1)
    assert state.tool.mode is state.tool.modes[number - 1]


def test_escape_lets_go(state: RetopoState) -> None:
    press(state, (-1.0, 0.0), (1.0, 0.0))
    assert state.tool.holding and len(state.tool.line) > 2
    assert state.leave() and not state.tool.holding and state.tool.line == []
    state.release(*at(state, (1.0, 0.0)))
    state.settle()
    assert curves(state) == []
    assert not state.leave()


def test_looks_and_sizes_of_the_picture(state: RetopoState) -> None:
    square(state)
    seen = [(state.quads_shown, state.curves_shown)]
    for _ in range(3):
        keys(state, "x")
        seen.append((state.quads_shown, state.curves_shown))
    assert seen == [(True, True), (False, True), (True, False), (True, True)]
    keys(state, "m m")
    assert state.camera.model_look == "hidden"
    keys(state, "m")
    for key, axis in (("1", 0), ("2", 1), ("3", 2)):
        keys(state, f"v {key}")
        assert np.allclose(state.camera.view.axes[2], np.eye(3)[axis])
        keys(state, key)
        assert np.allclose(state.camera.view.axes[2], -np.eye(3)[axis]), "twice: from behind"
    keys(state, "Z Z Z v F")
    assert state.camera.upright == "y"


def test_what_the_pointer_is_on_is_what_is_seen_there(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        state.camera.look_along((1.0, 0.0, 0.0))
        rng = np.random.default_rng(4)
        z, y = rng.uniform(-2.9, 2.9, 40), rng.uniform(-0.95, 0.95, 40)
        for one in np.stack([np.sqrt(1.0 - y * y), y, z], axis=1).tolist():
            foot = pick_foot(state.camera.view, state.surface, *at(state, one))
            assert foot is not None
            # The tube has flat facets, at most 1 - cos(pi / 48) within the round one.
            assert np.abs(foot.points[0, 1:] - one[1:]).max() < 1e-9
            assert 0.0 <= one[0] - foot.points[0, 0] < 0.02
        assert pick_foot(state.camera.view, state.surface, *at(state, (0.0, 1.2, 0.0))) is None
        places = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.3, 0.0]])
        assert find_visible(state.camera.view, state.surface, places).tolist() == [
            True,
            False,
            True,
        ]
    finally:
        state.close()


def box(base: int, *, upwards: bool = False) -> Surface:
    """A pyramid with a square base of 2, at the lower end of an axis or the upper one."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 3]], np.float64)
    faces = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    if upwards:
        corners[:, 2] *= -1.0
        faces = faces[:, ::-1]
    return Surface.from_arrays(
        np.roll(corners, base + 1, axis=1), np.ascontiguousarray(faces)
    ).orient()


def test_what_stands_along_z_is_upright_at_first(source: PatternSource) -> None:
    assert [find_upright(box(axis)) for axis in range(3)] == ["y", "y", "z"]
    assert find_upright(box(2, upwards=True)) == "y" and find_upright(tube()) == "y"
    state = opened(source, box(2))
    try:
        assert state.camera.upright == "z"
        top, bottom = state.camera.view.seen(np.array([[0.0, 0.0, 3.0], [0.0, 0.0, 0.0]]))
        assert top[1] > bottom[1] and abs(top[0] - bottom[0]) < 1e-9
        keys(state, "Z")
        assert state.camera.upright != "z"
        keys(state, "Z Z v")
        assert state.camera.upright == "z"
    finally:
        state.close()
