"""Patterns of holes: every way that they embedding in a loop, against plain enumeration."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.recognition import weld_quads
from patterndb.core.pattern import Pattern
from patterndb.system.deadline import end_by
from query.expand import expand_pattern
from query.fill import Fill
from query.holes.models import shipped_models
from query.holes.patterns import KEPT, REACH, SHARE, HolePatterns, PatternEmbedding
from query.recognition import hash_quads


def some_patterns(rows: list[int]) -> HolePatterns:
    """A few of the shipped patterns."""
    shipped = shipped_models().patterns
    data = shipped.codes.tobytes()
    codes = [data[shipped.ends[row] : shipped.ends[row + 1]] for row in rows]
    return HolePatterns(
        np.frombuffer(b"".join(codes), np.uint8),
        np.cumsum([0, *map(len, codes)]).astype(np.int32),
        shipped.meshes[rows],
        shipped.share[rows],
    )


def turn_fill(fill: Fill, first: int, n: int) -> tuple[bytes, tuple[int, ...]]:
    """What tells a fill in the loop's numbering from others, and the quads at the loop."""
    quads = np.where(fill.quads < n, (fill.quads + first) % n, fill.quads).astype(np.int32)
    twin, fault = weld_quads(quads, fill.n_vertices, n)
    corners = tuple(np.bincount(quads.ravel(), minlength=n)[:n].tolist())
    return (b"" if fault else hash_quads(quads, twin, False)), corners


def list_widths(total: int, chords: int) -> list[tuple[int, ...]]:
    return [
        widths for widths in product(range(1, total + 1), repeat=chords) if sum(widths) == total
    ]


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_the_likeliest_ways_are_those_of_plain_enumeration(data: st.DataObject) -> None:
    patterns = shipped_models().patterns
    half = data.draw(st.integers(3, 6))
    rows = data.draw(
        st.lists(st.integers(0, len(patterns) - 1), min_size=1, max_size=4, unique=True)
    )
    chosen = some_patterns(rows)
    n = 2 * half
    draw = np.random.default_rng(data.draw(st.integers(0, 1 << 30)))
    logs = np.log(draw.dirichlet(np.full(4, 0.4), size=n) + 1e-5)
    best = logs.max(axis=1).sum()
    expected: dict[bytes, float] = {}
    for row in range(len(chosen)):
        pattern = chosen.pattern(row)
        if pattern.n_chords > half:
            continue
        for widths in list_widths(half, pattern.n_chords):
            for mirrored, turn in product((False, True), range(n)):
                fill = expand_pattern(pattern, widths, mirrored=mirrored)
                key, corners = turn_fill(fill, turn, n)
                if max(corners) > 4:
                    continue
                lost = best - sum(logs[i, k - 1] for i, k in enumerate(corners))
                score = SHARE * float(np.log(chosen.share[row])) - lost
                expected[key + bytes([row])] = score
    embeddings, quads = chosen.enumerate_embeddings(logs, most=100_000)
    found: dict[bytes, float] = {}
    for embedding, corners in zip(embeddings, quads.tolist(), strict=True):
        fill = expand_pattern(
            chosen.pattern(embedding.pattern), embedding.widths, mirrored=embedding.mirrored
        )
        key, own = turn_fill(fill, chosen.first_vertex(embedding), n)
        assert own == tuple(corners)
        lost = best - sum(logs[i, k - 1] for i, k in enumerate(corners))
        score = SHARE * float(np.log(chosen.share[embedding.pattern])) - lost
        found[key + bytes([embedding.pattern])] = score
    assert found.keys() <= expected.keys()
    if expected:
        top = max(expected.values())
        near = {key for key, score in expected.items() if score > top - REACH + 1e-9}
        assert near <= found.keys()
        assert embeddings, "the likeliest way is always there"
        first = found[
            turn_fill(
                expand_pattern(
                    chosen.pattern(embeddings[0].pattern),
                    embeddings[0].widths,
                    mirrored=embeddings[0].mirrored,
                ),
                chosen.first_vertex(embeddings[0]),
                n,
            )[0]
            + bytes([embeddings[0].pattern])
        ]
        assert np.isclose(first, top)


def test_shipped_patterns_are_patterns() -> None:
    patterns = shipped_models().patterns
    assert (np.diff(patterns.share) <= 0).all() and (patterns.meshes >= 1).all()
    assert np.isclose(patterns.share.sum(), 1.0, atol=1e-3)
    for row in range(0, len(patterns), 97):
        pattern = patterns.pattern(row)
        assert patterns.row_of(pattern.id) == row
        assert pattern == Pattern.from_code(pattern.code)
    assert patterns.row_of(1) == -1


def test_no_more_ways_than_asked_for_and_the_best_of_them() -> None:
    patterns = shipped_models().patterns
    draw = np.random.default_rng(3)
    logs = np.log(draw.dirichlet(np.full(4, 0.3), size=20) + 1e-5)
    few, _ = patterns.enumerate_embeddings(logs, most=20)
    many, _ = patterns.enumerate_embeddings(logs, most=KEPT)
    assert len(few) == 20 and len(many) <= KEPT

    def score(embedding: PatternEmbedding, corners: list[int]) -> float:
        own = sum(logs[i, k - 1] for i, k in enumerate(corners))
        return float(own + SHARE * np.log(patterns.share[embedding.pattern]))

    scores = [
        [score(*one) for one in zip(*patterns.enumerate_embeddings(logs, most=most), strict=True)]
        for most in (20, KEPT)
    ]
    assert np.allclose(scores[0], scores[1][:20])


def test_odd_and_long_loops_have_no_ways() -> None:
    patterns = shipped_models().patterns
    for n in (7, 200):
        embeddings, quads = patterns.enumerate_embeddings(np.full((n, 4), -1.0))
        assert not embeddings and quads.shape == (0, n)


def test_the_deadline_of_the_thread_ends_the_search() -> None:
    logs = np.log(np.random.default_rng(1).dirichlet(np.full(4, 0.4), size=40) + 1e-5)
    with end_by(0.0):
        found, quads = shipped_models().patterns.enumerate_embeddings(logs)
    assert not found
    assert quads.shape == (0, 40)
    with end_by(math.inf):
        assert shipped_models().patterns.enumerate_embeddings(logs)[0]
