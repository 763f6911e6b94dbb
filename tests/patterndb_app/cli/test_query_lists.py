"""patterndb query: filters, orders and how a list ends, told from the quads that it lists, which
are checked."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

import patterndb
from tests.support.cli.commandline import TINY, assert_refused, run
from tests.support.cli.querychecks import ALL, FEW, LOOPED, Fill, codes, document, fills, list_few
from tests.support.fillchecks import inner_valences, strands
from tests.support.reference.code import mirrored, rooted_code
from tests.support.reference.halfedge import twins
from tests.support.shared import EXAMPLES


@pytest.fixture(scope="module")
def few(learned: Path) -> list[Fill]:
    """All fills of FEW, in the default order."""
    return list_few(learned)


class TestFilters:
    def test_learned_only(self, learned: Path, few: list[Fill]) -> None:
        listed = fills(learned, *FEW, *ALL, "--learned-only")
        assert listed and listed == [fill for fill in few if fill["origin"] == "learned"]

    def test_loops_of_patterns(self, learned: Path) -> None:
        whole = fills(learned, *LOOPED, *ALL)
        looped = fills(learned, *LOOPED, *ALL, "--has-loop")
        plain = fills(learned, *LOOPED, *ALL, "--no-loop")
        assert looped and plain
        assert codes(looped) == codes([fill for fill in whole if strands(fill)[1]])
        assert codes(plain) == codes([fill for fill in whole if not strands(fill)[1]])

    def test_max_quads(self, learned: Path, few: list[Fill]) -> None:
        for most in (1, 9, 12, 15):
            kept = [fill for fill in few if len(fill["quads"]) <= most]
            assert codes(fills(learned, *FEW, *ALL, "--max-quads", most)) == codes(kept)

    def test_valence(self, learned: Path, few: list[Fill]) -> None:
        kept = [fill for fill in few if inner_valences(fill) <= {3, 4}]
        listed = fills(learned, *FEW, *ALL, "--valence=3..4")
        assert 0 < len(listed) < len(few)
        assert codes(listed) == codes(kept)

    def test_corners_of_patterns(self, learned: Path, few: list[Fill]) -> None:
        parts = [fills(learned, *FEW, *ALL, "--pattern-corners", n) for n in range(1, 12)]
        names = [{fill["pattern"] for fill in part} for part in parts]
        assert sum(map(len, names)) == len({fill["pattern"] for fill in few})
        assert codes([fill for part in parts for fill in part]) == codes(few)
        some = fills(learned, *FEW, *ALL, "--pattern-corners=3..4")
        assert codes(some) == codes(parts[2] + parts[3])
        # Two hexadecimal digits of a name are the pattern's corners.
        assert all(int(fill["pattern"][:2], 16) in (3, 4) for fill in some)

    def test_min_frequency(self, learned: Path) -> None:
        asked = ("--sides=3,5,4,6", *ALL)
        whole = fills(learned, *asked, "--learned-only")
        seen = sorted({fill["frequency"] for fill in whole})
        for least in (1, seen[1], seen[-1], seen[-1] + 1):
            kept = [fill for fill in whole if fill["frequency"] >= least]
            assert fills(learned, *asked, "--learned-only", "--min-frequency", least) == kept

    def test_from_mesh(self, learned: Path) -> None:
        asked = ("--sides=3,5,4,6", *ALL, "--strict")
        whole = fills(learned, *asked)
        shares = []
        for meshes in (["head.obj"], ["dog.obj"], ["drop.obj"], ["dog.obj", "head.obj"]):
            options = [f"--from-mesh={mesh}" for mesh in meshes]
            there = _patterns_of(learned, meshes)
            listed = fills(learned, *asked, *options)
            assert codes(listed) == codes([f for f in whole if f["pattern"] in there])
            shares.append(len(listed))
        assert shares[0] and shares[1] and not shares[2] and shares[3] >= max(shares[:2])
        assert_refused(
            run("query", *asked, "--db", learned, "--from-mesh=dig.obj"), 1, "dig.obj", "dog.obj"
        )

    def test_from_licence(self, tmp_path: Path) -> None:
        db = tmp_path / "a.db"
        for name, licence in (("jug", "CC0-1.0"), ("hand", "MIT")):
            mesh = EXAMPLES / f"{name}.obj"
            assert run("ingest", mesh, "--db", db, *TINY, "--licence", licence).code == 0
        asked = ("--sides=4,4,4,4", *ALL, "--strict")
        for licence, mesh in (("cc0-1.0", "jug"), ("cc*", "jug"), ("M?T", "hand")):
            there = fills(db, *asked, f"--from-mesh={mesh}.obj")
            assert there and fills(db, *asked, f"--from-licence={licence}") == there
        both = fills(db, *asked, "--from-licence=MIT", "--from-licence=CC0*")
        assert codes(both) >= codes(there)
        assert not fills(db, *asked, "--from-licence=MIT", "--from-licence=CC0*", "--max-quads=1")
        assert_refused(run("query", *asked, "--db", db, "--from-licence=GPL"), 1, "GPL", "MIT")


def _patterns_of(db: Path, meshes: list[str]) -> set[str]:
    marks = ",".join("?" * len(meshes))
    with sqlite3.connect(db) as connection:
        rows = connection.execute(
            "SELECT DISTINCT pattern_id FROM occurrence JOIN mesh ON mesh.id = mesh_id "
            f"WHERE mesh.name IN ({marks})",
            meshes,
        ).fetchall()
    connection.close()
    return {f"{row[0]:016x}" for row in rows}


class TestOrders:
    @pytest.mark.parametrize("order", ["artist", "regular", "small", "symmetric"])
    def test_all_list_the_same_fills(self, learned: Path, few: list[Fill], order: str) -> None:
        listed = fills(learned, *FEW, *ALL, "--order", order)
        assert codes(listed) == codes(few)

    def test_artist_is_the_default_and_begins_with_the_most_regular(
        self, learned: Path, few: list[Fill]
    ) -> None:
        assert fills(learned, *FEW, *ALL, "--order=artist") == few
        regular = fills(learned, *FEW, "--order=regular", "--limit=1")[0]
        of_first = (few[0]["n_irregular"], few[0]["n_irregular_boundary"])
        assert of_first == (regular["n_irregular"], regular["n_irregular_boundary"])
        # After it, strict fills that artists made come before what none has made.
        seen = [fill["frequency"] > 0 and fill["strict"] for fill in few[1:]]
        assert seen == sorted(seen, reverse=True)

    def test_recorded_uses_count_where_they_are_asked_for(self, db: Path) -> None:
        asked = ("--sides=3,5,4,6", *ALL, "--learned-only")
        before = fills(db, *asked)
        last = [fill["pattern"] for fill in before if fill["strict"]][-1]
        with patterndb.open(db, "write") as database:
            database.record_use(database.pattern(last), 10**9)
        assert fills(db, *asked) == before
        after = fills(db, *asked, "--use-counts")
        assert codes(after) == codes(before)
        assert after[0]["n_irregular"] == before[0]["n_irregular"]
        assert last in (after[0]["pattern"], after[1]["pattern"])

    def test_regular(self, learned: Path) -> None:
        listed = fills(learned, "--sides=3,5,4,6", "--limit=100", "--order=regular")
        keys = [(f["n_irregular"], f["n_irregular_boundary"], -f["frequency"]) for f in listed]
        tabled = [k for k, f in zip(keys, listed, strict=True) if f["origin"] != "constructed"]
        assert tabled == sorted(tabled)
        assert [k[0] for k in keys] == sorted(k[0] for k in keys)

    def test_small(self, learned: Path) -> None:
        sizes = [len(fill["quads"]) for fill in fills(learned, *FEW, *ALL, "--order=small")]
        assert sizes == sorted(sizes) and sizes[0] < sizes[-1]

    def test_symmetric(self, learned: Path) -> None:
        listed = fills(learned, "--sides=4,4,4,4", "--limit=60", "--order=symmetric")
        found = [_symmetries(fill) for fill in listed]
        assert found == sorted(found, reverse=True)
        assert found[0] == 8 and found[-1] < 8

    @pytest.mark.parametrize("order", ["flow", "quality"])
    def test_without_points_there_is_nothing_to_measure(self, learned: Path, order: str) -> None:
        result = run("query", *FEW, "--order", order, "--db", learned)
        assert_refused(result, 3, f"--order {order}", "points of the boundary")


def _symmetries(fill: Fill) -> int:
    """Of the 8 of a square, those that map the fill onto itself."""
    quads = fill["quads"]
    twin = twins(quads)
    corners = [side[0] for side in fill["sides"]]
    start = {quads[h // 4][h % 4]: h for h, t in enumerate(twin) if t < 0}
    ahead = [rooted_code(twin, start[corner]) for corner in corners]
    other = mirrored(twin)
    back = {tuple(rooted_code(other, h)): 0 for h, t in enumerate(other) if t < 0}
    return ahead.count(ahead[0]) * (2 if tuple(ahead[0]) in back else 1)


class TestEnding:
    @pytest.mark.parametrize("order", ["artist", "regular", "small", "symmetric"])
    @pytest.mark.parametrize("sides", ["9,7,8,6,9,7,8", "6,6,6,6", ",".join(["3"] * 20)])
    def test_no_time_is_enough_for_one(self, learned: Path, sides: str, order: str) -> None:
        asked = (f"--sides={sides}", "--limit=1000", "--order", order)
        answer = document(learned, *asked, "--time-limit=0.000001")
        assert answer["stopped"] == "time limit" and answer["truncated"] is True
        assert answer["fills"]

    def test_enough_time_changes_nothing(self, learned: Path, few: list[Fill]) -> None:
        answer = document(learned, *FEW, *ALL, "--time-limit=1000")
        assert answer["stopped"] is None and answer["truncated"] is False
        assert answer["fills"] == few

    @pytest.mark.parametrize("order", ["artist", "regular", "small", "symmetric"])
    def test_whenever_it_is_up_the_list_is_one(
        self, learned: Path, few: list[Fill], order: str
    ) -> None:
        whole = document(learned, *FEW, *ALL, "--order", order)
        for seconds in (0.01, 0.03, 0.1, 0.3):
            answer = document(learned, *FEW, *ALL, "--order", order, "--time-limit", seconds)
            assert answer["truncated"] == (answer["stopped"] == "time limit")
            assert codes(answer["fills"]) <= codes(few)
            # Not known where time was up.
            known = {whole["feasible_patterns"], *([None] if answer["truncated"] else [])}
            assert answer["feasible_patterns"] in known

    @pytest.mark.parametrize(
        "option", ["--max-quads=3", "--max-irregular=1", "--valence=5", "--strict", "--has-loop"]
    )
    def test_no_time_loosens_no_filter(self, learned: Path, option: str) -> None:
        asked = ("--sides=3,5,4,6", "--limit=1000", option)
        whole = codes(fills(learned, *asked))
        assert codes(fills(learned, *asked, "--time-limit=0.000001")) <= whole

    @pytest.mark.parametrize("options", [(), ("--flow=0:1-2:1",), ("--closed",)], ids=str)
    def test_solvers_and_threads_agree(self, learned: Path, options: tuple[str, ...]) -> None:
        asked = ("--sides=8" if options == ("--closed",) else "--sides=3,2,3,4", *options)
        lists = [
            fills(learned, *asked, "--limit=6", *how)
            for how in ((), ("--solver=cp-sat",), ("--jobs=1",), ("--jobs=7",))
        ]
        assert lists[0] and lists[0] == lists[1] == lists[2] == lists[3]
