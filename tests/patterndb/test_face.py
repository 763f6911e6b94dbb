"""The face: all that a script needs, by one import that costs next to nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import patterndb
from tests.support.shared import CHECKOUT


def test_every_name_is_there_and_no_other() -> None:
    for name in patterndb.__all__:
        assert getattr(patterndb, name) is not None
    assert patterndb.__all__ == sorted(patterndb.__all__)
    assert set(patterndb.__all__) <= set(dir(patterndb))
    assert not hasattr(patterndb, "no_such_name")


def test_what_a_type_checker_sees_is_what_there_is() -> None:
    tree = ast.parse(Path(patterndb.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    named = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    for name in set(patterndb.__all__) - {"open", "read", "PatternDBError"}:
        module = sys.modules[str(named[name])] if getattr(patterndb, name) else None
        assert getattr(module, name) is getattr(patterndb, name)


def test_importing_it_loads_nothing_heavy() -> None:
    script = "import sys, patterndb; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=CHECKOUT
    )
    heavy = {"numpy", "scipy", "sqlite3", "query", "ingest", "viewer", "json", "msgspec"}
    assert not heavy & set(done.stdout.split())


def test_a_script_from_mesh_to_fill_needs_the_face_alone(tmp_path: Path) -> None:
    mesh = tmp_path / "grid.obj"
    points = [(x, y, 0) for y in range(5) for x in range(5)]
    faces = [(i, i + 1, i + 6, i + 5) for i in range(20) if i % 5 < 4]
    patterndb.PolygonMesh.from_faces(points, faces).write(mesh)
    with patterndb.open(tmp_path / "my.db", "create") as db:
        report = db.ingest([mesh])
        assert report.meshes[0].quads_read == 16
        assert repr(db) == f"<Database {tmp_path / 'my.db'}: 1 pattern of 1 mesh, open to create>"
        boundary = patterndb.Boundary((2, 3, 2, 3))
        listed = list(db.fills(boundary, origins=("learned",), limit=1))
    assert [len(fill.quads) for fill in listed] == [6]
    assert repr(db) == f"<Database {tmp_path / 'my.db'}: closed or damaged>"
    flat = np.array([(x, 0.0) for x in (0, 1, 2)] + [(2, y) for y in (1, 2, 3)])
    flat = np.vstack([flat, [(1, 3), (0, 3), (0, 2), (0, 1)]])
    placed = listed[0].place(np.column_stack([flat, np.zeros(10)]))
    assert placed.vertices.shape == (12, 3)


@pytest.mark.parametrize(
    ("lengths", "corners", "text"),
    [
        ((3, 5, 4, 6), None, "<Boundary of sides 3, 5, 4, 6: 18 edges>"),
        ((12,), (), "<Boundary of one closed side of 12: 12 edges>"),
        (
            (6, 2, 4, 4, 2, 4),
            ("convex", "convex", "convex", "reflex", "convex", "convex"),
            "<Boundary of sides 6, 2, 4, 4, 2, 4: 22 edges, reflex at 3>",
        ),
    ],
)
def test_boundaries_say_what_they_are(
    lengths: tuple[int, ...], corners: tuple[str, ...] | None, text: str
) -> None:
    assert repr(patterndb.Boundary(lengths, corners)) == text  # type: ignore[arg-type]
