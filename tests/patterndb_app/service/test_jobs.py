"""Learning over HTTP: the token, accepted fills, jobs, and what a killed process leaves."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import httpx
import pytest

import patterndb
from patterndb_app.client.remote import ServiceError
from patterndb_app.service.context import ServiceSettings
from tests.support.service.servedhere import PATIENCE, TOKEN, ServedHere, served, wait_until
from tests.support.shared import EXAMPLES

SHOWN = {"Authorization": f"Bearer {TOKEN}"}
MESH = (EXAMPLES / "hand.obj").read_bytes()
SMALL = {"basic": 3, "side": 0, "convex": 0, "name": "hand.obj", "licence": "CC0-1.0"}

#: Limits with which a mesh keeps a process busy for longer than a test needs to kill it.
LARGE = {"basic": 8, "side": 16, "convex": 80, "name": "hand.obj"}


def ended(http: httpx.Client, job: str) -> dict[str, Any]:
    """Wait for a job's end; return it."""
    wait_until(lambda: http.get(f"/v1/jobs/{job}").json()["ended"] is not None)
    return http.get(f"/v1/jobs/{job}").json()


def test_nothing_is_changed_without_the_token(writable: ServedHere, starter: ServedHere) -> None:
    before = writable.http.get("/v1/meshes").json()
    for headers in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": f"Basic {TOKEN}"}):
        for method, path in (
            ("POST", "/v1/uses"),
            ("POST", "/v1/meshes"),
            ("GET", "/v1/jobs"),
            ("DELETE", f"/v1/jobs/{'0' * 32}"),
        ):
            refused = writable.http.request(method, path, headers=headers)
            assert refused.status_code == 401 and refused.headers["www-authenticate"]
    assert writable.http.get("/v1/meshes").json() == before
    assert starter.http.post("/v1/uses", headers=SHOWN, json={}).status_code == 403


def test_an_accepted_fill_is_learned_from(writable: ServedHere, db: Path) -> None:
    (fill,) = writable.http.post("/v1/fills", json={"sides": [2, 2, 3, 3], "limit": 1}).json()[
        "fills"
    ]
    used = writable.http.post("/v1/uses", json={"fill": fill, "count": 2}, headers=SHOWN).json()
    assert used == {"pattern": fill["pattern"], "uses": 2}
    with patterndb.connect(writable.url, token=TOKEN) as remote:
        found = remote.best((2, 2, 3, 3))
        assert found is not None and remote.record_use(found) == 3
        with patterndb.open(db) as database:
            assert database.uses() == {found.pattern.id: 3}
            assert database.verify() == []
    wrong = {"fill": {**fill, "pattern": "0" * 16}}
    assert writable.http.post("/v1/uses", json=wrong, headers=SHOWN).status_code == 400
    with patterndb.connect(writable.url) as remote, pytest.raises(ServiceError, match="token"):
        remote.record_use(found)


def test_a_mesh_is_learned_as_a_job_and_asked_at_once(writable: ServedHere, db: Path) -> None:
    begun = writable.http.post("/v1/meshes", content=MESH, params=SMALL, headers=SHOWN)
    assert begun.status_code == 202
    job = begun.json()
    assert begun.headers["location"] == f"/v1/jobs/{job['id']}"
    events = httpx.get(
        f"{writable.url}/v1/jobs/{job['id']}",
        headers={"Accept": "text/event-stream"},
        timeout=PATIENCE,
        trust_env=False,
    ).text
    assert events.rstrip().rpartition("event: ")[2].startswith("done")
    done = ended(writable.http, job["id"])
    assert done["state"] == "done" and done["result"]["outcome"] == "learned"
    meshes = writable.http.get("/v1/meshes").json()["meshes"]
    assert {mesh["mesh"]: mesh["licence"] for mesh in meshes}["hand.obj"] == "CC0-1.0"
    with patterndb.open(db) as database:
        held = sum(database.sides_histogram().values())
    assert writable.http.get("/v1/patterns?limit=1").json()["total"] == held
    again = writable.http.post("/v1/meshes", content=MESH, params=SMALL, headers=SHOWN).json()
    assert ended(writable.http, again["id"])["result"]["outcome"] == "unchanged"
    assert list(db.parent.glob("my.db.jobs/*/*.obj")) == []


