"""The editor: what calls may say, and undo and redo of what they do."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.history import History
from patterndb_sketch.retopo.arguments import (
    MOST_POINTS,
    REQUIRED,
    Argument,
    Flag,
    Kind,
    Number,
    PointList,
    Vector,
    Word,
    read_arguments,
)
from patterndb_sketch.retopo.editor import DEPTH, TOOLS, Call, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import fill_network
from patterndb_sketch.retopo.network import Network, are_equal
from patterndb_sketch.retopo.tool import State
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, do, drawn_grid, line
from tests.support.retopo.networks import plane
from tests.support.shared import CHECKOUT

NAN, INF = math.nan, math.inf


@pytest.fixture
def editor(source: PatternSource) -> Retopology:
    return Retopology(plane(), source, SIZES)


@pytest.mark.parametrize(
    ("kind", "value", "read"),
    [
        (Number(), 2, 2.0),
        (Number(0, 1), np.float32(0.5), 0.5),
        (Number(1, 5, whole=True), 5.0, 5),
        (Number(1, 5, whole=True), np.int64(1), 1),
        (Word(("a", "b")), "b", "b"),
        (Flag(), False, False),
    ],
)
def test_values_are_read(kind: Kind, value: object, read: object) -> None:
    found = kind.read("x", value)
    assert found == read
    assert type(found) is type(read)


def test_points_are_read_as_arrays() -> None:
    for value in ([1, 2, 3], (1, 2, 3), np.array([1, 2, 3])):
        assert Vector().read("x", value).tolist() == [1.0, 2.0, 3.0]
    assert Vector().read("x", [0, 0, 0]).dtype == np.float64
    for size in (1e-300, 1.0, 3.0, 1e300):
        direction = Vector(direction=True).read("x", [0, 0, -size])
        assert direction.tolist()[:2] == [0.0, 0.0]
        assert -1.0 <= direction[2] <= -0.5
    points = PointList(1).read("x", [[1, 2, 3]])
    assert (points.shape, points.dtype) == ((1, 3), np.float64)


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        (Number(), True, "x is True; give a number"),
        (Number(), "1", "x is '1'; give a number"),
        (Number(), NAN, "x is nan; give a number"),
        pytest.param(Number(), 10**400, "give a number", id="huge"),
        (Number(0), -1, "x is -1; give a number from 0 on"),
        (Number(0, 2), 3, "x is 3; give a number from 0 to 2"),
        (Number(0, 2, whole=True), 1.5, "x is 1.5; give a whole number from 0 to 2"),
        (Number(whole=True), None, "x is None; give a whole number"),
        (Word(("a", "b")), "c", """x is 'c'; give one of "a", "b\""""),
        (Word(("a", "b")), ["a"], "x is ['a']; give one of"),
        (Flag(), 1, "x is 1; give true or false"),
        (Vector(), [1, 2], "x is [1, 2]; give [x, y, z]"),
        (Vector(), [1, 2, INF], "x is [1, 2, inf]; give [x, y, z]"),
        (Vector(), [1, 2, "3"], "give [x, y, z]"),
        (Vector(), {0: 1, 1: 2, 2: 3}, "give [x, y, z]"),
        (Vector(direction=True), [0, 0.0, 0], "x is [0, 0.0, 0]; give [x, y, z], not all 0"),
        (PointList(), [[0, 0, 0]], "x has 1 points; give 2 points [x, y, z] or more"),
        (PointList(), 5, "x is 5; give 2 points"),
        (PointList(), [[0, 0, 0], [1, 0]], "x[1] is [1, 0]; give [x, y, z]"),
        (PointList(), np.zeros((MOST_POINTS + 1, 3)), f"x has {MOST_POINTS + 1} points"),
        (PointList(), np.array(3.0), "give 2 points"),
        (Vector(), np.array(3.0), "give [x, y, z]"),
    ],
)
def test_other_values_are_refused_with_what_is_wanted(
    kind: Kind, value: object, message: str
) -> None:
    with pytest.raises(InvalidRetopoError, match=re.escape(message)):
        kind.read("x", value)


JUNK = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=3)
    | st.binary(max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=2), inner),
    max_leaves=8,
)


@given(JUNK)
def test_any_value_is_read_or_refused(value: object) -> None:
    kinds = (
        Number(),
        Number(0, 9, True),
        Word(("a",)),
        Flag(),
        Vector(),
        Vector(True),
        PointList(),
    )
    for kind in kinds:
        try:
            found = kind.read("x", value)
        except InvalidRetopoError:
            continue
        if isinstance(found, np.ndarray):
            assert np.isfinite(found).all()
            assert found.shape[-1] == 3
        else:
            assert isinstance(found, bool | str) or math.isfinite(found)


