"""Filters by source mesh and licence, against all occurrences asked one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ingest import ingest
from patterndb.core.packing import pack
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import NotFoundError
from patterndb.store import Database, Learned, Provenance
from tests.patterndb.store.test_reading import staircase
from tests.support.meshes import DOUBLET, write_obj
from tests.support.store.learnt import OPTIONS

LICENCES = {
    "cup.obj": "CC0-1.0",
    "star.obj": "CC-BY-4.0",
    "grid.obj": "cc0-1.0",
    "pair.obj": "MIT [x]",
}


@pytest.fixture
def licensed(full: Path) -> Path:
    with Database(full, "write") as db:
        for mesh in db.meshes():
            licence = LICENCES.get(mesh.name)
            db.update_provenance(mesh.sha256, mesh.name, Provenance(None, None, licence))
        # A pattern that was only used is in no mesh.
        db.record_use(Database(full).pattern_class(3).pattern(0))
    return full


def expected(db: Database, n_sides: int, names: set[str]) -> list[int]:
    found = db.pattern_class(n_sides)
    patterns = [found.pattern(row) for row in range(len(found))]
    return sorted(p.id for p in patterns if names & {o.mesh for o in db.occurrences(p)})


CASES = [
    (["cup.obj"], None, {"cup.obj"}),
    (["cup.obj", "stars.obj"], None, {"cup.obj", "stars.obj"}),
    (None, ["CC0-1.0"], {"cup.obj", "grid.obj"}),
    (None, ["cc*"], {"cup.obj", "grid.obj", "star.obj"}),
    (None, ["CC-BY-?.0", "mit [x]"], {"star.obj", "pair.obj"}),
    (None, ["*"], set(LICENCES)),
    (["cup.obj", "star.obj"], ["cc0*"], {"cup.obj"}),
    (["stars.obj"], ["cc0*"], set()),
    ([], None, set()),
]


@pytest.mark.parametrize(("meshes", "licences", "names"), CASES)
def test_ids_are_those_that_occur(
    licensed: Path, meshes: list[str] | None, licences: list[str] | None, names: set[str]
) -> None:
    with Database(licensed) as db:
        for n_sides in [*db.sides_histogram(), 99]:
            found = db.pattern_ids(n_sides, meshes, licences)
            assert found.dtype == np.int64
            assert found.tolist() == expected(db, n_sides, names)


def test_without_a_filter_it_is_the_whole_class(licensed: Path) -> None:
    with Database(licensed) as db:
        for n_sides in db.sides_histogram():
            assert db.pattern_ids(n_sides).tolist() == sorted(db.pattern_class(n_sides).ids)


def test_a_mesh_is_named_by_the_digits_of_its_hash(licensed: Path) -> None:
    with Database(licensed) as db:
        star = next(m for m in db.meshes() if m.name == "star.obj")
        found = db.pattern_ids(5, [star.sha256[:8].upper()])
        assert found.tolist() == db.pattern_ids(5, ["star.obj"]).tolist() != []


def test_a_name_of_two_meshes_stands_for_both(licensed: Path, tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    with Database(licensed, "write") as db:
        ingest(db, [write_obj(tmp_path / "more" / "cup.obj", DOUBLET[::-1])], OPTIONS)
        for n_sides in db.sides_histogram():
            found = set(db.pattern_ids(n_sides, ["cup.obj"]).tolist())
            assert found == set(expected(db, n_sides, {"cup.obj"}))


def test_unknown_names_are_told_with_what_comes_near(licensed: Path) -> None:
    with Database(licensed) as db:
        with pytest.raises(NotFoundError, match=r"no mesh 'stra.obj' \(did you mean 'star.obj'"):
            db.pattern_ids(4, ["cup.obj", "stra.obj"])
        with pytest.raises(NotFoundError, match=r"'STARS' \(did you mean .*'stars.obj'"):
            db.pattern_ids(4, ["STARS"])
        with pytest.raises(NotFoundError, match="no mesh 'zzzz'; 'patterndb meshes'"):
            db.pattern_ids(4, ["zzzz"])
        with pytest.raises(NotFoundError, match=r"licence 'GPL\*'; there are: CC-BY-4.0, CC0-1.0"):
            db.pattern_ids(4, None, ["MIT*", "GPL*"])


def test_very_many_sides_are_told_apart(tmp_path: Path) -> None:
    """From 127 sides on, all classes share a range of ids."""
    patterns = [Pattern.from_disk(QuadMesh.from_quads(staircase(n)).twin) for n in (61, 64, 66)]
    sides = np.array([p.n_sides for p in patterns], np.int32)
    assert (sides >= 127).sum() >= 2
    with Database(tmp_path / "wide.db", "create") as db:
        learned = Learned(
            *(64, 64, 3, 0, 0),
            distinct=3,
            codes=[pack(p.code) for p in patterns],
            sides=sides,
            patches=np.array([[1, 0]] * 3),
            examples=[pack([0, *[1] * (p.n_quads - 1)]) for p in patterns],
        )
        db.add_mesh("stairs", "00" * 32, Provenance(), OPTIONS, learned)
        assert db.verify() == []
        for pattern in patterns:
            assert db.pattern_ids(pattern.n_sides).tolist() == [pattern.id]
            assert db.pattern_ids(pattern.n_sides, ["stairs"]).tolist() == [pattern.id]
