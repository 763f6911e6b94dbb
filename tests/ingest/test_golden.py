"""The counts on which two independent programs agree, through the whole pipeline."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from ingest import ingest
from patterndb.store import Database, LearningOptions
from tests.support.meshes import examples, models
from tests.support.shared import DATA, GOLDEN, MESHES, list_shared

#: Figures of the meshes that are here, and of larger ones by artists where these are.
FIGURES = [DATA / "learning.jsonl", *list_shared(GOLDEN, "learning.jsonl")]

ROWS: list[dict[str, Any]] = [
    json.loads(line) for path in FIGURES for line in path.read_text().splitlines()
]


def options_of(row: dict[str, Any]) -> LearningOptions:
    words = row["options"].split()
    limits = {words[i][2:]: int(words[i + 1]) for i in (0, 2, 4)}
    return LearningOptions(**limits, prepare="--prepare" in words)


def test_all_rows_are_there() -> None:
    meshes = Counter(row["mesh"] for row in ROWS)
    assert all(meshes[path.name] == 2 for path in [*examples(), *models()])
    assert {row["options"].split()[-1] == "--prepare" for row in ROWS} == {True, False}


def find_mesh(name: str) -> Path:
    """Return the file of that name among examples, models and the artists' meshes."""
    return next(path for path in [*examples(), *models(), MESHES / name] if path.name == name)


@pytest.mark.parametrize("row", ROWS, ids=lambda r: f"{r['mesh']} {r['options']}")
def test_counts_of_a_mesh(row: dict[str, Any], tmp_path: Path) -> None:
    options = options_of(row)
    with Database(tmp_path / "one.db", "create") as db:
        report = ingest(db, [find_mesh(row["mesh"])], options).meshes[0]
        (mesh,) = db.meshes()
        statistics = db.statistics()
        assert db.verify() == []
    counts = {
        "quads_read": row["quads_read"],
        "quads_used": row["quads_used"],
        "basic": row["basic"],
        "side": row["side"],
        "convex": row["convex"],
        "distinct": row["patches"],
        "patterns": row["patterns"],
    }
    assert {name: getattr(report, name) for name in counts} == counts
    assert {name: getattr(mesh, name) for name in counts} == counts
    assert (report.outcome, report.new_patterns) == ("learned", row["patterns"])
    assert (mesh.name, mesh.options) == (row["mesh"], options)
    assert statistics.patterns == row["patterns"]
    assert statistics.patterns_met == row["patterns_oriented"]
    assert statistics.patches == row["patches"]
    assert statistics.by_sides == {int(n): k for n, k in row["by_sides"].items()}
    assert statistics.by_irregular == {int(n): k for n, k in row["by_irregular"].items()}
