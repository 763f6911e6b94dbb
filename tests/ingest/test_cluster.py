"""Learning on a cluster: what is learned is the same, also where workers or the scheduler die."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ingest import MeshReport, Progress, cluster, clustertasks, engines, ingest, read_mesh
from ingest.clustertasks import MeshParcel, finish_mesh, from_columns, learn_part, to_columns
from ingest.learning import MeshLearning, Tally, merge_tallies
from patterndb.errors import ClusterError
from patterndb.store import Database, Learned, LearningOptions
from tests.support.meshes import CUP, examples, grid, star, write_obj

distributed: Any = pytest.importorskip("distributed")

OPTIONS = LearningOptions(4, 8, 12)
#: As OPTIONS, but most meshes have more patterns.
FEW = LearningOptions(4, 8, 12, most_patterns=9)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler and two worker processes, each with a nanny that starts it again."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0"
    ) as local:
        yield local.scheduler_address


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    """Meshes of some parts, and of one."""
    shapes = {"cup": CUP, "star": star(5, 4), "grid": grid(9, 9), "stars": star(7, 5)}
    return [
        *(write_obj(tmp_path / f"{name}.obj", quads) for name, quads in shapes.items()),
        *examples()[:2],
    ]


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of some quads: a mesh has dozens, so that they are merged in groups."""
    monkeypatch.setattr(engines, "SHARD_QUADS", 40)
    monkeypatch.setattr(engines, "SMALLEST_SHARD", 20)


@pytest.fixture
def expected(tmp_path: Path, files: list[Path]) -> str:
    """The content hash of what threads learn."""
    with Database(tmp_path / "threads.db", "create") as db:
        ingest(db, files, OPTIONS, jobs=2)
        return db.content_hash()


def test_a_cluster_learns_what_threads_learn(
    tmp_path: Path, files: list[Path], expected: str, address: str, small_parts: None
) -> None:
    seen: list[Progress] = []
    workers: set[int | None] = set()

    def watch(state: Progress) -> None:
        workers.add(state.workers)
        seen.append(state)

    with Database(tmp_path / "cluster.db", "create") as db:
        first = ingest(db, files, OPTIONS, scheduler=address, progress=watch)
        assert db.content_hash() == expected
        assert db.verify() == []
        assert [mesh.path for mesh in first.meshes] == files
        assert {mesh.outcome for mesh in first.meshes} == {"learned"}
        # Again, nothing is to be done.
        again = ingest(db, files, OPTIONS, scheduler=address)
        assert {mesh.outcome for mesh in again.meshes} == {"unchanged"}
        assert db.content_hash() == expected
    assert workers == {2}
    assert seen[-1].bytes_done == seen[-1].bytes_total
    assert seen[-1].patches > 0


def test_a_limit_of_patterns_is_the_same_on_a_cluster(
    tmp_path: Path, files: list[Path], address: str, small_parts: None
) -> None:
    with (
        Database(tmp_path / "threads.db", "create") as threads,
        Database(tmp_path / "cluster.db", "create") as cluster,
    ):
        here = ingest(threads, files, FEW, jobs=2)
        there = ingest(cluster, files, FEW, scheduler=address)
        assert cluster.content_hash() == threads.content_hash()
        assert [m.left_out for m in here.meshes] == [m.left_out for m in there.meshes]
        assert any(mesh.left_out for mesh in there.meshes)


def test_processes_of_this_machine_learn_what_threads_learn(
    tmp_path: Path, files: list[Path], expected: str
) -> None:
    with Database(tmp_path / "local.db", "create") as db:
        ingest(db, files, OPTIONS, scheduler="local:1")
        assert db.content_hash() == expected


def test_a_worker_that_is_killed_is_made_good(
    tmp_path: Path, files: list[Path], expected: str, address: str, small_parts: None
) -> None:
    with distributed.Client(address, set_as_default=False) as client:
        before = set(client.run(os.getpid).values())
    killed: list[int] = []

    def kill(mesh: MeshReport) -> None:
        if not killed:
            killed.append(min(before))
            os.kill(killed[0], signal.SIGKILL)

    with Database(tmp_path / "cluster.db", "create") as db:
        ingest(db, files, OPTIONS, scheduler=address, report=kill)
        assert db.content_hash() == expected
        assert db.verify() == []
    assert killed


def start(*arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def test_what_was_written_stays_where_the_scheduler_is_lost(
    tmp_path: Path, files: list[Path], expected: str, small_parts: None
) -> None:
    where = tmp_path / "scheduler.json"
    told = ("--scheduler-file", str(where))
    scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *told)
    worker = start(
        "worker", "--no-nanny", "--nworkers", "1", "--nthreads", "1", "--no-dashboard", *told
    )
    try:
        for _ in range(600):
            if where.exists() and where.stat().st_size:
                break
            time.sleep(0.05)
        tcp = json.loads(where.read_text())["address"]
        written: list[str] = []

        def lose(mesh: MeshReport) -> None:
            written.append(mesh.name)
            if len(written) == 2:
                scheduler.kill()
                scheduler.wait()

        with Database(tmp_path / "cluster.db", "create") as db:
            with pytest.raises(ClusterError, match=r"lost.*is kept.*goes on from there"):
                ingest(db, files, OPTIONS, scheduler=tcp, report=lose)
            kept = {mesh.name for mesh in db.meshes()}
            assert set(written) == kept
            assert 2 <= len(kept) < len(files)
            assert db.verify() == []
            rest = ingest(db, files, OPTIONS, jobs=2)
            assert sum(mesh.outcome == "unchanged" for mesh in rest.meshes) == len(kept)
            assert db.content_hash() == expected
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()


