"""Where retopology begins: a surface, a mesh of quads, a script's surface, or a session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from patterndb.store import Database
    from patterndb_sketch.retopo.editor import Editor
    from patterndb_sketch.retopo.ground import Ground
    from patterndb_sketch.retopo.script import Script
    from patterndb_sketch.retopo.sessionfile import RetopoSession


@dataclass(frozen=True, slots=True)
class Asked:
    """What the command line says of the beginning."""

    surface: Path | None
    script: Path | None
    session: Path | None
    quads: bool

    @property
    def goes_on(self) -> bool:
        """Is there a session to go on from?"""
        return self.session is not None and self.session.exists()

    def check(self) -> None:
        """UsageError for what does not go together, or is nothing to begin from."""
        if self.goes_on and self.surface is not None:
            raise click.UsageError(
                f"{self.session} has its surface in it; leave SURFACE out, or begin another session"
            )
        if self.goes_on and self.quads:
            raise click.UsageError(f"{self.session} has begun already; leave --quads out")
        if self.surface is None and self.script is None and not self.goes_on:
            there = "no session is given" if self.session is None else f"there is no {self.session}"
            raise click.UsageError(f"nothing to draw on: give a SURFACE or a --script; {there}")


@dataclass(frozen=True, slots=True)
class Begun:
    """surface: what it is called, in reports and scripts. quads: was it begun from quads?"""

    surface: str
    ground: Ground
    editor: Editor
    quads: bool


def begun(asked: Asked, script: Script | None, database: Database) -> Begun:
    """An editor as it is before anything is done."""
    from patterndb_sketch.retopo.editor import Editor
    from patterndb_sketch.retopo.sessionfile import read_session

    if asked.session is not None and asked.goes_on:
        kept = read_session(asked.session)
        if script is not None and asked.script is not None:
            _refuse_another(kept, script, asked.script)
        editor = Editor(kept.ground, database)
        editor.restore(kept.state)
        return Begun(kept.name, kept.ground, editor, False)
    path = _path(asked, script)
    quads = asked.quads or (script is not None and script.quads)
    editor = _from_quads(path, database) if quads else Editor(_ground(path), database)
    return Begun(str(path), editor.ground, editor, quads)


def _path(asked: Asked, script: Script | None) -> Path:
    from patterndb_sketch.retopo.script import surface_path

    if asked.surface is not None:
        return asked.surface
    assert script is not None
    assert asked.script is not None
    return surface_path(script, asked.script)


def _ground(path: Path) -> Ground:
    from ingest.formats import read_mesh
    from patterndb_sketch.retopo.ground import Ground

    return Ground.of_polygons(read_mesh(path))


def _from_quads(path: Path, database: Database) -> Editor:
    from ingest.formats import read_mesh
    from patterndb_sketch.retopo.editor import Editor
    from patterndb_sketch.retopo.errors import InvalidRetopoError
    from patterndb_sketch.retopo.quadimport import import_quads

    mesh = read_mesh(path)
    quads, _ = mesh.quads()
    others = mesh.n_faces - len(quads)
    if others:
        raise InvalidRetopoError(
            f"{path}: {others} of {mesh.n_faces} faces are not quads; begin from a mesh of quads "
            "alone, or leave --quads out and draw on it"
        )
    try:
        return Editor.of_quads(import_quads(mesh.points, quads), database)
    except InvalidRetopoError as error:
        raise InvalidRetopoError(f"{path}: {error}") from error


def _refuse_another(kept: RetopoSession, script: Script, beside: Path) -> None:
    """InvalidRetopoError if a script names another surface than the session has, where it is
    there to be looked at."""
    import numpy as np

    from patterndb_sketch.retopo.errors import InvalidRetopoError
    from patterndb_sketch.retopo.script import surface_path

    path = surface_path(script, beside)
    ground = _ground(path)
    same = np.array_equal(ground.vertices, kept.ground.vertices)
    if not (same and np.array_equal(ground.triangles, kept.ground.triangles)):
        raise InvalidRetopoError(
            f"{beside}: its surface, {path}, is not the session's, {kept.name or 'unnamed'}; "
            "name the surface that the session was begun on, or another session"
        )