def test_a_job_is_cancelled_and_leaves_nothing(writable: ServedHere, db: Path) -> None:
    job = writable.http.post("/v1/meshes", content=MESH, params=LARGE, headers=SHOWN).json()
    wait_until(lambda: writable.http.get(f"/v1/jobs/{job['id']}").json()["state"] == "learning")
    waiting = writable.http.post("/v1/meshes", content=MESH, params=LARGE, headers=SHOWN).json()
    at_once = writable.http.delete(f"/v1/jobs/{waiting['id']}", headers=SHOWN).json()
    assert at_once["state"] == "cancelled"
    assert writable.http.delete(f"/v1/jobs/{job['id']}", headers=SHOWN).status_code == 200
    assert ended(writable.http, job["id"])["state"] == "cancelled"
    assert writable.http.delete(f"/v1/jobs/{job['id']}", headers=SHOWN).status_code == 409
    assert [mesh["mesh"] for mesh in writable.http.get("/v1/meshes").json()["meshes"]] == [
        "jug.obj"
    ]
    with patterndb.open(db) as database:
        assert database.verify() == []


def test_names_that_lead_elsewhere_are_refused(writable: ServedHere) -> None:
    for name in ("../../evil.obj", "/etc/evil.obj", ".hidden.obj", "a\x00b.obj", "a/b.obj"):
        refused = writable.http.post(
            "/v1/meshes", content=MESH, params={"name": name}, headers=SHOWN
        )
        assert refused.status_code == 400, name


def test_a_job_of_a_killed_process_is_begun_again(db: Path, tmp_path: Path) -> None:
    token = tmp_path / "token.txt"
    token.write_text(TOKEN)
    words = [sys.executable, "-m", "patterndb", "serve", "--port", "0", "--db", db]
    process = subprocess.Popen(
        [*map(str, words), "--write-token-file", str(token)], stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stderr is not None
        url = process.stderr.readline().split()[3].rstrip("/")
        with httpx.Client(base_url=url, timeout=PATIENCE, trust_env=False) as http:
            job = http.post("/v1/meshes", content=MESH, params=LARGE, headers=SHOWN).json()
            wait_until(lambda: http.get(f"/v1/jobs/{job['id']}").json()["state"] == "learning")
            time.sleep(0.3)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    with patterndb.open(db) as database:
        assert database.verify() == []
        assert [mesh.name for mesh in database.meshes()] == ["jug.obj"]
    journal = db.parent / "my.db.jobs" / job["id"] / "job.json"
    left = json.loads(journal.read_text())
    assert left["state"] == "learning" and left["beginnings"] == 1
    # So that it ends within a test, it is to learn less when it is begun again.
    journal.write_text(json.dumps({**left, "options": {"basic": 3, "side": 0, "convex": 0}}))
    with served(ServiceSettings(databases=(db,), token=TOKEN, warm=False)) as running:
        done = ended(running.http, job["id"])
        assert (done["state"], done["beginnings"]) == ("done", 2)
    with patterndb.open(db) as database:
        assert sorted(mesh.name for mesh in database.meshes()) == ["hand.obj", "jug.obj"]
        assert database.verify() == []


def test_a_job_that_ends_its_process_each_time_is_given_up(db: Path) -> None:
    folder = db.parent / "my.db.jobs" / ("1" * 32)
    folder.mkdir(parents=True)
    (folder / "hand.obj").write_bytes(MESH)
    left = {"id": "1" * 32, "db": "my", "mesh": "hand.obj", "state": "learning", "beginnings": 3}
    (folder / "job.json").write_text(json.dumps(left))
    broken = db.parent / "my.db.jobs" / ("2" * 32)
    broken.mkdir()
    (broken / "job.json").write_text("{")
    with served(ServiceSettings(databases=(db,), token=TOKEN, warm=False)) as running:
        job = running.http.get(f"/v1/jobs/{'1' * 32}").json()
        assert job["state"] == "failed" and "3 times" in job["error"]
        assert running.http.get(f"/v1/jobs/{'2' * 32}").status_code == 404