def test_workers_with_other_versions_are_refused(
    tmp_path: Path, files: list[Path], address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = clustertasks.list_versions()
    monkeypatch.setattr(clustertasks.np, "__version__", "0.1")
    with Database(tmp_path / "cluster.db", "create") as db:
        with pytest.raises(ClusterError) as refused:
            ingest(db, files, OPTIONS, scheduler=address)
        assert f"numpy is {mine['numpy']} there and 0.1 here" in str(refused.value)
        assert "python" not in str(refused.value)
        assert db.meshes() == []


def test_a_worker_that_comes_later_with_other_versions_is_refused() -> None:
    quads = np.array(grid(2, 2), np.int32)
    parcel = MeshParcel.wrap(quads, np.arange(4), OPTIONS, 4096)
    other = parcel._replace(versions={**parcel.versions, "python": "2.7"})
    with pytest.raises(ClusterError, match=r"python is .* there|python is .* and 2\.7"):
        learn_part(other, 0, 1)


def test_a_scheduler_that_does_not_answer(
    tmp_path: Path, files: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    with Database(tmp_path / "cluster.db", "create") as db:
        with pytest.raises(ClusterError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1"):
            ingest(db, files, OPTIONS, scheduler="tcp://127.0.0.1:9")
        with (
            distributed.LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as empty,
            pytest.raises(ClusterError, match="has no worker; start some"),
        ):
            ingest(db, files, OPTIONS, scheduler=empty.scheduler_address)


@pytest.mark.parametrize("text", ["", "local:0", "local:", "tcp://host", "host:8786", "local:-1"])
def test_what_is_no_scheduler_is_refused(tmp_path: Path, files: list[Path], text: str) -> None:
    with (
        Database(tmp_path / "cluster.db", "create") as db,
        pytest.raises(ValueError, match="is no scheduler"),
    ):
        ingest(db, files, OPTIONS, scheduler=text)


def test_jobs_are_not_those_of_workers(tmp_path: Path, files: list[Path]) -> None:
    with (
        Database(tmp_path / "cluster.db", "create") as db,
        pytest.raises(ValueError, match="jobs is about threads"),
    ):
        ingest(db, files, OPTIONS, scheduler="local:1", jobs=2)


def assert_equal_records(one: Tally | Learned, other: Tally | Learned) -> None:
    assert type(one) is type(other)
    for field in fields(one):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype, field.name
            assert np.array_equal(mine, theirs), field.name
        else:
            assert mine == theirs, field.name


def sorted_patterns(learned: Learned) -> list[Any]:
    return sorted(
        zip(
            learned.codes,
            learned.sides.tolist(),
            learned.patches.tolist(),
            learned.examples,
            strict=True,
        )
    )


def test_tallies_may_be_merged_in_any_groups() -> None:
    quads, faces = read_mesh(examples()[0]).quads()
    learning = MeshLearning(quads, faces, OPTIONS, shard_quads=60, pulse=np.zeros(2, np.int64))
    tallies = [task() for task in learning.tasks]
    assert len(tallies) >= 4
    assert any(len(t.far_row) for t in tallies)
    whole = learning.finish(tallies)
    chance = np.random.default_rng(3)
    for _ in range(6):
        order = chance.permutation(len(tallies))
        cuts = np.sort(chance.integers(0, len(tallies), 3))
        groups = [[tallies[i] for i in part] for part in np.split(order, cuts)]
        merged = learning.finish([merge_tallies(group) for group in groups])
        assert sorted_patterns(merged) == sorted_patterns(whole)
        for name in ("quads_read", "quads_used", "basic", "side", "convex", "distinct"):
            assert getattr(merged, name) == getattr(whole, name)


def test_columns_are_the_record() -> None:
    quads, faces = read_mesh(examples()[1]).quads()
    parcel = MeshParcel.wrap(quads, faces[::-1].copy(), OPTIONS, 100)
    parts = [learn_part(parcel, k, 3) for k in range(3)]
    for part in parts:
        record = from_columns(Tally, part)
        assert_equal_records(from_columns(Tally, to_columns(record)), record)
    columns = finish_mesh(parcel, parts)
    assert all(isinstance(v, np.ndarray | int | str) for v in columns.values())
    found = from_columns(Learned, columns)
    plain = MeshLearning(
        quads, faces[::-1].copy(), OPTIONS, shard_quads=1 << 30, pulse=np.zeros(2, np.int64)
    )
    expected = plain.finish([task() for task in plain.tasks])
    assert sorted_patterns(found) == sorted_patterns(expected)
    assert found.distinct == expected.distinct
