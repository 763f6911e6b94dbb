"""Every tool of the table: what its entry says, and that its calls keep what all calls keep.

One more tool is tested here by itself. If no call that is made up for it does anything on the
small drawing of :func:`made_up`, give one in CALLS.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import (
    REQUIRED,
    Argument,
    Flag,
    Number,
    PointList,
    Vector,
    Word,
    WordOrNumber,
)
from patterndb_sketch.retopo.editor import TOOLS, Call, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network import check_network
from patterndb_sketch.retopo.script import line_of, script_of
from patterndb_sketch.retopo.table import NOT_TOOLS, describe_tools, find_tools
from patterndb_sketch.retopo.tool import SNAP, Tool
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, do, line
from tests.support.retopo.networks import plane, sphere
from tests.support.shared import CHECKOUT

#: What a call may not say, whatever the argument is.
JUNK = (None, "no such word", [], {}, [[1, 2]], float("nan"), -1e30)

#: Places of the drawing: on a curve, in a patch, at a corner, beside all patches.
PLACES = ([1.0, 0.5, 0.0], [0.5, 0.5, 0.0], [1.0, 1.0, 0.0], [2.05, 0.5, 0.0])

#: Lines: across curves, within a patch, along a curve and beside it, in the open.
LINES = (
    line((-0.5, 0.5), (2.5, 0.5)),
    line((0.1, 0.5), (0.9, 0.5)),
    line((1.0, 0.1), (1.05, 0.3), (1.0, 0.9)),
    line((3.0, -1.0), (3.0, 1.0)),
)


def sheet() -> Surface:
    """A sheet from -5 to 5 both ways, of triangles as small as patches in a plane need them."""
    x, y = np.meshgrid(np.linspace(-5.0, 5.0, 81), np.linspace(-5.0, 5.0, 81), indexing="ij")
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Surface.from_arrays(
        np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1), triangles
    ).orient()


def grid(source: PatternSource) -> Retopology:
    """Four square patches, filled."""
    editor = Retopology(sheet(), source, SIZES)
    for k in range(3):
        do(editor, "stroke", points=line((k, 0), (k, 2)))
        do(editor, "stroke", points=line((0, k), (2, k)))
    assert len(editor.network.patches) == 4
    editor.fill()
    return editor


def rings(source: PatternSource) -> Retopology:
    """Two loops around a ball."""
    editor = Retopology(sphere(), source)
    for height in (-0.3, 0.3):
        do(editor, "loop", at=[0.95, 0.0, height], normal=[0.0, 0.0, 1.0])
    return editor


def bare(source: PatternSource) -> Retopology:
    """A ball with nothing on it."""
    return Retopology(sphere(), source)


def beside_edge(source: PatternSource) -> Retopology:
    """A curve on a box, beside one of its edges."""
    box = trimesh.creation.box((2.0, 2.0, 2.0)).subdivide().subdivide()
    editor = Retopology(Surface.from_arrays(box.vertices, box.faces).orient(), source)
    do(editor, "stroke", points=[[-0.6, 0.95, 1.0], [0.6, 0.95, 1.0]])
    return editor


def pair(source: PatternSource) -> Retopology:
    """A patch of 6, 4, 4 and 4 edges, with irregular vertices."""
    editor = Retopology(plane(), source, SIZES)
    for one, two in itertools.pairwise([(0, 0), (3, 0), (3, 2), (0, 2), (0, 0)]):
        do(editor, "stroke", points=line(one, two))
    for at, count in (((1.5, 0), 12), ((3, 1), 6), ((1.5, 2), 8), ((0, 1), 6)):
        do(editor, "subdivide", at=[*at, 0.0], count=count)
    editor.fill()
    return editor


def large(source: PatternSource) -> Retopology:
    """A loop too long to become a patch by itself."""
    editor = Retopology(sheet(), source, SIZES)
    corners = [(-4.5, -4.5), (4.5, -4.5), (4.5, 4.5), (-4.5, 4.5), (-4.5, -4.5)]
    for one, two in itertools.pairwise(corners):
        do(editor, "stroke", points=line(one, two))
    assert not editor.network.patches
    return editor


def bent(source: PatternSource) -> Retopology:
    """The four patches after the brush."""
    editor = grid(source)
    do(editor, "brush", at=[1.0, 1.0, 0.0], to=[1.3, 1.2, 0.0])
    editor.fill()
    return editor


#: Calls that do something, for tools whose made up calls on the grid do not.
CALLS: dict[str, tuple[Callable[[PatternSource], Retopology], dict[str, object]]] = {
    # Taken off, a loop that could be a patch is left, which is no sound network to other tests.
    "patch": (large, {"at": [0.0, 0.0, 0.0]}),
    "draft": (bare, {"edge": 0.3}),
    "cylinder": (rings, {"points": [[0.95, 0.0, -0.3], [1.0, 0.0, 0.0], [0.95, 0.0, 0.3]]}),
    "subdivide": (grid, {"at": [1.0, 0.5, 0.0], "by": 2}),
    "choose": (grid, {"at": [0.5, 0.5, 0.0], "by": 1}),
    "align": (beside_edge, {"at": [0.0, 0.95, 1.0]}),
    "relax": (bent, {"at": [1.0, 1.0, 0.0], "radius": 0.9}),
    "movepair": (pair, {"at": [1.5, 1.0, 0.0], "to": [2.0, 1.0, 0.0]}),
}


def values(argument: Argument) -> tuple[object, ...]:
    """Values of an argument to try."""
    kind = argument.kind
    if isinstance(kind, Vector):
        return ([1.0, 0.0, 0.2],) if kind.direction else PLACES
    if isinstance(kind, PointList):
        return LINES
    if isinstance(kind, Word):
        return kind.words
    if isinstance(kind, WordOrNumber):
        return (*kind.words, *values(replace(argument, kind=kind.number)))
    if isinstance(kind, Flag):
        return (True, False)
    assert isinstance(kind, Number)
    low, high = max(kind.low, 0.3), min(kind.high, 3.0)
    return (int(np.ceil(low)) if kind.whole else float(0.5 * (low + min(high, 0.5))),)


def made_up(tool: Tool) -> Iterator[dict[str, object]]:
    """Arguments to try: all that it must have, then one more of the others."""
    needed = [name for name, one in tool.arguments.items() if one.default is REQUIRED]
    others = [name for name in tool.arguments if name not in needed]
    for names in [needed, *([*needed, one] for one in others)]:
        for row in itertools.product(*(values(tool.arguments[name]) for name in names)):
            yield dict(zip(names, row, strict=True))


def calls(name: str) -> tuple[Callable[[PatternSource], Retopology], list[dict[str, object]]]:
    if name in CALLS:
        return CALLS[name][0], [CALLS[name][1]]
    return grid, list(itertools.islice(made_up(TOOLS[name]), 40))


@pytest.mark.parametrize("name", TOOLS)
def test_undo_restores_what_a_call_changed_and_what_is_refused_changes_nothing(
    name: str, source: PatternSource
) -> None:
    scene, tried = calls(name)
    editor = scene(source)
    did = 0
    for arguments in tried:
        before, steps = editor.state, editor.undoable
        try:
            outcome = editor.do(Call(name, arguments))
        except InvalidRetopoError:
            assert editor.state is before
            continue
        if not outcome.changed:
            assert editor.state is before and editor.undoable == steps
            continue
        check_network(editor.network)
        after = editor.state
        assert editor.undoable == steps + 1 and not after.same(before)
        do(editor, "undo")
        assert editor.state is before
        do(editor, "redo")
        assert editor.state is after
        do(editor, "undo")
        did += 1
        if did == 3:
            break
    assert did, f"no call of {name} did anything: give one in CALLS"


@pytest.mark.parametrize("name", TOOLS)
def test_wrong_arguments_are_refused_with_what_is_wanted(name: str, source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    before, tool = editor.state, TOOLS[name]
    with pytest.raises(InvalidRetopoError, match=f"{name} has no argument 'colour'; there are "):
        editor.do(Call(name, {"colour": "red"}))
    given = next(made_up(tool))
    for word, argument in tool.arguments.items():
        for value in JUNK:
            with pytest.raises(InvalidRetopoError) as told:
                editor.do(Call(name, given | {word: value}))
            assert str(told.value).startswith(f"{name}: {word}")
            assert argument.kind.wanted in str(told.value) or "give " in str(told.value)
        if argument.default is REQUIRED:
            rest = {one: value for one, value in given.items() if one != word}
            with pytest.raises(InvalidRetopoError, match=f"{name} needs {word}: "):
                editor.do(Call(name, rest))
    assert editor.state is before and editor.undoable == 0


@pytest.mark.parametrize("name", TOOLS)
def test_the_guide_lists_the_tool_and_its_arguments(name: str) -> None:
    guide = (CHECKOUT / "docs" / "retopo.md").read_text(encoding="utf-8")
    assert f"| `{name}` | | {TOOLS[name].help} |" in guide
    for tool, word, said in describe_tools():
        if tool == name and word:
            assert f"| | `{word}` | {said} |" in guide


@pytest.mark.parametrize("name", TOOLS)
def test_a_script_says_every_call_of_the_tool(name: str) -> None:
    for arguments in itertools.islice(made_up(TOOLS[name]), 5):
        call = Call(name, arguments)
        first = json.dumps({"tool": "open", "surface": "a.obj"})
        assert script_of([first, line_of(call)]).lines[0].call == call


def test_no_tool_takes_the_name_of_another_call_or_a_key_of_another_tool() -> None:
    assert list(find_tools()) == list(TOOLS)
    assert not set(TOOLS) & set(NOT_TOOLS)
    keys = [tool.control.key for tool in TOOLS.values() if tool.control.key]
    assert len(set(keys)) == len(keys)
    for name, tool in TOOLS.items():
        assert (SNAP in tool.arguments) == (tool.snaps or name == "sizes")
