"""Complete families: their counts, what every pattern in one is, and that none is missing."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from patterndb.core import description as d
from patterndb.core.code import decode, pattern_id
from patterndb.core.disk import Disk
from patterndb.core.packing import unpack
from patterndb.core.reduction import reduce_disk
from patterndb.system.caches import cache_folders
from query.errors import InvalidQueryError, QueryCancelledError
from query.relaxed.family import MOST_QUADS, PatternTable, load_family
from tests.support.query.cases import small_patterns
from tests.support.query.relaxed import forget_families


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder; what the process itself holds is forgotten too."""
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    forget_families()
    return tmp_path / "cache"


def convex_of_cost(patterns: PatternTable, cost: int) -> dict[int, int]:
    """How many patterns of this cost have no reflex corner, by number of sides."""
    rows = (patterns.cost == cost) & (patterns.n_reflex == 0)
    return dict(Counter(patterns.n_sides[rows].tolist()))


@pytest.mark.parametrize(
    ("most", "total", "convex"),
    [
        (1, 4, {3: 1, 5: 1}),
        (2, 23, {2: 2, 4: 2, 6: 2}),
        # Below 3 sides the numbers grow with the cap on the size.
        (3, 287, {3: 12, 5: 13, 7: 7}),
        (4, 5_887, {4: 180, 6: 145, 8: 58}),
    ],
)
def test_counts(most: int, total: int, convex: dict[int, int]) -> None:
    patterns = load_family(most)
    assert len(patterns) == total
    found = convex_of_cost(patterns, most)
    assert {n: found[n] for n in found if n > 2 or most < 3} == convex
    # The sum over the vertices tells which numbers of sides there can be.
    assert all(n % 2 == most % 2 for n in found)


def test_a_greater_valence() -> None:
    five, six = load_family(3), load_family(3, 6)
    assert set(five.codes) < set(six.codes)
    fits = [
        max(p.valences, default=4) <= 5 and max(p.corners, default=1) <= 3
        for p in (six.pattern(row) for row in range(len(six)))
    ]
    assert {c for c, f in zip(six.codes, fits, strict=True) if f} == set(five.codes)


def test_every_pattern_is_what_it_should_be() -> None:
    patterns = load_family()
    # Raises for a code that is not canonical or not a disk's.
    rows = d.describe(patterns.codes)
    assert len(set(patterns.codes)) == len(set(patterns.ids.tolist())) == len(patterns)
    for row, packed in enumerate(patterns.codes):
        twin = decode(unpack(packed).astype(np.uint16))
        assert len(reduce_disk(twin)) == len(twin) == 4 * patterns.n_quads[row]
        disk = Disk.from_twin(twin)
        valence = disk.valence()
        inner, edge = valence[disk.perimeter :], valence[: disk.perimeter]
        assert patterns.n_irregular[row] == (inner != 4).sum()
        assert patterns.n_reflex[row] == (edge > 2).sum()
        assert patterns.n_sides[row] == (edge != 2).sum()
        assert inner.min(initial=3) >= 3
        assert inner.max(initial=3) <= 5
        assert edge.max() <= 3
        assert patterns.ids[row] == pattern_id(packed, disk.n_sides)
        assert patterns.min_valence[row] == min(inner[inner != 4], default=4)
        assert patterns.max_valence[row] == max(inner[inner != 4], default=4)
        assert patterns.max_count[row] == max(edge.max(), 2)
        assert patterns.n_loops[row] == rows.counts[row, d.N_LOOPS]
    assert patterns.cost.max() == 4
    assert 31 < patterns.n_quads.max() <= MOST_QUADS


def test_the_patterns_of_a_family_are_in_order_of_their_ids() -> None:
    patterns = load_family(3)
    assert (np.diff(patterns.ids) > 0).all()
    chosen = [patterns.pattern(row) for row in range(len(patterns))]
    assert [p.id for p in chosen] == patterns.ids.tolist()
    assert [p.n_sides for p in chosen] == patterns.n_sides.tolist()
    assert {(p.origin, p.frequency) for p in chosen} == {("family", 0)}
    assert not patterns.learned.any()


def test_growing_ends_when_it_is_cancelled(cache: Path) -> None:
    with pytest.raises(QueryCancelledError):
        load_family(2, cancelled=np.ones(1, np.uint8))
    assert not list(cache.rglob("*.arrays"))
    assert len(load_family(2)) == 23


@pytest.mark.parametrize("most", [2, 4])
def test_holds_every_small_pattern(most: int) -> None:
    ids = set(load_family(most).ids.tolist())
    within = [
        p
        for p in small_patterns()
        if p.n_irregular + sum(k > 2 for k in p.corners) <= most and not p.self_crossing
    ]
    assert len(within) > (10 if most == 2 else 300)
    assert {p.id for p in within} <= ids


def test_a_smaller_cap_only_leaves_out() -> None:
    small, large = load_family(3, max_quads=12), load_family(3)
    assert set(small.codes) <= set(large.codes)
    assert small.n_quads.max() <= 12
    assert {c for c, q in zip(large.codes, large.n_quads, strict=True) if q <= 12} == set(
        small.codes
    )


@pytest.mark.parametrize("bounds", [(-1, 5, 100), (4, 3, 100), (4, 5, 0), (4, 5, 20_000)])
def test_bounds_that_mean_nothing(bounds: tuple[int, int, int]) -> None:
    most, valence, max_quads = bounds
    with pytest.raises(InvalidQueryError, match="a family needs"):
        load_family(most, valence, max_quads=max_quads)


def test_kept_between_runs(cache: Path) -> None:
    first = load_family(2)
    (kept,) = cache.rglob("*.arrays")
    before = kept.read_bytes(), kept.stat().st_ino
    forget_families()
    again = load_family(2)
    assert again is not first
    assert again.codes == first.codes
    assert (kept.read_bytes(), kept.stat().st_ino) == before
    # Another family has another file.
    load_family(1)
    load_family(2, 6)
    load_family(2, max_quads=50)
    assert len(list(cache.rglob("*.arrays"))) == 4


@pytest.mark.parametrize("damage", ["short", "flipped", "empty", "foreign", "another's"])
def test_a_damaged_file_is_made_again(cache: Path, damage: str) -> None:
    first = load_family(2)
    (kept,) = cache.rglob("*.arrays")
    good = kept.read_bytes()
    bad = bytearray(good)
    bad[len(bad) // 2] ^= 4
    load_family(1)
    (other,) = (path for path in cache.rglob("*.arrays") if path != kept)
    content = {
        "short": good[:-3],
        "flipped": bytes(bad),
        "empty": b"",
        "foreign": b"not ours at all" * 20,
        "another's": other.read_bytes(),
    }[damage]
    kept.write_bytes(content)
    forget_families()
    assert load_family(2).codes == first.codes
    assert kept.read_bytes() == good


def test_nowhere_to_keep_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "file" / "below"))
    assert len(load_family(2)) == 23


def test_the_folder_is_the_user_s_to_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "x" / "y"))
    assert cache_folders() == [tmp_path / "x" / "y"]
    monkeypatch.delenv("PATTERNDB_CACHE")
    assert len(cache_folders()) == 2
