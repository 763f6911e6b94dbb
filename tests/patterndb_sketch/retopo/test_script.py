"""Scripts: what is read, what is refused, and what playing them gives."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.retopo.editor import Call, Outcome, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import FilledNetwork, weld_patches
from patterndb_sketch.retopo.script import (
    Script,
    ScriptLine,
    line_of,
    play_script,
    read_script,
    script_of,
    surface_path,
    write_script,
)
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, line
from tests.support.retopo.networks import plane, sphere

OPEN = '{"tool": "open", "surface": "a.obj"}'

#: A ball of eight patches, one of them cut in two, with counts, a flow line and a choice.
BALL = [
    '{"tool": "open", "surface": "ball.obj"}',
    '{"tool": "loop", "at": [1, 0.02, 0], "normal": [0, 0, 1]}',
    '{"tool": "loop", "at": [0, 1, 0.02], "normal": [1, 0, 0]}',
    '{"tool": "loop", "at": [0.02, 0, 1], "normal": [0, 1, 0]}',
    "# the first octant",
    '{"tool": "stroke", "points": [[1, 0, 1], [1, 0.5, 0.9], [0, 1, 1]]}',
    "",
    '{"tool": "subdivide", "at": [1, 0, 1], "by": 2}',
    '{"tool": "choose", "at": [-1, -1, -1], "by": 1}',
    '{"tool": "export", "mesh": "half.obj"}',
    '{"tool": "knot", "at": [0, 0, -1]}',
    '{"tool": "undo"}',
    '{"tool": "flow", "points": [[-0.9, -0.1, 0.2], [-0.6, -0.6, 0.3], [-0.1, -0.9, 0.2]]}',
]


def nowhere(name: str, found: FilledNetwork) -> None:
    raise AssertionError(f"export of {name}")


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
PLAIN = st.booleans() | NUMBERS | st.text(max_size=5) | st.lists(NUMBERS, max_size=3)
ARGUMENTS = st.dictionaries(st.text(max_size=5).filter(lambda name: name != "tool"), PLAIN)
CALLS = st.builds(
    Call, st.text(max_size=8).filter(lambda name: name not in ("open", "export")), ARGUMENTS
)


@given(st.lists(CALLS, max_size=4), st.text(max_size=9))
def test_what_is_written_is_read(calls: list[Call], surface: str) -> None:
    lines = [json.dumps({"tool": "open", "surface": surface}), *map(line_of, calls)]
    read = script_of(lines)
    assert read.surface == surface
    assert [one.call for one in read.lines] == calls
    assert [one.number for one in read.lines] == list(range(2, len(calls) + 2))


def test_files_are_read_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    script = script_of(BALL)
    write_script(path, script)
    again = read_script(path)
    assert again.surface == "ball.obj"
    assert [one.call for one in again.lines] == [one.call for one in script.lines]
    path.write_text("\ufeff" + "\r\n".join(BALL), "utf-8")
    assert read_script(path) == script
    assert [one.number for one in script.lines] == [2, 3, 4, 6, 8, 9, 10, 11, 12, 13]


def test_arrays_are_written_as_lists_and_nothing_as_nothing() -> None:
    call = Call("t", {"a": np.array([[0.1, 2.0]]), "b": None, "c": False})
    assert line_of(call) == '{"tool": "t", "a": [[0.1, 2.0]], "c": false}'
    with pytest.raises(ValueError, match="JSON compliant"):
        line_of(Call("t", {"a": float("nan")}))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "the script is empty; begin with"),
        (["# nothing", " "], "the script is empty"),
        (['{"tool": "undo"}'], "line 1: a script begins with its surface"),
        (['{"tool": "open"}'], "line 1: a script begins with its surface"),
        (['{"tool": "open", "surface": 3}'], "line 1: a script begins with its surface"),
        (['{"tool": "open", "surface": "a", "by": 1}'], "line 1: a script begins"),
        (["", OPEN, OPEN], "line 3: a script opens one surface, in its first line"),
        ([OPEN, "undo"], "line 2: line 1, column 1: this is not JSON"),
        ([OPEN, "[1]"], "line 2: a list is not an object such as"),
        ([OPEN, "{}"], 'line 2: "tool" is missing'),
        ([OPEN, '{"tool": 1}'], "line 2: tool: 1 is not the name of a tool"),
        ([OPEN, '{"tool": "undo", "tool": "redo"}'], 'line 2: the entry "tool" is there twice'),
        ([OPEN, '{"tool": "erase", "at": [NaN, 0, 0]}'], "line 2: NaN is no number"),
        ([OPEN, '{"tool": "export"}'], "line 2: export needs mesh, a file"),
        ([OPEN, '{"tool": "export", "mesh": ""}'], "line 2: export needs mesh"),
        ([OPEN, '{"tool": "export", "mesh": "a.obj", "to": 1}'], "line 2: export needs mesh"),
    ],
)
def test_other_scripts_are_refused_with_their_line(lines: list[str], message: str) -> None:
    with pytest.raises(InvalidRetopoError) as caught:
        script_of(lines)
    assert str(caught.value).startswith(message)


def test_files_that_are_no_scripts_are_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_bytes(OPEN.encode() + b"\n\xff")
    with pytest.raises(InvalidRetopoError, match=rf"{path}: byte 37 is not UTF-8"):
        read_script(path)
    path.write_text(OPEN + "\n{")
    with pytest.raises(InvalidRetopoError, match=rf"{path}: line 2: line 1, column 2"):
        read_script(path)


def test_the_surface_is_beside_the_script_or_in_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    monkeypatch.chdir(here)
    script = script_of([OPEN])
    with pytest.raises(InvalidRetopoError, match=r"there is no a.obj, neither beside"):
        surface_path(script, there / "s.jsonl")
    (here / "a.obj").touch()
    assert surface_path(script, there / "s.jsonl").resolve() == here / "a.obj"
    (there / "a.obj").touch()
    assert surface_path(script, there / "s.jsonl") == there / "a.obj"
    assert surface_path(Script(str(here / "a.obj"), ()), there / "s.jsonl") == here / "a.obj"


def test_playing_tells_every_line_and_exports_what_there_is_then(source: PatternSource) -> None:
    editor = Retopology(sphere(), source)
    exported: list[tuple[str, FilledNetwork]] = []
    told = list(
        play_script(script_of(BALL), editor, lambda name, found: exported.append((name, found)))
    )
    assert [one.number for one, _ in told] == [2, 3, 4, 6, 8, 9, 10, 11, 12, 13]
    ((name, found),) = exported
    assert name == "half.obj"
    assert len(found.network.patches) == 9 == len(found.placed)
    assert editor.undoable == 7
    assert len(editor.fill().placed) == 9
    (flowing,) = [p for p in editor.network.patches.values() if p.choice.flows]
    assert flowing.choice.choice is not None
    (by_hand,) = [p for p in found.network.patches.values() if p.choice.choice.by == "user"]
    assert by_hand.id in editor.network.patches


def test_a_refused_call_ends_a_script_unless_it_is_lenient(source: PatternSource) -> None:
    lines = [OPEN, "#", '{"tool": "knot", "at": [3, 3, 0]}', BALL[-2]]
    script = script_of([*lines, line_of(Call("stroke", {"points": line((0, 0), (1, 0))}))])
    with pytest.raises(InvalidRetopoError, match=r"line 3: knot: nothing is within"):
        list(play_script(script, Retopology(plane(), source, SIZES), nowhere))
    editor = Retopology(plane(), source, SIZES)
    told = [outcome for _, outcome in play_script(script, editor, nowhere, lenient=True)]
    assert [outcome.changed for outcome in told] == [False, False, True]
    assert told[1] == Outcome(False, "there is nothing to undo")
    assert editor.undoable == 1


def test_a_call_that_makes_no_sense_ends_even_a_lenient_script(source: PatternSource) -> None:
    script = Script("a.obj", (ScriptLine(7, Call("knot", {"at": [0, 0]})),))
    with pytest.raises(InvalidRetopoError, match=r"line 7: knot: at is \[0, 0\]"):
        list(play_script(script, Retopology(plane(), source, SIZES), nowhere, lenient=True))


PLAYED = """
import hashlib, sys
import trimesh
import patterndb
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import weld_patches
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.script import play_script, read_script
from pathlib import Path

