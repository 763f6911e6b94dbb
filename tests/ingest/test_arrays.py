"""Meshes given as arrays: the same as through a file, known again, and refused where wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from ingest import ingest, learn_mesh, read_mesh
from ingest.arrays import MAGIC, canonical_bytes, mesh_of_arrays
from patterndb.errors import DatabaseError, InvalidMeshError
from patterndb.store import Database, LearningOptions, Provenance
from tests.support.meshes import CUP, quad_soups, star, write_obj

OPTIONS = LearningOptions(4, 6, 10)
OCCURRENCES = (
    "SELECT pattern_id, patches, mirrored_patches, example FROM occurrence ORDER BY pattern_id"
)


def learned(db: Database) -> list[tuple[object, ...]]:
    return db._connection.execute(OCCURRENCES).fetchall()


@settings(max_examples=20)
@given(quads=quad_soups(most=20))
def test_it_teaches_what_the_file_does(
    quads: list[list[int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("arrays")
    # A triangle in between: examples count it as the file does.
    faces = [quads[0], [0, 1, 2], *quads[1:]]
    with Database(folder / "file.db", "create") as a, Database(folder / "arrays.db", "create") as b:
        file = ingest(a, [write_obj(folder / "m.obj", faces)], OPTIONS, jobs=1).meshes[0]
        mesh = learn_mesh(b, faces, name="m.obj", options=OPTIONS, jobs=1)
        assert learned(a) == learned(b)
        assert (mesh.quads_read, mesh.quads_used) == (file.quads_read, file.quads_used)
        assert (mesh.distinct, mesh.patterns) == (file.distinct, file.patterns)
        assert b.verify() == []


def test_it_is_known_again(tmp_path: Path) -> None:
    quads = np.array(star(5, 2))
    with Database(tmp_path / "a.db", "create") as db:
        first = learn_mesh(db, quads, name="one", options=OPTIONS)
        assert (first.outcome, first.path, first.name) == ("learned", None, "one")
        before = db.content_hash()
        # Vertices by other names, other types: the same mesh.
        for same in (quads * 3 + 7, quads.astype(np.uint8), quads.tolist(), mesh_of_arrays(quads)):
            again = learn_mesh(db, same, name="other", options=OPTIONS)
            assert (again.outcome, again.name, again.sha256) == ("unchanged", "one", first.sha256)
        assert db.content_hash() == before
        said = Provenance("me", None, "CC0-1.0")
        told = learn_mesh(db, quads, name="one", options=OPTIONS, provenance=said)
        assert told.outcome == "updated"
        other = learn_mesh(db, quads, name="one", options=LearningOptions(3, 0, 0))
        assert other.outcome == "replaced"
        assert db.meshes()[0].provenance == said
        # One more quad is another mesh, and so are the quads in another order.
        assert learn_mesh(db, quads[::-1], name="two", options=OPTIONS).outcome == "learned"
        assert len(db.meshes()) == 2
        assert db.verify() == []


def test_the_canonical_bytes() -> None:
    mesh = mesh_of_arrays([[9, 4, 7, 2], [4, 9, 3]])
    numbers = [2, 4, 3, 0, 1, 2, 3, 1, 0, 4]
    assert canonical_bytes(mesh) == MAGIC + b"".join(n.to_bytes(4, "little") for n in numbers)


def test_no_quads_teach_nothing(tmp_path: Path) -> None:
    with Database(tmp_path / "a.db", "create") as db:
        for name, faces in (("none", np.zeros((0, 4), int)), ("tri", [[0, 1, 2]])):
            report = learn_mesh(db, faces, name=name, options=OPTIONS)
            assert (report.quads_read, report.patterns) == (0, 0)
        assert db.verify() == []


@pytest.mark.parametrize(
    "faces",
    [
        [[0, 1, 2, -1]],
        np.array([[0, 1, 2, 2**31]]),
        np.array([[0.0, 1, 2, 3]]),
        np.zeros((2, 2, 4), int),
        np.zeros(4, int),
        [0, 1, 2, 3],
        [["a", "b", "c", "d"]],
        7,
    ],
)
def test_what_are_no_faces(faces, tmp_path: Path) -> None:
    with Database(tmp_path / "a.db", "create") as db:
        with pytest.raises(InvalidMeshError):
            learn_mesh(db, faces, name="bad", options=OPTIONS)
        assert db.meshes() == []


def test_names_and_databases_that_do_not_do(tmp_path: Path) -> None:
    with Database(tmp_path / "a.db", "create") as db:
        for name in ("", "  ", "\udcff"):
            with pytest.raises(InvalidMeshError, match="name"):
                learn_mesh(db, CUP, name=name, options=OPTIONS)
    with Database(tmp_path / "a.db") as db, pytest.raises(DatabaseError, match="reading only"):
        learn_mesh(db, CUP, name="cup", options=OPTIONS)


def test_an_interrupt_leaves_the_database_as_it_was(tmp_path: Path) -> None:
    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    with Database(tmp_path / "a.db", "create") as db:
        before = db.content_hash()
        quads = read_mesh(Path(__file__).parents[2] / "examples" / "jug.obj").quads()[0]
        with pytest.raises(KeyboardInterrupt):
            learn_mesh(db, quads, name="jug", options=OPTIONS, progress=interrupt)
        assert db.content_hash() == before or len(db.meshes()) == 1
