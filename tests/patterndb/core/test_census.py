"""All disk quadrangulations up to a size, from plain Python, are distinguished by their codes."""

from __future__ import annotations

from collections import Counter
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from ingest import learn
from patterndb.core.code import canonical_code, decode
from patterndb.core.disk import Disk
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import unpack
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from patterndb.store import LearningOptions
from tests.support.meshes import examples, mesh_of_file, models, shared_meshes
from tests.support.reference import code as reference
from tests.support.reference.growth import list_small_disks
from tests.support.reference.halfedge import as_complex, border_vertices, fans
from tests.support.shared import GOLDEN
from tests.support.smalldisks import MOST_BORDER, MOST_INNER, make_row, read_small_disks

#: The same list by a program of others.
CATALOGUE = GOLDEN / "disk_quadrangulations.dqs"


@cache
def quadrangulations() -> list[Int32Array]:
    """The half-edges of every row of the list."""
    rows: list[Int32Array] = []
    for n_border, n_inner, quads in read_small_disks():
        mesh = QuadMesh.from_quads(np.array(quads))
        disk = Disk.from_twin(mesh.twin)
        assert (disk.perimeter, disk.n_vertices) == (n_border, n_border + n_inner)
        rows.append(mesh.twin)
    return rows


def test_the_list_is_what_grows_quad_by_quad() -> None:
    """And, where the catalogue of another program is, what that lists."""
    grown = list_small_disks(MOST_BORDER, MOST_INNER)
    assert tuple(map(make_row, grown)) == read_small_disks()
    if CATALOGUE.is_file():
        other: set[bytes] = set()
        for line in CATALOGUE.read_text().splitlines():
            if not line.startswith("//"):
                quads = np.array(line.split()[3:], np.int64).reshape(-1, 4)
                other.add(canonical_code(QuadMesh.from_quads(quads).twin)[0].tobytes())
        assert other == {canonical_code(twin)[0].tobytes() for twin in quadrangulations()}


def profile(twin: list[int]) -> tuple[object, ...]:
    """What isomorphic disks share and is cheap to count: quads at the vertices of the boundary
    and at those inside."""
    complex_ = as_complex(twin)
    vertex = fans(complex_)
    count = Counter(vertex.values())
    border = border_vertices(complex_, vertex)
    return tuple(sorted((v in border, k) for v, k in count.items()))


def assert_codes_tell_apart(twins: list[Int32Array]) -> int:
    """Codes are equal exactly where a plain traversal finds an isomorphism; returns in how
    many pairs that is not plain from counts."""
    groups: dict[tuple[object, ...], list[tuple[list[int], tuple[int, ...]]]] = {}
    for twin in twins:
        code = tuple(canonical_code(twin)[0].tolist())
        groups.setdefault(profile(twin.tolist()), []).append((twin.tolist(), code))
    pairs = 0
    for group in groups.values():
        for (a, code_a), (b, code_b) in combinations(group, 2):
            assert (code_a == code_b) == reference.isomorphic(a, b)
            pairs += 1
    return pairs


def test_every_row_has_its_own_code() -> None:
    codes = {canonical_code(twin)[0].tobytes() for twin in quadrangulations()}
    assert len(codes) == len(quadrangulations()) == 3753


def test_codes_of_the_rows_agree_with_isomorphism() -> None:
    assert assert_codes_tell_apart(quadrangulations()) > 100_000


def test_a_row_is_isomorphic_to_its_copies_alone() -> None:
    """Every 50th row, renumbered and mirrored, among rows that look alike."""
    for twin in quadrangulations()[::50]:
        copy = decode(canonical_code(twin)[0])
        assert reference.isomorphic(copy.tolist(), twin.tolist())


def test_the_rows_that_are_patterns_reduce_to_themselves_and_no_other_does() -> None:
    patterns: set[bytes] = set()
    rest: set[bytes] = set()
    for twin in quadrangulations():
        reduced = reduce_disk(twin)
        code = canonical_code(reduced)[0].tobytes()
        if len(reduced) == len(twin):
            assert code not in patterns
            patterns.add(code)
        else:
            rest.add(code)
    # The list is closed under collapse, but for patterns with too few boundary vertices.
    assert rest <= patterns
    assert len(patterns) == 2482


@pytest.mark.parametrize("prepare", [False, True])
def test_learned_patterns_are_pairwise_not_isomorphic(prepare: bool) -> None:
    options = LearningOptions(basic=5, side=10, convex=16, prepare=prepare)
    codes: set[bytes] = set()
    for path in [*examples(), *models(), *shared_meshes("spot", "penguin")]:
        mesh = mesh_of_file(path)
        codes |= set(learn(mesh.source[mesh.quads], options).codes)
    twins = [decode(unpack(code).astype(np.uint16)) for code in sorted(codes)]
    assert len(twins) > 300
    assert assert_codes_tell_apart(twins) > 2000
    for twin in twins:
        assert len(reduce_disk(twin)) == len(twin), "a learned pattern is not reduced"
