"""What ingest() does with files; the counts themselves are held elsewhere."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ingest import (
    MeshReport,
    Progress,
    check_files,
    engines,
    ingest,
    learn,
    learn_mesh,
    learning,
    pipeline,
    read_mesh,
)
from patterndb.core.packing import unpack
from patterndb.errors import DatabaseError, InvalidMeshError, MeshFileError
from patterndb.store import Database, LearningOptions, Provenance
from tests.support.meshes import CUP, DOUBLET, ONE, SHAPES, examples, grid, star, write_obj

SMALL = LearningOptions(3, 6, 8)


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    """Five small meshes, of different sizes."""
    shapes = {"cup": CUP, "star": star(5, 2), "grid": grid(4, 5), "one": ONE, "pair": DOUBLET}
    return [write_obj(tmp_path / f"{name}.obj", quads) for name, quads in shapes.items()]


@pytest.fixture
def db(tmp_path: Path) -> Database:
    return Database(tmp_path / "patterns.db", "create")


@pytest.mark.parametrize("jobs", [1, 2, 5])
@pytest.mark.parametrize("shard_quads", [40, 1 << 20])
def test_jobs_and_shards_do_not_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: int, shard_quads: int
) -> None:
    options = LearningOptions(4, 9, 14)
    with Database(tmp_path / "plain.db", "create") as plain:
        ingest(plain, examples(), options, jobs=1)
        expected = plain.content_hash()
    monkeypatch.setattr(engines, "SMALLEST_SHARD", shard_quads)
    monkeypatch.setattr(engines, "SHARD_QUADS", shard_quads)
    monkeypatch.setattr(learning, "BASIC_RANGE", shard_quads)
    with Database(tmp_path / "cut.db", "create") as cut:
        ingest(cut, examples(), options, jobs=jobs)
        assert cut.content_hash() == expected
        assert cut.verify() == []


def test_a_report_for_every_file_in_the_order_given(db: Database, files: list[Path]) -> None:
    seen: list[MeshReport] = []
    report = ingest(db, files, SMALL, report=seen.append)
    assert [m.path for m in report.meshes] == files
    assert sorted(m.name for m in seen) == sorted(f.name for f in files)
    assert not report.interrupted
    for mesh in report.meshes:
        learned = learn(read_mesh(mesh.path).quads()[0], SMALL)
        assert mesh.sha256 == hashlib.sha256(mesh.path.read_bytes()).hexdigest()
        assert mesh.outcome == "learned"
        assert [mesh.quads_read, mesh.quads_used, mesh.basic, mesh.side, mesh.convex] == [
            learned.quads_read,
            learned.quads_used,
            learned.basic,
            learned.side,
            learned.convex,
        ]
        assert (mesh.distinct, mesh.patterns) == (learned.distinct, len(learned.codes))
    assert sum(m.new_patterns for m in report.meshes) == db.statistics().patterns


def test_progress_ends_where_all_is_done(db: Database, files: list[Path]) -> None:
    steps: list[tuple[float, int, tuple[str, ...]]] = []

    def note(p: Progress) -> None:
        assert p.bytes_total == sum(f.stat().st_size for f in files)
        steps.append((p.bytes_done, p.patches, tuple(p.working)))

    report = ingest(db, files, SMALL, progress=note)
    assert steps[-1] == (
        sum(f.stat().st_size for f in files),
        sum(m.basic + m.side + m.convex for m in report.meshes),
        (),
    )
    assert [s[1] for s in steps] == sorted(s[1] for s in steps)


def test_the_same_bytes_under_two_names_are_one_mesh(db: Database, tmp_path: Path) -> None:
    a, b = write_obj(tmp_path / "a.obj", CUP), write_obj(tmp_path / "b.obj", CUP)
    report = ingest(db, [a, b, a], SMALL)
    assert [m.outcome for m in report.meshes] == ["learned", "unchanged", "unchanged"]
    assert [m.name for m in report.meshes] == ["a.obj"] * 3
    assert [m.name for m in db.meshes()] == ["a.obj"]
    assert db.statistics().patches == report.meshes[0].distinct


def test_provenance_is_asked_of_each_file_and_completed(db: Database, files: list[Path]) -> None:
    ingest(db, files, SMALL, provenance=lambda p: Provenance(author=p.stem))
    assert {m.name: m.provenance for m in db.meshes()} == {
        f.name: Provenance(author=f.stem) for f in files
    }
    again = ingest(db, files[:2], SMALL, provenance=Provenance(licence="CC0-1.0"))
    assert [m.outcome for m in again.meshes] == ["updated", "updated"]
    told = {m.name: m.provenance for m in db.meshes()}
    assert told["cup.obj"] == Provenance("cup", None, "CC0-1.0")
    assert told["one.obj"] == Provenance("one", None, None)
    third = ingest(db, files[:2], SMALL, provenance=Provenance(licence="CC0-1.0"))
    assert [m.outcome for m in third.meshes] == ["unchanged", "unchanged"]


def test_options_are_asked_of_each_file(db: Database, files: list[Path]) -> None:
    chosen = {path: LearningOptions(k + 1, 0, 3 * k) for k, path in enumerate(files)}
    ingest(db, files, chosen.__getitem__)
    assert {m.name: m.options for m in db.meshes()} == {p.name: o for p, o in chosen.items()}
    for path, options in chosen.items():
        (mesh,) = (m for m in db.meshes() if m.name == path.name)
        learned = learn(read_mesh(path).quads()[0], options)
        assert (mesh.patterns, mesh.distinct) == (len(learned.codes), learned.distinct)
    # One that is learned with its own options is left as it is; another is replaced.
    chosen[files[0]] = SMALL
    outcomes = [m.outcome for m in ingest(db, files, chosen.__getitem__).meshes]
    assert outcomes == ["replaced", *["unchanged"] * (len(files) - 1)]
    assert check_files(db, files, chosen.__getitem__) == len(files)
    assert db.verify() == []


def test_other_options_keep_what_is_known_of_a_mesh(db: Database, files: list[Path]) -> None:
    ingest(db, files[:1], LearningOptions(2, 0, 0), provenance=Provenance("A", "here", "CC0-1.0"))
    ingest(db, files[:1], LearningOptions(3, 0, 0), provenance=Provenance(author="B"))
    (mesh,) = db.meshes()
    assert mesh.options == LearningOptions(3, 0, 0)
    assert mesh.provenance == Provenance("B", "here", "CC0-1.0")


def test_one_bad_file_and_nothing_is_ingested(db: Database, files: list[Path]) -> None:
    before = db.content_hash()
    bad = files[0].with_name("bad.obj")
    bad.write_text("v 0 0 0\nf 1 2 3 4\n")
    with pytest.raises(MeshFileError, match=r"bad\.obj"):
        ingest(db, [*files, bad], SMALL)
    worse = files[0].with_name("worse.obj")
    with pytest.raises(InvalidMeshError, match=r"(?s)2 of 7.*bad\.obj.*worse\.obj"):
        ingest(db, [*files, bad, worse], SMALL)
    assert db.content_hash() == before
    assert db.meshes() == []


def test_a_file_that_changes_while_it_waits_is_refused(
    db: Database, files: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    load, calls = pipeline.load_file, 0

    def load_and_change(path: Path, limits: object) -> bytes:
        nonlocal calls
        calls += 1
        data = load(path, limits)  # type: ignore[arg-type]
        return data if calls == 1 else data + b"# changed\n"

    monkeypatch.setattr(pipeline, "load_file", load_and_change)
    with pytest.raises(InvalidMeshError, match="changed while"):
        ingest(db, files[:1], SMALL)
    assert db.meshes() == []


def test_a_mesh_without_quads_leaves_nothing(db: Database, tmp_path: Path) -> None:
    path = tmp_path / "triangle.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    cup = write_obj(tmp_path / "cup.obj", CUP)
    triangle, other = ingest(db, [path, cup], SMALL).meshes
    assert (triangle.quads_read, triangle.distinct, triangle.patterns) == (0, 0, 0)
    assert (triangle.outcome, other.outcome) == ("no quads", "learned")
    assert learn_mesh(db, [[0, 1, 2]], name="triangle").outcome == "no quads"
    assert [mesh.name for mesh in db.meshes()] == ["cup.obj"]
    assert db.verify() == []


def test_bad_files_are_skipped_where_that_is_asked(db: Database, tmp_path: Path) -> None:
    cup = write_obj(tmp_path / "cup.obj", CUP)
    bad = [tmp_path / "cut.obj", tmp_path / "b.ply"]
    bad[0].write_text("v 0 0 0\nf 1 2 3 4\n")
    bad[1].write_bytes(b"no mesh")
    with pytest.raises(InvalidMeshError, match="2 of 3 files cannot be read"):
        ingest(db, [bad[0], cup, bad[1]], SMALL)
    assert db.meshes() == []
    report = ingest(db, [bad[0], cup, bad[1]], SMALL, skip_bad=True)
    assert [mesh.path for mesh in report.meshes] == [cup]
    assert [error.path for error in report.skipped] == bad
    assert [mesh.name for mesh in db.meshes()] == ["cup.obj"]
    with pytest.raises(InvalidMeshError, match="2 of 2 files cannot be read"):
        ingest(db, bad, SMALL, skip_bad=True)


def test_examples_are_quads_as_the_file_numbers_its_faces(db: Database, tmp_path: Path) -> None:
    """Behind a triangle, and in a file whose other faces are quads elsewhere."""
    path = write_obj(tmp_path / "cup.obj", CUP)
    path.write_text(path.read_text().replace("f ", "f 1 2 3\nf ", 1))
    ingest(db, [path], LearningOptions(5, 0, 0, prepare=False))
    cup = next(p for p in (db.pattern_class(0).pattern(i) for i in range(1)))
    (occurrence,) = db.occurrences(cup)
    assert occurrence.example == (1, 2, 3, 4, 5)
    assert (occurrence.patches, occurrence.mirrored_patches) == (1, 0)


def test_a_database_open_for_reading_is_not_ingested_into(db: Database, files: list[Path]) -> None:
    with Database(db.path) as reader, pytest.raises(DatabaseError, match="reading only"):
        ingest(reader, files, SMALL)


def test_no_files_change_nothing(db: Database) -> None:
    report = ingest(db, [], SMALL)
    assert (report.meshes, report.interrupted) == ([], False)


def test_learning_that_was_broken_off_leaves_nothing_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What a thread remembers of codes survives an interrupt after the kernel has run."""
    quads = np.array(SHAPES["refined cube"], np.int32)
    expected = learn(quads, SMALL)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(learning.MeshLearning, "_tally", interrupted)
        with pytest.raises(KeyboardInterrupt):
            learn(np.array(star(7, 3), np.int32), SMALL)
    again = learn(quads, SMALL)
    assert again.distinct == expected.distinct
    assert dict(zip(again.codes, again.patches.tolist(), strict=True)) == dict(
        zip(expected.codes, expected.patches.tolist(), strict=True)
    )
    assert all(len(unpack(code)) % 4 == 0 for code in again.codes)


def test_default_options_are_those_of_the_paper(db: Database, files: list[Path]) -> None:
    ingest(db, files[:1])
    assert db.meshes()[0].options == LearningOptions() == LearningOptions(7, 12, 40, True)
    assert replace(LearningOptions(), basic=0).basic == 0
