"""Scripts: a session of retopology as JSON lines, one call each.

    {"tool": "open", "surface": "spot.obj"}
    {"tool": "loop", "at": [0, 0.1, 0.3], "normal": [0, 0, 1]}
    {"tool": "stroke", "points": [[0, 0.1, 0.3], [0.1, 0.2, 0.3]]}
    {"tool": "undo"}
    {"tool": "export", "mesh": "quads.obj"}

The first line names the surface, relative to the script or to the working folder; with
"quads": true it is a mesh of quads, which becomes a network of its regular grids. "export"
writes the mesh that there is then. Everything else is a call of a tool
(:mod:`patterndb_sketch.retopo.editor`).
Empty lines, and lines that begin with #, say nothing. Playing a script fills all patches after
every call, so the same script gives the same mesh, bit for bit.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from patterndb.system.documents import parse_json, read_limited
from patterndb.system.files import may_name_file, replace_file
from patterndb_sketch.retopo.editor import Call, Outcome, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import FilledNetwork

#: Bytes that a script may have: strokes of some million points.
MAX_BYTES = 64_000_000

OPEN, EXPORT = "open", "export"


@dataclass(frozen=True, slots=True)
class ScriptLine:
    """number: in the file, from 1 on. call: of a tool, or "export" with its path as "mesh"."""

    number: int
    call: Call


@dataclass(frozen=True, slots=True)
class Script:
    """surface: as the first line names it. lines: all others that say something. quads: begin from
    the surface's own quads."""

    surface: str
    lines: tuple[ScriptLine, ...]
    quads: bool = False


def read_script(path: Path | str) -> Script:
    """The script in a file; raises InvalidRetopoError that names the file and the line."""
    path = Path(path)
    data = read_limited(path, MAX_BYTES, InvalidRetopoError, "split it")
    try:
        return script_of(data.decode("utf-8-sig").splitlines())
    except UnicodeDecodeError as error:
        raise InvalidRetopoError(f"{path}: byte {error.start} is not UTF-8") from None
    except InvalidRetopoError as error:
        raise InvalidRetopoError(f"{path}: {error}") from error


def script_of(lines: Sequence[str]) -> Script:
    """The script of some lines; raises InvalidRetopoError that names the line."""
    found: list[ScriptLine] = []
    surface: str | None = None
    quads = False
    for number, text in enumerate(lines, 1):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        try:
            call = _call(text)
            if surface is None:
                surface, quads = _opened(call)
                continue
            if call.tool == OPEN:
                raise InvalidRetopoError("a script opens one surface, in its first line")
            if call.tool == EXPORT:
                export_path(call)
        except InvalidRetopoError as error:
            raise InvalidRetopoError(f"line {number}: {error}") from error
        found.append(ScriptLine(number, call))
    if surface is None:
        raise InvalidRetopoError('the script is empty; begin with {"tool": "open", "surface": ...}')
    return Script(surface, tuple(found), quads)


def write_script(path: Path | str, script: Script) -> None:
    """Write a script; :func:`read_script` gives it back. OSError as writing does."""
    quads = {"quads": True} if script.quads else {}
    first = json.dumps({"tool": OPEN, "surface": script.surface, **quads})
    lines = [first, *(line_of(line.call) for line in script.lines)]
    replace_file(Path(path), "\n".join(lines) + "\n")


def line_of(call: Call) -> str:
    """A call as a line of a script."""
    return json.dumps({"tool": call.tool, **_plain(call.arguments)}, allow_nan=False)


def export_path(call: Call) -> str:
    """The path of an export call."""
    path = call.arguments.get("mesh")
    if set(call.arguments) - {"mesh"} or not isinstance(path, str) or not path:
        raise InvalidRetopoError('export needs mesh, a file: {"tool": "export", "mesh": "a.obj"}')
    if not may_name_file(path):
        raise InvalidRetopoError(f"export to {path!r}: no file can have that name")
    return path


def locate_export(script: Path, name: str, *, anywhere: bool = False) -> Path:
    """Where an export of a script goes: to its name beside the script, or in a folder below.

    A script may come from somebody else: raises InvalidRetopoError for any other place, also by a
    symbolic link, unless ``anywhere``.
    """
    path = script.parent / name
    folder = Path(os.path.realpath(script.parent))
    if not anywhere and not Path(os.path.realpath(path)).is_relative_to(folder):
        raise InvalidRetopoError(
            f"export to {name}: that is not beside the script, nor in a folder below; change the "
            "script, or, if you trust it, allow it to write anywhere (--exports-anywhere)"
        )
    return path


def surface_path(script: Script, beside: Path) -> Path:
    """The surface's file: beside the script, else in the working folder.

    Raises InvalidRetopoError where it is neither.
    """
    for folder in (beside.parent, Path()):
        found = folder / script.surface
        if found.is_file():
            return found
    raise InvalidRetopoError(
        f"{beside}: there is no {script.surface}, neither beside the script nor in the working "
        "folder; start from the folder that it is relative to"
    )


def play_script(
    script: Script,
    editor: Retopology,
    export: Callable[[str, FilledNetwork], None],
    *,
    lenient: bool = False,
) -> Iterator[tuple[ScriptLine, Outcome]]:
    """Do what a script says, line by line; yields every line with its outcome.

    An outcome's notes have those of the fill after the call, too, as far as they are new.
    export: writes the mesh to a path, as an export line names it. lenient: go on after a call
    that is refused; else InvalidRetopoError, with the line, is raised.
    """
    told: tuple[str, ...] = ()
    for line in script.lines:
        if line.call.tool == EXPORT:
            export(export_path(line.call), editor.fill())
            yield line, Outcome(False)
            continue
        try:
            outcome = editor.do(line.call)
        except InvalidRetopoError as error:
            raise InvalidRetopoError(f"line {line.number}: {error}") from error
        if outcome.refused is not None and not lenient:
            raise InvalidRetopoError(f"line {line.number}: {line.call.tool}: {outcome.refused}")
        if outcome.changed:
            now = editor.fill().notes
            new = tuple(note for note in now if note not in told)
            outcome, told = replace(outcome, notes=(*outcome.notes, *new)), now
        yield line, outcome


def _call(text: str) -> Call:
    document = parse_json(text, InvalidRetopoError, "a call")
    entries = document.entries(None, 'an object such as {"tool": "undo"}')
    if "tool" not in entries:
        document.fail('"tool" is missing: the name of a tool')
    tool = entries["tool"].text("the name of a tool")
    return Call(tool, {name: one.value for name, one in entries.items() if name != "tool"})


def _opened(call: Call) -> tuple[str, bool]:
    """The surface, and is it to begin from its quads?"""
    surface, quads = call.arguments.get("surface"), call.arguments.get("quads", False)
    if (
        call.tool != OPEN
        or set(call.arguments) - {"surface", "quads"}
        or not isinstance(surface, str)
        or not isinstance(quads, bool)
    ):
        raise InvalidRetopoError(
            'a script begins with its surface: {"tool": "open", "surface": "spot.obj"}, with '
            '"quads": true for a mesh of quads to begin from'
        )
    return surface, quads


def _plain(arguments: Mapping[str, object]) -> dict[str, object]:
    """Arguments as JSON has them; those that are None say nothing."""
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in arguments.items()
        if value is not None
    }
