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
from patterndb.system.caches import cache_folders, read_cached, write_cached
from query.errors import InvalidQueryError
from query.families.family import Family, load_family
from tests.support.query.cases import small_patterns


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder; what the process itself holds is forgotten too."""
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    load_family.cache_clear()
    return tmp_path / "cache"


def convex_at_most_cost(patterns: Family) -> dict[int, int]:
    """How many patterns of the greatest cost have no reflex corner, by number of sides."""
    rows = (patterns.cost == patterns.most) & (patterns.n_reflex == 0)
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
    found = convex_at_most_cost(patterns)
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
        assert patterns.self_crossing[row] == rows.counts[row, d.SELF_CROSSING]
    assert patterns.cost.max() == 4
    assert patterns.n_quads.max() <= patterns.max_quads


def test_sorted_and_taken_apart_by_sides() -> None:
    patterns = load_family(3)
    keys = list(
        zip(patterns.cost.tolist(), patterns.n_sides.tolist(), patterns.ids.tolist(), strict=True)
    )
    assert keys == sorted(keys)
    for n in range(8):
        chosen = list(patterns.patterns(n))
        assert {p.n_sides for p in chosen} <= {n}
        assert {(p.origin, p.frequency) for p in chosen} <= {("family", 0)}
        assert [p.id for p in chosen] == patterns.ids[patterns.rows(n)].tolist()


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
    (kept,) = cache.iterdir()
    before = kept.read_bytes(), kept.stat().st_mtime_ns
    load_family.cache_clear()
    again = load_family(2)
    assert again is not first
    assert again.codes == first.codes
    assert (kept.read_bytes(), kept.stat().st_mtime_ns) == before
    # Another family has another file.
    load_family(1)
    load_family(2, 6)
    load_family(2, max_quads=50)
    assert len(list(cache.iterdir())) == 4


@pytest.mark.parametrize("damage", ["short", "flipped", "empty", "foreign", "another's"])
def test_a_damaged_file_is_made_anew(cache: Path, damage: str) -> None:
    first = load_family(2)
    (kept,) = cache.iterdir()
    good = kept.read_bytes()
    bad = bytearray(good)
    bad[len(bad) // 2] ^= 4
    load_family(1)
    (other,) = (path for path in cache.iterdir() if path != kept)
    content = {
        "short": good[:-3],
        "flipped": bytes(bad),
        "empty": b"",
        "foreign": b"not ours at all" * 20,
        "another's": other.read_bytes(),
    }[damage]
    kept.write_bytes(content)
    load_family.cache_clear()
    assert load_family(2).codes == first.codes
    assert kept.read_bytes() == good


def test_nowhere_to_keep_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "file" / "below"))
    assert not write_cached("a", b"b")
    assert read_cached("a") is None
    assert len(load_family(2)) == 23


def test_the_folder_is_the_user_s_to_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "x" / "y"))
    assert cache_folders() == [tmp_path / "x" / "y"]
    assert write_cached("name", b"one")
    assert write_cached("name", b"two")
    assert read_cached("name") == b"two"
    monkeypatch.delenv("PATTERNDB_CACHE")
    assert len(cache_folders()) == 2