def test_arguments_are_known_complete_and_have_defaults() -> None:
    known = {"a": Argument(Number(), "one"), "b": Argument(Flag(), "two", False)}
    assert read_arguments("t", known, {"a": 1}) == {"a": 1.0, "b": False}
    assert read_arguments("t", known, {"b": True, "a": 1}) == {"a": 1.0, "b": True}
    with pytest.raises(InvalidRetopoError, match="t has no argument 'c'; there are a, b"):
        read_arguments("t", known, {"a": 1, "c": 1})
    with pytest.raises(InvalidRetopoError, match="t needs a: a number"):
        read_arguments("t", known, {"b": True})
    with pytest.raises(InvalidRetopoError, match="t: a is None"):
        read_arguments("t", known, {"a": None})
    with pytest.raises(InvalidRetopoError, match="there are none"):
        read_arguments("t", {}, {"a": None})


@pytest.mark.parametrize("name", sorted(TOOLS))
def test_tools_explain_themselves_and_their_defaults_may_be_given(name: str) -> None:
    tool = TOOLS[name]
    assert tool.name == name
    assert tool.help.endswith(".")
    for one, argument in tool.arguments.items():
        assert argument.help
        assert argument.kind.wanted
        if argument.default is not REQUIRED and argument.default is not None:
            assert argument.kind.read(one, argument.default) == argument.default


def test_a_tool_that_there_is_not_is_an_error(editor: Retopology) -> None:
    with pytest.raises(InvalidRetopoError, match="there is no tool 'strike'; there are stroke,"):
        editor.do(Call("strike"))
    with pytest.raises(InvalidRetopoError, match="undo has no argument 'by'; there are none"):
        editor.do(Call("undo", {"by": 2}))
    assert editor.undoable == 0


@pytest.mark.parametrize(
    ("tool", "arguments", "message"),
    [
        ("erase", {}, "erase needs one of points, at and open"),
        ("erase", {"open": False}, "erase needs one of"),
        ("erase", {"at": [0, 0, 0], "open": True}, "erase needs one of"),
        ("subdivide", {"at": [0, 0, 0]}, "subdivide needs one of count, by and free"),
        ("subdivide", {"at": [0, 0, 0], "by": 1, "free": True}, "subdivide needs one of"),
        ("subdivide", {"by": 1}, "subdivide needs at"),
        ("flow", {}, "flow needs one of points, and clear"),
        ("flow", {"points": line((0, 0), (1, 0)), "clear": [0, 0, 0]}, "flow needs one of"),
        ("choose", {"at": [0.5, 0.5, 0]}, "choose needs by"),
        ("choose", {"at": [0.5, 0.5, 0], "by": 1, "number": 1}, "choose needs by"),
        ("sizes", {}, "sizes needs one or more of snap, spine"),
        ("sizes", {"sampling": 1e-9}, "sizes: sampling is 1e-09; on this surface give 0.00141 to"),
        ("recount", {"edge": 1e-5}, "recount: edge is 1e-05; on this surface give 0.0141 to"),
        ("spine", {"points": line((0, 0), (1, 0)), "width": 1e9}, "spine: width is 1e"),
        ("knot", {"at": [0, 0, 0], "radius": 1e9}, "knot: radius is 1e"),
        ("autocomplete", {"at": [0, 0, 0], "radius": 1e9}, "autocomplete: radius is 1e"),
        ("knot", {"at": [0, 1e300, 0]}, r"the point \[0, 1e\+300, 0\] is far from the surface"),
        ("stroke", {"points": line((0, 0), (0, 40))}, "is far from the surface, whose box is"),
        ("stroke", {"points": line((0, 0), (5, 0)) * 3000}, "would have 1,499,750 points"),
    ],
)
def test_calls_that_make_no_sense_are_errors_and_change_nothing(
    editor: Retopology, tool: str, arguments: dict[str, object], message: str
) -> None:
    before = editor.state
    with pytest.raises(InvalidRetopoError, match=message):
        editor.do(Call(tool, arguments))
    assert editor.state is before
    assert editor.undoable == 0


def test_what_is_refused_or_changes_nothing_is_no_step(editor: Retopology) -> None:
    do(editor, "stroke", points=line((0, 0), (1, 0)))
    before = editor.state
    for call, why in (
        (Call("choose", {"at": [0, 0, 0], "by": 1}), "there is no patch here"),
        (Call("knot", {"at": [4, 4, 0]}), "."),
        (Call("redo"), "there is nothing to redo"),
        (Call("subdivide", {"at": [3, 3, 0], "by": 1}), "no curve is near"),
    ):
        outcome = editor.do(call)
        assert not outcome.changed
        assert re.search(why, outcome.refused or "")
    outcome = editor.do(Call("sizes", {"edge": SIZES.edge}))
    assert (outcome.changed, outcome.refused) == (False, None)
    assert editor.state is before
    assert (editor.undoable, editor.redoable) == (1, 0)


