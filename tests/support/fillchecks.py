"""What the quads of a fill's JSON say of it, read by plain Python that shares nothing with ours."""

from __future__ import annotations

import importlib.util
import sys
from collections import Counter
from collections.abc import Sequence
from functools import cache
from itertools import pairwise, permutations
from types import ModuleType
from typing import Any

from tests.support.reference.code import Code, rooted_code
from tests.support.reference.halfedge import as_complex, border_loop, fans, is_disk, twins
from tests.support.shared import SHARED, oracle

#: (side, edge), both from 0.
Place = tuple[int, int]

#: Quads or sides that may be looked up.
Frozen = tuple[tuple[int, ...], ...]

#: A program of others that checks fills, too.
CHECKER = SHARED / "oracle" / "check_fill.py"

QUADS_AT = {"convex": 1, "reflex": 3}


def check_fill(
    lengths: Sequence[int], fill: dict[str, Any], kinds: Sequence[int] | None = None
) -> tuple[int, int]:
    """Check a fill in JSON against its boundary; return its irregular vertices inside and on it.

    It must be a disk of quads whose sides run along the border, with the lengths asked for, and
    count its vertices rightly. ``kinds`` are the quads that belong at the corners: 1 each if not
    given. Where the shared folder has the program that checks fills, that must agree.
    """
    quads, sides = fill["quads"], fill["sides"]
    assert quads
    assert all(len(quad) == len(set(quad)) == 4 for quad in quads)
    assert [len(side) - 1 for side in sides] == list(lengths)
    assert all(side[-1] == sides[(i + 1) % len(sides)][0] for i, side in enumerate(sides))
    complex_ = as_complex(twins(quads))
    assert is_disk(complex_)
    # Every name is one fan of quads, and every fan has one name.
    vertex = fans(complex_)
    names = {(v, quads[h // 4][h % 4]) for h, v in vertex.items()}
    n_vertices = len(set(vertex.values()))
    assert len(names) == n_vertices
    assert {name for _, name in names} == set(range(n_vertices))
    assert fill.get("n_vertices", n_vertices) == n_vertices
    along = [v for side in sides for v in side[:-1]]
    start = next(h for h, t in complex_.items() if t < 0 and quads[h // 4][h % 4] == along[0])
    border = [quads[h // 4][h % 4] for h in border_loop(complex_, start)]
    assert along in (border, [border[0], *border[:0:-1]])
    count = Counter(v for quad in quads for v in quad)
    due = dict.fromkeys(along, 2)
    due |= dict(zip((side[0] for side in sides), kinds or [1] * len(sides), strict=True))
    counted = (
        sum(n != 4 for v, n in count.items() if v not in due),
        sum(count[v] != n for v, n in due.items()),
    )
    assert fill.get("n_irregular", sum(counted)) == sum(counted)
    if CHECKER.is_file():
        assert _load_checker().check(list(lengths), fill, kinds) == (None, counted)
    return counted


@cache
def _load_checker() -> ModuleType:
    """Load the program of the shared folder that checks fills."""
    sys.modules.setdefault("oracle", oracle())
    spec = importlib.util.spec_from_file_location("check_fill", CHECKER)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def irregular(fill: dict[str, Any], corners: Sequence[str]) -> tuple[int, int]:
    """Irregular vertices within and on the boundary; without corners it is one closed side."""
    count = Counter(v for quad in fill["quads"] for v in quad)
    border = {v for side in fill["sides"] for v in side}
    asked = dict.fromkeys(border, 2)
    for side, kind in zip(fill["sides"], corners, strict=False):
        asked[side[0]] = QUADS_AT[kind]
    within = sum(n != 4 for v, n in count.items() if v not in border)
    return within, sum(count[v] != n for v, n in asked.items())


def inner_valences(fill: dict[str, Any]) -> set[int]:
    """Of the irregular vertices within."""
    count = Counter(v for quad in fill["quads"] for v in quad)
    border = {v for side in fill["sides"] for v in side}
    return {n for v, n in count.items() if v not in border} - {4}


def code(fill: dict[str, Any]) -> Code:
    """Read from the first edge of the first side: equal exactly for equal fills."""
    return _code(_frozen(fill["quads"]), fill["sides"][0][0])


@cache
def _code(quads: Frozen, first: int) -> Code:
    twin = twins([list(quad) for quad in quads])
    (start,) = (h for h, t in enumerate(twin) if t < 0 and quads[h // 4][h % 4] == first)
    return rooted_code(twin, start)


def strands(fill: dict[str, Any]) -> tuple[list[tuple[Place, Place]], int]:
    """The ends of the strands that have some, and how many run in loops."""
    return _strands(_frozen(fill["quads"]), _frozen(fill["sides"]))


@cache
def _strands(quads: Frozen, sides: Frozen) -> tuple[list[tuple[Place, Place]], int]:
    across: dict[tuple[int, int], tuple[int, int]] = {}
    for a, b, c, d in quads:
        # Who enters a quad over an edge leaves it over the opposite one, into the next quad.
        across |= {(a, b): (d, c), (b, c): (a, d), (c, d): (b, a), (d, a): (c, b)}
    place = {edge: (s, i) for s, side in enumerate(sides) for i, edge in enumerate(pairwise(side))}
    passed: set[tuple[int, int]] = set()
    ends: list[tuple[Place, Place]] = []
    for edge, at in place.items():
        over = edge
        while over in across:
            passed |= {over, over[::-1]}
            over = across[over]
        passed |= {over, over[::-1]}
        other = place[over[::-1]]
        if at <= other:
            ends.append((at, other))
    loops = 0
    for edge in across:
        loops += edge not in passed
        over = edge
        while over not in passed:
            passed |= {over, over[::-1]}
            over = across[over]
    return ends, loops


def _frozen(rows: list[list[int]]) -> Frozen:
    return tuple(map(tuple, rows))


def off(fill: dict[str, Any], strokes: Sequence[tuple[Place, Place]], tolerance: int) -> int | None:
    """The least number of edges by which strands, one for each stroke, miss their ends."""
    sums: list[int] = []
    for chosen in permutations(strands(fill)[0], len(strokes)):
        missed = [_missed(*pair, tolerance) for pair in zip(chosen, strokes, strict=True)]
        sums += [sum(m for m in missed if m is not None)] if None not in missed else []
    return min(sums, default=None)


def _missed(strand: tuple[Place, Place], stroke: tuple[Place, Place], tolerance: int) -> int | None:
    found: list[int] = []
    for near, far in (stroke, stroke[::-1]):
        (a, i), (b, j) = near, far
        (s, k), (t, m) = strand
        if (a, b) == (s, t) and max(abs(i - k), abs(j - m)) <= tolerance:
            found.append(abs(i - k) + abs(j - m))
    return min(found, default=None)