mesh = trimesh.creation.icosphere(subdivisions=4)
with patterndb.open() as source:
    editor = Retopology(Surface.from_arrays(mesh.vertices, mesh.faces).orient(), source)
    list(play_script(read_script(Path(sys.argv[1])), editor, lambda name, found: None))
    made = weld_patches(editor.fill())
print(hashlib.sha256(made.vertices.tobytes() + made.quads.tobytes()).hexdigest())
"""


def test_the_same_script_gives_the_same_mesh_whatever_the_threads(
    source: PatternSource, tmp_path: Path
) -> None:
    path = tmp_path / "ball.jsonl"
    # Without the line to flow along, whose fills take their time.
    path.write_text("\n".join(BALL[:-1]))
    editor = Retopology(sphere(), source)
    list(play_script(read_script(path), editor, lambda name, found: None))
    mesh = weld_patches(editor.fill())
    here = hashlib.sha256(mesh.vertices.tobytes() + mesh.quads.tobytes()).hexdigest()
    threads = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    checkout = Path(__file__).parents[3]
    there = subprocess.run(
        [sys.executable, "-c", PLAYED, str(path)],
        env=os.environ | dict.fromkeys(threads, "1") | {"PYTHONHASHSEED": "7"},
        cwd=checkout,
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    assert there == here