def test_undo_and_redo_walk_the_same_states(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    do(editor, "subdivide", at=[0.5, 0, 0], count=6)
    editor.fill()
    do(editor, "flow", points=line((0.1, 0.5), (0.9, 0.5)))
    editor.fill()
    do(editor, "choose", at=[1.5, 1.5, 0], by=1)
    do(editor, "erase", at=[1, 0.5, 0])
    editor.fill()
    do(editor, "sizes", edge=0.2)
    forwards = [editor.state]
    while editor.do(Call("undo")).changed:
        forwards.append(editor.state)
    assert len(forwards) == editor.redoable + 1
    assert not are_equal(forwards[0].network, forwards[-1].network)
    for state in forwards[-2::-1]:
        assert editor.do(Call("redo")).changed
        assert editor.state is state
    assert editor.redoable == 0


def test_states_do_not_change_behind_ones_back(source: PatternSource) -> None:
    """Arrays of earlier states are not written to by later calls."""
    editor = drawn_grid(source, 2)
    editor.fill()
    before = editor.state
    copies = {c: chain.points.copy() for c, chain in before.network.chains.items()}
    do(editor, "knot", at=[1, 1, 0], radius=0.4)
    do(editor, "stroke", points=line((-0.5, 0.5), (2.5, 0.5)))
    editor.fill()
    editor.do(Call("undo"))
    editor.do(Call("undo"))
    assert editor.state is before
    assert all((chain.points == copies[c]).all() for c, chain in before.network.chains.items())


def test_a_new_action_clears_what_was_undone(editor: Retopology) -> None:
    do(editor, "stroke", points=line((0, 0), (1, 0)))
    do(editor, "stroke", points=line((0, 1), (1, 1)))
    do(editor, "undo")
    assert (editor.undoable, editor.redoable) == (1, 1)
    do(editor, "sizes", edge=0.2)
    assert (editor.undoable, editor.redoable) == (2, 0)
    assert editor.do(Call("redo")).refused == "there is nothing to redo"


@settings(max_examples=30)
@given(st.lists(st.sampled_from(["step", "undo", "redo", "settle"]), max_size=400))
def test_history_is_that_of_two_lists(names: list[str]) -> None:
    """With a depth that is kept; ``settle`` replaces what is now."""
    states = iter([State(Network(), SIZES) for _ in range(len(names) + 1)])
    first = next(states)
    history = History(first)
    past, now, future = [], first, []
    for name in names:
        match name:
            case "step":
                past, now, future = [*past, now][-DEPTH:], next(states), []
                history.step(now)
            case "settle":
                now = next(states)
                history.settle(now)
            case "undo":
                assert history.undo() == bool(past)
                if past:
                    future, now = [*future, now], past.pop()
            case _:
                assert history.redo() == bool(future)
                if future:
                    past, now = [*past, now], future.pop()
        assert history.now is now
        assert (history.undoable, history.redoable) == (len(past), len(future))


def test_150_steps_can_be_undone(editor: Retopology) -> None:
    for k in range(DEPTH + 10):
        do(editor, "sizes", edge=0.2 + 0.001 * k)
    assert editor.undoable == DEPTH == 150
    assert sum(editor.do(Call("undo")).changed for _ in range(DEPTH + 10)) == DEPTH
    assert editor.sizes.edge == pytest.approx(0.2 + 0.001 * 9)


def test_filling_is_no_step_and_survives_undo(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    steps = editor.undoable
    assert editor.filled is None
    found = editor.fill()
    assert editor.filled is found
    assert editor.undoable == steps
    assert editor.network is found.network
    assert all(editor.network.patches[p].choice is not None for p in found.placed)
    do(editor, "erase", at=[1, 0.5, 0])
    assert editor.filled is None
    do(editor, "undo")
    assert editor.network is found.network
    again = editor.fill()
    assert again.network is found.network
    assert all(again.placed[p] is placed for p, placed in found.placed.items())


def test_what_was_filled_elsewhere_is_kept_for_its_own_network_alone(
    source: PatternSource,
) -> None:
    editor = drawn_grid(source, 2)
    network = editor.network
    found = fill_network(network, editor.surface, source, editor.sizes.edge)
    do(editor, "sizes", edge=0.3)
    do(editor, "erase", at=[1, 0.5, 0])
    before = editor.state
    assert not editor.adopt(network, found)
    assert editor.state is before
    do(editor, "undo")
    assert editor.adopt(network, found)
    assert editor.network is found.network
    assert editor.sizes.edge == 0.3
    assert editor.redoable == 1


def test_a_restored_state_is_where_history_begins(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    editor.fill()
    saved = editor.state
    other = Retopology(plane(), source)
    do(other, "stroke", points=line((0, 0), (1, 0)))
    other.restore(saved)
    assert other.state is saved
    assert (other.undoable, other.redoable) == (0, 0)
    assert other.fill().network is saved.network


def test_random_calls_of_all_tools_leave_what_must_hold() -> None:
    """Few of them; the benchmark makes thousands."""
    found = subprocess.run(
        [sys.executable, "-m", "benchmarks.retopo_editing", "--calls", "150", "--seed", "7"],
        cwd=CHECKOUT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stdout + found.stderr
    told = json.loads(found.stdout)
    assert told["failures"] == []
    assert "\n150 of 150 calls, " in found.stderr
    done = {name.split(":")[0] for name in told["outcomes"] if name.endswith(": done")}
    assert {"stroke", "erase", "undo"} <= done
