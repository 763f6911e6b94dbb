"""Holes: loops, surroundings, corners, candidates, placing, twins, welding."""

from __future__ import annotations

import random
from itertools import islice, pairwise, product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from ingest.formats import read_mesh
from patterndb._native.query.recognition import weld_quads
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.surface import Surface
from query import Boundary, Stroke
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.holes import (
    HoleFill,
    MeshTopology,
    choose_hole,
    fill_holes,
    find_holes,
    hole_of_faces,
    hole_of_loop,
    list_mesh_flaws,
    list_parity_fixes,
    weld_fills,
)
from query.holes.corners import TRAITS, TreeModel, list_assignments, measure_assignments
from query.holes.features import (
    N_FEATURES,
    N_HOLE_FEATURES,
    measure_hole,
    measure_loop,
    mirror_features,
    mirror_hole,
)
from query.holes.models import shipped_models
from query.holes.neighbourhood import HoleRim, extract_neighbourhood
from query.holes.projection import LoopDisk, PlacedFill, count_flipped, mend_fill
from query.holes.ranking import NAMES, tame_numbers
from query.holes.symmetry import (
    count_followed,
    find_mirrors,
    find_rest,
    follow_mirrors,
    prepare_twins,
)
from query.placing import measure_flow_distance
from query.recognition import hash_quads
from tests.support.shared import CHECKOUT

HEAD = CHECKOUT / "examples" / "head.obj"


def grid(n: int, without: set[tuple[int, int]] = frozenset()) -> PolygonMesh:  # type: ignore[assignment]
    """n x n unit quads in the plane, less some, by column and row."""
    points = [(x, y, 0.0) for y in range(n + 1) for x in range(n + 1)]
    faces = [
        [y * (n + 1) + x, y * (n + 1) + x + 1, (y + 1) * (n + 1) + x + 1, (y + 1) * (n + 1) + x]
        for y in range(n)
        for x in range(n)
        if (x, y) not in without
    ]
    return PolygonMesh.from_faces(np.array(points), faces)


HOLED = grid(6, {(2, 2), (3, 2), (2, 3), (3, 3)})
OPENED = grid(9, set(product(range(2, 7), range(2, 7))))


def check_weld(fills: list[HoleFill]) -> PolygonMesh:
    """Nothing old has changed, and the holes are closed by quads."""
    old = fills[0].hole.topology.mesh
    new = weld_fills(fills)
    assert new.points[: len(old.points)].tobytes() == old.points.tobytes()
    removed = np.concatenate([fill.hole.removed for fill in fills])
    stays = [f for i, f in enumerate(old.faces()) if i not in set(removed.tolist())]
    assert [list(f) for f in islice(new.faces(), len(stays))] == [list(f) for f in stays]
    assert (new.arities()[len(stays) :] == 4).all()
    before, after = MeshTopology.of(old), MeshTopology.of(new)
    assert not after.crowded.any()
    assert not after.flipped[len(stays) :].any() or before.flipped.any()
    edges = np.concatenate([f.hole.edges for f in fills if not len(f.hole.removed)] or [[]])
    closed = (edges >= 0).sum() - (edges < 0).sum()
    assert (after.twin < 0).sum() == (before.twin < 0).sum() - closed
    used = np.unique(new.corners)
    assert set(range(len(old.points), len(new.points))) <= set(used.tolist())
    return new


def check_fill(fill: HoleFill) -> None:
    """The quads are a disk on the loop, in both numberings."""
    n = len(fill.hole)
    _, fault = weld_quads(fill.local, n + len(fill.points), n)
    assert not fault
    first = len(fill.hole.topology.mesh.points)
    names = np.concatenate([fill.hole.loop, first + np.arange(len(fill.points))])
    assert (names[fill.local] == fill.quads).all()
    assert (np.bincount(fill.local.ravel())[:n] == fill.corners).all()
    assert np.isfinite(fill.points).all()


def test_loops_of_a_grid() -> None:
    inner, rim = find_holes(HOLED)
    assert (len(inner), len(rim)) == (8, 24)
    # As the quads within will run: counter-clockwise, while the rim runs clockwise.
    area = np.cross(inner.points, np.roll(inner.points, -1, axis=0)).sum(axis=0)[2]
    assert area > 0 and inner.length == 8.0 and inner.centre.tolist() == [3.0, 3.0, 0.0]
    around = extract_neighbourhood(inner)
    assert sorted(around.clamped_valence.tolist()) == [1, 1, 1, 1, 2, 2, 2, 2]
    assert around.scale == 1.0 and measure_loop(inner, around).shape == (8, N_FEATURES)
    turned = hole_of_loop(MeshTopology.of(HOLED), [int(inner.loop[3]), int(inner.loop[1])])
    assert turned.loop[0] == inner.loop[3] and set(turned.loop) == set(inner.loop)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_loops_close_whatever_faces_share_an_edge(data: st.DataObject) -> None:
    # Squares of a lattice of cubes, any of them: edges have up to four, and borders begin and end
    # where three or four meet.
    at = {p: i for i, p in enumerate(product(range(3), repeat=3))}
    squares = [
        [at[p], at[a], at[c], at[b]]
        for p in at
        for i, j in ((0, 1), (0, 2), (1, 2))
        for a, b, c in [
            (
                tuple(x + (k == i) for k, x in enumerate(p)),
                tuple(x + (k == j) for k, x in enumerate(p)),
                tuple(x + (k in (i, j)) for k, x in enumerate(p)),
            )
        ]
        if c in at
    ]
    kept = data.draw(st.lists(st.sampled_from(squares), min_size=1, max_size=36, unique_by=tuple))
    kept = data.draw(st.permutations(kept))
    mesh = PolygonMesh.from_faces(np.array(list(at), np.float64), kept)
    uses: dict[frozenset[int], int] = {}
    for face in kept:
        for i, a in enumerate(face):
            edge = frozenset((a, face[(i + 1) % 4]))
            uses[edge] = uses.get(edge, 0) + 1
    try:
        holes = find_holes(mesh)
    except InvalidMeshError as error:
        crowded = "more than two faces" in str(error) and max(uses.values()) > 2
        assert crowded or "one-sided" in str(error) or "one side" in str(error)
        return
    seen: list[frozenset[int]] = []
    for hole in holes:
        loop = hole.loop.tolist()
        assert len(loop) >= 3
        seen += [frozenset((a, loop[(i + 1) % len(loop)])) for i, a in enumerate(loop)]
    assert len(set(seen)) == len(seen)
    assert all(uses[edge] == 1 for edge in seen)
    # Without such edges every border edge is in a loop.
    if max(uses.values()) < 3:
        assert set(seen) == {edge for edge, n in uses.items() if n == 1}


def test_a_regular_hole_gets_what_was_there(source: PatternSource) -> None:
    fills = list(fill_holes(source, HOLED, loop=[16], limit=5))
    assert len(fills) == 5 and fills[0].n_quads == 4 and fills[0].n_irregular == 0
    assert np.allclose(fills[0].points, [[3.0, 3.0, 0.0]]) and fills[0].flipped == 0
    for fill in fills:
        check_fill(fill)
        check_weld([fill])
    assert len({hash_of(fill) for fill in fills}) == 5


def hash_of(fill: HoleFill) -> bytes:
    n = len(fill.hole)
    twin, _ = weld_quads(fill.local, n + len(fill.points), n)
    return hash_quads(fill.local, twin, False)


def test_faces_are_made_anew_and_all_else_stays(source: PatternSource) -> None:
    mesh = grid(6)
    hole = hole_of_faces(MeshTopology.of(mesh), [14, 15, 20, 21, 26, 27])
    assert len(hole) == 10 and hole.removed.tolist() == [14, 15, 20, 21, 26, 27]
    fill = next(fill_holes(source, mesh, faces=[14, 15, 20, 21, 26, 27]))
    assert fill.n_quads == 6 and fill.n_irregular == 0
    new = check_weld([fill])
    assert new.n_faces == 36


def test_faces_at_the_border_and_all_faces(source: PatternSource) -> None:
    mesh = grid(3)
    for faces in ([0, 1], [0, 1, 2, 3, 4, 5, 6, 7, 8]):
        fill = next(fill_holes(source, mesh, faces=faces))
        check_fill(fill)
        assert fill.n_quads == len(faces) and fill.n_irregular == 0
        assert fill.weld().n_faces == 9


@settings(max_examples=25)
@given(st.data())
def test_any_disk_of_faces_is_filled(source: PatternSource, data: st.DataObject) -> None:
    topology = MeshTopology.of(read_mesh(HEAD))
    draw = st.integers(0, topology.mesh.n_faces - 1)
    faces = {data.draw(draw)}
    for _ in range(data.draw(st.integers(0, 12))):
        f = data.draw(st.sampled_from(sorted(faces)))
        at = int(topology.start[f]) + data.draw(st.integers(0, 3))
        if at < topology.start[f + 1] and topology.twin[at] >= 0:
            faces.add(int(topology.face[topology.twin[at]]))
    try:
        hole = hole_of_faces(topology, faces)
    except InvalidMeshError as error:
        assert "island" in str(error)
        return
    if len(hole) % 2:
        with pytest.raises(InvalidQueryError, match="odd"):
            fill_holes(source, hole)
        return
    fills = list(fill_holes(source, hole, limit=6))
    assert fills, "every even loop has a fill"
    for fill in fills:
        check_fill(fill)
        check_weld([fill])


def delete_faces(mesh: PolygonMesh, faces: set[int]) -> PolygonMesh:
    """The mesh without some faces; vertices keep their numbers."""
    kept = [list(face) for f, face in enumerate(mesh.faces()) if f not in faces]
    return PolygonMesh.from_faces(mesh.points, kept)


@settings(max_examples=15, deadline=None)
@given(st.data())
def test_selected_faces_and_the_hole_that_they_leave_are_one(
    source: PatternSource, data: st.DataObject
) -> None:
    # What is measured, and what is proposed, does not depend on the faces that are replaced.
    topology = MeshTopology.of(read_mesh(HEAD))
    first = data.draw(st.integers(0, topology.mesh.n_faces - 1))
    faces = {first}
    for _ in range(data.draw(st.integers(0, 20))):
        f = data.draw(st.sampled_from(sorted(faces)))
        at = int(topology.start[f]) + data.draw(st.integers(0, 3))
        if at < topology.start[f + 1] and topology.twin[at] >= 0:
            faces.add(int(topology.face[topology.twin[at]]))
    try:
        selected = hole_of_faces(topology, faces)
    except InvalidMeshError:
        return
    assume(len(selected) % 2 == 0 and (selected.edges >= 0).all())
    deleted = MeshTopology.of(delete_faces(topology.mesh, faces))
    left = [h for h in find_holes(deleted) if set(h.loop.tolist()) == set(selected.loop.tolist())]
    assume(len(left) == 1 and len(left[0]) == len(selected))
    (open_hole,) = left
    assert open_hole.loop.tolist() == selected.loop.tolist()
    one, two = extract_neighbourhood(selected), extract_neighbourhood(open_hole)
    for name in (
        "points",
        "regular_valence",
        "clamped_valence",
        "normals",
        "angle_outside",
        "spokes",
        "far_valence",
    ):
        assert np.array_equal(getattr(one, name), getattr(two, name), equal_nan=True), name
    assert np.array_equal(measure_hole(selected, one), measure_hole(open_hole, two))
    fills = [list(fill_holes(source, hole, limit=3)) for hole in (selected, open_hole)]
    assert [hash_of(fill) for fill in fills[0]] == [hash_of(fill) for fill in fills[1]]
    for a, b in zip(*fills, strict=True):
        assert a.score == b.score and np.array_equal(a.points, b.points)


def test_no_half_edge_leads_from_outside_into_removed_faces() -> None:
    topology = MeshTopology.of(grid(4))
    hole = hole_of_faces(topology, [5, 6, 9])
    removed = np.isin(topology.face, hole.removed)
    beyond = hole.outside.twin
    assert (removed[beyond[beyond >= 0]] == removed[beyond >= 0]).all()
    assert (beyond[hole.edges] == -1).all() and (topology.twin >= beyond).all()
    for border in find_holes(HOLED):
        assert border.outside is border.topology


@pytest.mark.parametrize("seed", [1])
def test_the_first_fill_has_no_flipped_quad_where_one_has_none(
    source: PatternSource, seed: int
) -> None:
    # Regions of the head, dented at random so that many fills fold over.
    mesh = read_mesh(HEAD)
    draw = random.Random(seed)
    shaken = np.random.default_rng(seed).normal(size=mesh.points.shape)
    edge = float(np.linalg.norm(mesh.points[mesh.corners[0]] - mesh.points[mesh.corners[1]]))
    dented = PolygonMesh(mesh.points + 0.8 * edge * shaken, mesh.corners, mesh.offsets)
    topology = MeshTopology.of(dented)
    asked = folded = 0
    while asked < 4:
        faces = {draw.randrange(mesh.n_faces)}
        for _ in range(2):
            near = {v for f in faces for v in topology.tail[topology.face == f].tolist()}
            faces |= set(topology.face[np.isin(topology.tail, list(near))].tolist())
        try:
            hole = hole_of_faces(topology, faces)
        except InvalidMeshError:
            continue
        if len(hole) % 2:
            continue
        fills = list(fill_holes(source, hole, limit=20, twins=False))
        asked += 1
        folded += any(fill.flipped for fill in fills)
        assert not fills[0].flipped or all(fill.flipped for fill in fills)
    assert folded


def bend_strip(profile: list[tuple[float, float]], n: int) -> PolygonMesh:
    """n rows of quads along a profile of points (x, z)."""
    m = len(profile)
    points = np.array([(x, float(y), z) for y in range(n + 1) for x, z in profile])
    faces = [
        [y * m + x, y * m + x + 1, (y + 1) * m + x + 1, (y + 1) * m + x]
        for y in range(n)
        for x in range(m - 1)
    ]
    return PolygonMesh.from_faces(points, faces)


def test_quads_around_a_thin_rim_are_not_flipped_and_those_folded_back_are(
    source: PatternSource,
) -> None:
    plate = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 0.02), (1.0, 0.02), (0.0, 0.02)]
    rim = hole_of_faces(MeshTopology.of(bend_strip(plate, 6)), [y * 5 + 2 for y in range(2, 4)])
    fill = next(fill_holes(source, rim, twins=False))
    assert fill.n_quads == 2 and fill.flipped == 0
    inner = find_holes(HOLED)[0]
    own = hole_of_faces(MeshTopology.of(grid(6)), [14, 15, 20, 21])
    assert (own.loop == inner.loop).all()
    fill = next(fill_holes(source, inner, twins=False))
    around = extract_neighbourhood(inner)
    assert fill.n_quads == 4 and count_flipped(around, fill.local, fill.points) == 0
    for off in ([2.5, 0.0, 0.0], [2.5, 2.5, 0.0], [-9.0, 0.0, 0.0]):
        assert count_flipped(around, fill.local, fill.points + off) > 0


def test_flipped_quads_are_mended(source: PatternSource) -> None:
    inner = find_holes(OPENED)[0]
    fill = next(fill_holes(source, inner, twins=False))
    around, points = extract_neighbourhood(inner), fill.points.copy()
    points[4] += [1.3, 1.2, 0.0]
    flipped = count_flipped(around, fill.local, points)
    assert flipped
    mended = mend_fill(around, fill.local, PlacedFill(points, np.zeros(0), flipped))
    assert mended.flipped == 0 and count_flipped(around, fill.local, mended.points) == 0
    assert mend_fill(around, fill.local, mended) is mended


def cube(n: int) -> PolygonMesh:
    """The faces of a cube, n x n quads each."""
    at: dict[tuple[int, ...], int] = {}
    faces: list[list[int]] = []
    for axis, end in product(range(3), (0, n)):
        for u, v in product(range(n), repeat=2):
            around = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)]
            if end == 0:
                around.reverse()
            places = [(end, *place) for place in around]
            turned = [place[-axis:] + place[:-axis] if axis else place for place in places]
            faces.append([at.setdefault(place, len(at)) for place in turned])
    return PolygonMesh.from_faces(np.array(list(at), np.float64), faces)


def test_what_the_mesh_joins_outside_no_fill_joins_within(source: PatternSource) -> None:
    # Little is left around large holes of a cube: their rims are joined by edges outside.
    topology = MeshTopology.of(cube(2))
    assert (topology.twin >= 0).all() and not topology.crowded.any()
    draw, bound, filled = random.Random(1), 0, 0
    for n in range(12, 22):
        for _ in range(6):
            try:
                hole = hole_of_faces(topology, draw.sample(range(24), n))
            except InvalidMeshError:
                continue
            if len(hole) % 2:
                continue
            bound += HoleRim.of(hole).bound
            fills = list(fill_holes(source, hole, limit=20))
            assert fills
            for fill in fills:
                check_fill(fill)
                check_weld([fill])
            filled += len(fills)
    assert bound > 5
    assert filled >= 150


@pytest.mark.parametrize("turned", [False, True])
def test_a_mirror_twin_comes_first(source: PatternSource, turned: bool) -> None:
    mesh = read_mesh(HEAD)
    topology = MeshTopology.of(mesh)
    points = topology.mesh.points
    middle = np.array([points[f].mean(axis=0) for f in topology.mesh.faces()])
    axis = int(np.argmin(np.abs(middle.mean(axis=0)) / np.ptp(points, axis=0)))
    side = np.flatnonzero(middle[:, axis] > 0.25 * np.ptp(points[:, axis]))
    seed = int(side[len(side) // 2])
    faces = {seed} | {
        int(topology.face[g])
        for h in range(int(topology.start[seed]), int(topology.start[seed + 1]))
        if (g := int(topology.twin[h])) >= 0
    }
    if turned:
        # Symmetric in a plane that is none of the axes' and goes not through the origin.
        axes = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
        points = points @ axes + [3.0, -2.0, 7.0]
        topology = MeshTopology.of(PolygonMesh(points, mesh.corners, mesh.offsets))
    fills = fill_holes(source, topology, faces=sorted(faces), limit=3)
    first = next(fills)
    assert first.twin and fills.twin and first.pattern == "twin"
    check_fill(first)
    # The other side's quads, mirrored, lie where the removed ones did.
    new = first.weld()
    placed = new.points[new.corners[-4 * first.n_quads :]].reshape(-1, 4, 3).mean(axis=1)
    removed = np.array([points[mesh.faces()[f]].mean(axis=0) for f in sorted(faces)])
    apart = np.linalg.norm(placed[:, None] - removed[None], axis=2)
    assert first.n_quads == len(faces) and apart.min(axis=1).max() < 1e-3
    assert not next(fill_holes(source, topology, faces=sorted(faces), twins=False)).twin


def dented_sheet(seed: int, uneven: float) -> PolygonMesh:
    """A sheet symmetric in x = 0 but for so much of an edge, with a hole on either side; the same
    faces and vertices are missing on both."""
    rng = np.random.default_rng(seed)
    n = 7
    x, y = np.meshgrid(np.arange(-n, n + 1.0), np.arange(n + 1.0), indexing="ij")
    a, b = rng.normal(size=2)
    z = np.sin(a * np.abs(x) / 3 + b) * np.cos(b * y / 3)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    points += rng.uniform(-uneven, uneven, points.shape) / np.sqrt(3)
    wide, high = (int(v) for v in rng.integers(1, 4, 2))
    gone = {(i, j) for i in range(2, 2 + wide) for j in range(2, 2 + high)}
    # A notch, so that the loop has no symmetry of its own.
    gone |= {(2, 2 + high)} if rng.random() < 0.5 and wide > 1 else set()
    faces = []
    for i, j in product(range(2 * n), range(n)):
        if ((i - n if i >= n else n - 1 - i), j) not in gone:
            v = i * (n + 1) + j
            faces.append([v, v + n + 1, v + n + 2, v + 1])
    return PolygonMesh.from_faces(points, faces)


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.sampled_from([0.0, 0.25]))
def test_mirrored_holes_get_the_same_fill(source: PatternSource, seed: int, uneven: float) -> None:
    mesh = dented_sheet(seed, uneven)
    topology = MeshTopology.of(mesh)
    holes = [hole for hole in find_holes(topology) if len(hole) < 30]
    assert len(holes) == 2
    # Where the sheet happens to be symmetric otherwise, too, that side shows what was there.
    assume(prepare_twins(topology).find(holes[1]) is None)
    # Placed anew, a fill that is none of the best may have flipped quads, and is not offered.
    rank = 0 if uneven else seed % 3
    chosen = list(islice(fill_holes(source, holes[0]), rank + 1))[-1]
    other = fill_holes(source, holes[1], like=[chosen], limit=3)
    fills = list(other)
    for fill in fills:
        check_fill(fill)
    first = fills[0]
    assert first.twin and first.n_quads == chosen.n_quads and not any(f.twin for f in fills[1:])
    assert first.n_irregular == chosen.n_irregular
    new = check_weld([chosen, first])
    assert new.n_faces == mesh.n_faces + 2 * chosen.n_quads
    # The mirror image of the whole is the whole: corners of faces by where they lie.
    if not uneven:
        image = new.points * [-1.0, 1.0, 1.0]
        apart = np.linalg.norm(new.points[:, None] - image[None], axis=2)
        at = apart.argmin(axis=0)
        assert apart.min(axis=0).max() < 1e-6
        faces = {frozenset(face) for face in new.faces()}
        assert {frozenset(at[list(face)].tolist()) for face in new.faces()} == faces
    plain = fill_holes(source, holes[1], like=[chosen], twins=False, limit=1)
    assert not next(plain).twin
    with pytest.raises(InvalidMeshError, match="another mesh"):
        fill_holes(source, HOLED, loop=[16], like=[chosen])


def test_holes_that_are_no_mirror_images_are_told_apart() -> None:
    mesh = grid(9, {(1, 1), (2, 1), (5, 5), (6, 5)})
    topology = MeshTopology.of(mesh)
    one, two = (hole for hole in find_holes(topology) if len(hole) < 30)
    finder = prepare_twins(topology)
    assert len(one) == len(two) and finder.match(one, two) is None
    assert finder.match(one, one) is None


def middle_faces(shift: int) -> tuple[PolygonMesh, MeshTopology, int, list[int]]:
    """The head, its axis of symmetry, and a patch across its plane, of which ``shift`` faces have
    been taken on one side."""
    mesh = read_mesh(HEAD)
    topology = MeshTopology.of(mesh)
    middle = np.array([mesh.points[f].mean(axis=0) for f in mesh.faces()])
    axis = int(np.argmin(np.abs(middle.mean(axis=0)) / np.ptp(mesh.points, axis=0)))
    near = np.argsort(np.abs(middle[:, axis]), kind="stable")
    height = middle[:, (axis + 1) % 3] + middle[:, (axis + 2) % 3]
    seed = int(near[:40][np.argmax(height[near[:40]])])
    vertex = next(v for v in mesh.faces()[seed] if abs(mesh.points[v, axis]) < 1e-6)
    faces = {f for f, corners in enumerate(mesh.faces()) if vertex in corners}
    faces |= {
        f
        for f, corners in enumerate(mesh.faces())
        if any(set(corners) & set(mesh.faces()[g]) for g in faces)
    }
    for f in sorted(faces, key=lambda f: -middle[f, axis])[:shift]:
        around = {
            int(topology.face[g])
            for h in range(int(topology.start[f]), int(topology.start[f + 1]))
            if (g := int(topology.twin[h])) >= 0
        }
        faces |= {g for g in around if middle[g, axis] > 0}
    return mesh, topology, axis, sorted(faces)


def test_fills_across_the_plane_of_symmetry_follow_it(source: PatternSource) -> None:
    _, topology, _, faces = middle_faces(0)
    hole = hole_of_faces(topology, faces)
    around = extract_neighbourhood(hole)
    mirrors = find_mirrors(hole.points, around.regular_valence)
    assert len(mirrors) == 1
    fills = list(fill_holes(source, hole, limit=5))
    assert count_followed(
        fills[0].local, len(hole) + len(fills[0].points), len(hole), hash_of(fills[0]), mirrors
    )


def test_what_the_other_side_shows_of_a_hole_is_mirrored(source: PatternSource) -> None:
    mesh, topology, axis, faces = middle_faces(3)
    hole = hole_of_faces(topology, faces)
    assert not len(find_mirrors(hole.points, extract_neighbourhood(hole).regular_valence))
    found = prepare_twins(topology).find_part(hole)
    assert found is not None
    quads, points = found
    rest = find_rest(quads, len(hole))
    assert rest is not None and 0 < len(quads) < len(faces)
    # Every quad lies where an old one was, and the loop left is its own mirror image.
    places = np.vstack([hole.points, points])
    old = np.array([mesh.points[mesh.faces()[f]].mean(axis=0) for f in faces])
    apart = np.linalg.norm(places[quads].mean(axis=1)[:, None] - old[None], axis=2)
    assert apart.min(axis=1).max() < 1e-6
    left = places[rest]
    image = left * np.where(np.arange(3) == axis, -1.0, 1.0)
    assert np.linalg.norm(image[:, None] - left[None], axis=2).min(axis=1).max() < 1e-6
    fills = list(fill_holes(source, hole, limit=8))
    assert all(a.score >= b.score for a, b in pairwise(fills))
    for fill in fills:
        check_fill(fill)
        check_weld([fill])
    for fill in fills[:2]:
        everything = np.vstack([hole.points, fill.points])[fill.local].mean(axis=1)
        apart = np.linalg.norm(places[quads].mean(axis=1)[:, None] - everything[None], axis=2)
        assert apart.min(axis=1).max() < 1e-9


@given(st.integers(3, 12), st.integers(0, 40), st.integers(0, 1_000))
def test_mirrors_of_loops(half: int, turn: int, seed: int) -> None:
    draw = np.random.default_rng(seed)
    one = draw.normal(size=(half, 3)) * 3
    one[:, 0] = np.abs(one[:, 0]) + 0.5
    points = np.vstack([one, one[::-1] * [-1, 1, 1]])
    due = draw.integers(1, 4, size=half).astype(np.int32)
    counts = np.concatenate([due, due[::-1]])
    n = 2 * half
    points = np.roll(points, turn, axis=0) @ np.linalg.qr(draw.normal(size=(3, 3)))[0]
    counts = np.roll(counts, turn)
    mirrors = find_mirrors(points, counts)
    assert (n - 1 + 2 * turn) % n in mirrors.tolist()
    assert follow_mirrors(counts[None], mirrors).all()
    # A loop bent on one side has none any more, nor do other counts follow those that it had.
    bent = points.copy()
    bent[turn % n] += 40.0 * draw.normal(size=3)
    assert (n - 1 + 2 * turn) % n not in find_mirrors(bent, counts).tolist()
    counts[turn % n] += 1
    s = np.array([(n - 1 + 2 * turn) % n], np.int32)
    assert not follow_mirrors(counts[None], s).any()


def test_corners_may_be_fixed(source: PatternSource) -> None:
    inner = find_holes(HOLED)[0]
    at = int(inner.loop[1])
    for quads in (1, 2, 3):
        fill = next(fill_holes(source, inner, corners={at: quads}))
        assert fill.corners[1] == quads
    with pytest.raises(InvalidQueryError, match="not on the loop"):
        fill_holes(source, inner, corners={0: 1})
    with pytest.raises(InvalidQueryError, match="1 to 4"):
        fill_holes(source, inner, corners={at: 5})


def test_strokes_are_followed(source: PatternSource) -> None:
    inner = find_holes(HOLED)[0]
    for start, end in ((0, 5), (1, 4)):
        stroke = Stroke((0, start), (0, end))
        fill = next(fill_holes(source, inner, strokes=[stroke], tolerance=0))
        check_fill(fill)
        assert end in follow_strand(fill, start)


def test_strands_are_pulled_onto_drawn_strokes(source: PatternSource) -> None:
    (inner,) = (h for h in find_holes(OPENED) if len(h) == 20)
    middle = (inner.points + np.roll(inner.points, -1, axis=0)) / 2
    # From the middle of the left side to that of the right, high in between.
    left, right = ((np.abs(middle - at)).sum(axis=1).argmin() for at in ([2, 4.5, 0], [7, 4.5, 0]))
    x = np.linspace(2.0, 7.0, 21)
    line = np.column_stack([x, 4.5 + 0.9 * np.sin((x - 2.0) / 5.0 * np.pi), np.zeros(21)])
    drawn = Stroke.drawn(Boundary.closed(20, inner.points), line)
    assert {drawn.start, drawn.end} == {(0, int(left)), (0, int(right))}
    distances = []
    for stroke in (Stroke(drawn.start, drawn.end), drawn):
        fill = next(fill_holes(source, inner, strokes=[stroke], tolerance=0))
        check_fill(fill)
        assert fill.flipped == 0
        disk = LoopDisk(fill.local, 20 + len(fill.points), 20)
        vertices = np.vstack([inner.points, fill.points])
        distances.append(measure_flow_distance(disk, vertices, [drawn], 0))
    assert distances[1] < 0.2 * distances[0]


@pytest.mark.parametrize("turned", [False, True])
def test_fills_rest_on_a_surface(source: PatternSource, turned: bool) -> None:
    # A bump that the flat surroundings tell nothing of.
    x, y = np.meshgrid(np.linspace(-1, 10, 67), np.linspace(-1, 10, 67))
    z = 1.5 * np.exp(-((x - 4.5) ** 2 + (y - 4.5) ** 2))
    corner = np.arange(66 * 67).reshape(66, 67)[:, :-1].ravel()
    lower = np.column_stack([corner, corner + 1, corner + 68])
    triangles = np.vstack([lower, np.column_stack([corner, corner + 68, corner + 67])])
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    surface = Surface.from_arrays(points, triangles[:, ::-1] if turned else triangles)
    (hole,) = (h for h in find_holes(OPENED) if len(h) == 20)
    for fill in fill_holes(source, hole, surface=surface, limit=4):
        check_fill(fill)
        assert np.allclose(surface.nearest(fill.points).points, fill.points, atol=1e-9)
        assert fill.flipped == 0
        assert fill.points[:, 2].max() > 0.5


def follow_strand(fill: HoleFill, edge: int) -> list[int]:
    """The loop edges at which the strand through a loop edge ends."""
    n = len(fill.hole)
    half = {
        (int(q[k]), int(q[(k + 1) % 4])): (i, k) for i, q in enumerate(fill.local) for k in range(4)
    }
    at = half[edge, (edge + 1) % n]
    while True:
        i, k = at
        k = (k + 2) % 4
        a, b = int(fill.local[i][k]), int(fill.local[i][(k + 1) % 4])
        if (b, a) not in half:
            return [a if (a + 1) % n == b else -1]
        at = half[b, a]


def test_all_holes_are_welded_together(source: PatternSource) -> None:
    mesh = grid(9, {(1, 1), (2, 1), (5, 5), (6, 5), (6, 6)})
    holes = [hole for hole in find_holes(mesh) if len(hole) < 30]
    assert [len(hole) for hole in holes] == [6, 8]
    fills = [next(fill_holes(source, hole)) for hole in holes]
    new = check_weld(fills)
    assert new.n_faces == 81
    with pytest.raises(InvalidMeshError, match="different meshes"):
        weld_fills([fills[0], next(fill_holes(source, HOLED, loop=[16]))])


def test_what_is_refused(source: PatternSource) -> None:
    with pytest.raises(InvalidMeshError, match="2 border loops"):
        fill_holes(source, HOLED)
    with pytest.raises(InvalidMeshError, match="no border loop"):
        hole_of_loop(MeshTopology.of(HOLED), [0, 16])
    with pytest.raises(InvalidMeshError, match="not in the mesh"):
        hole_of_loop(MeshTopology.of(HOLED), [1000])
    with pytest.raises(InvalidMeshError, match="not in the mesh"):
        hole_of_faces(MeshTopology.of(HOLED), [-1])
    with pytest.raises(InvalidMeshError, match="separate pieces"):
        hole_of_faces(MeshTopology.of(HOLED), [0, 20])
    ring = [6, 7, 8, 11, 13, 16, 17, 18]
    with pytest.raises(InvalidMeshError, match="island"):
        hole_of_faces(MeshTopology.of(grid(5)), ring)
    island = grid(9, {(x, y) for x in range(2, 7) for y in range(2, 7)} - {(4, 4)})
    wide = next(hole for hole in find_holes(island) if len(hole) == 20)
    with pytest.raises(InvalidMeshError, match="island within"):
        fill_holes(source, island, loop=wide.loop.tolist())
    cube = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    closed = PolygonMesh.from_faces(np.array(list(product((0.0, 1.0), repeat=3))), cube)
    with pytest.raises(InvalidMeshError, match="closed"):
        fill_holes(source, closed)
    strip = [[2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2] for i in range(4)] + [[8, 9, 0, 1]]
    twisted = PolygonMesh.from_faces(np.random.default_rng(1).normal(size=(10, 3)), strip)
    with pytest.raises(InvalidMeshError, match="one-sided"):
        find_holes(twisted)


def test_faces_turned_backwards_are_read_alike(source: PatternSource) -> None:
    faces = [list(face) for face in HOLED.faces()]
    mixed = [face[::-1] if i % 3 == 0 else face for i, face in enumerate(faces)]
    mesh = PolygonMesh.from_faces(HOLED.points, mixed)
    fill = next(fill_holes(source, mesh, loop=[16]))
    assert fill.n_quads == 4 and fill.n_irregular == 0
    new = fill.weld()
    assert [list(face) for face in islice(new.faces(), len(mixed))] == mixed


def test_assignments_come_in_order_and_none_is_left_out() -> None:
    logs = np.log(np.random.default_rng(3).dirichlet(np.ones(4), size=4))
    listed = list(list_assignments(logs))
    expected = sorted(
        (sum(logs[i, k - 1] for i, k in enumerate(one)) for one in product(range(1, 5), repeat=4)),
        reverse=True,
    )
    assert np.allclose([log for log, _ in listed], expected)
    assert len({tuple(one.tolist()) for _, one in listed}) == 4**4
    for log, one in listed:
        assert np.isclose(log, logs[np.arange(4), one - 1].sum())


def add_up_leaves(model: TreeModel, row: NDArray[np.float64]) -> NDArray[np.float64]:
    """The scores of one row, tree by tree."""
    scores = model.base.copy()
    for t, first in enumerate(model.start[:-1].tolist()):
        at = first
        while model.feature[at] >= 0:
            above = row[model.feature[at]] > model.threshold[at]
            at = first + int(model.child[at]) + int(above)
        scores[t % len(scores)] += model.value[at]
    return scores


def test_trees_are_walked_as_in_plain_python() -> None:
    model = shipped_models().corners
    features = np.random.default_rng(5).normal(size=(7, N_HOLE_FEATURES)) * 3
    logs = model.log_probabilities(features)
    for row, log in zip(features, logs, strict=True):
        scores = add_up_leaves(model, row)
        chance = np.exp(scores - scores.max())
        assert np.allclose(np.exp(log), np.maximum(chance / chance.sum(), np.exp(-12.0)))


@given(st.integers(1, 9), st.integers(0, 2**32))
def test_candidates_are_ranked_against_each_other(n: int, seed: int) -> None:
    model = shipped_models().whole
    rng = np.random.default_rng(seed)
    numbers = rng.normal(model.linear.mean, model.linear.spread, size=(n, len(NAMES)))
    # As the model clips what is out of range.
    numbers = tame_numbers(numbers)
    found = model.score(numbers)
    least, greatest = numbers.min(axis=0), numbers.max(axis=0)
    for row, score in zip(numbers, found.tolist(), strict=True):
        compared = np.concatenate([row, row - least, row - greatest])
        scaled = (row - model.linear.mean) / model.linear.spread
        expected = scaled @ model.linear.weights + add_up_leaves(model.trees, compared)[0]
        assert np.isclose(score, expected)
    order = rng.permutation(n)
    assert np.allclose(model.score(numbers[order]), found[order])


def test_triangles_and_larger_faces_around(source: PatternSource, tmp_path: Path) -> None:
    faces = [list(face) for face in HOLED.faces()]
    a, b, c, d = faces[7]
    faces[7:8] = [[a, b, c], [a, c, d]]
    mesh = PolygonMesh.from_faces(HOLED.points, faces)
    fill = next(fill_holes(source, mesh, loop=[16]))
    check_fill(fill)
    check_weld([fill])


def turn_loop(mesh: PolygonMesh) -> PolygonMesh:
    """The mirror image of a mesh, its faces turned over."""
    faces = [list(face)[::-1] for face in mesh.faces()]
    return PolygonMesh.from_faces(mesh.points * [-1.0, 1.0, 1.0], faces)


def test_numbers_of_a_mirror_image_are_the_mirrored_numbers() -> None:
    mesh = read_mesh(HEAD)
    faces = [40, 41, 42, 100]
    for chosen in ([f] for f in faces):
        hole = hole_of_faces(MeshTopology.of(mesh), chosen)
        other = hole_of_faces(MeshTopology.of(turn_loop(mesh)), chosen)
        place = {int(v): i for i, v in enumerate(other.loop)}
        order = [place[int(v)] for v in hole.loop]
        own = measure_loop(hole, extract_neighbourhood(hole))
        mirrored = measure_loop(other, extract_neighbourhood(other))[order]
        assert np.allclose(mirror_features(own), mirrored, atol=1e-9)
        own = measure_hole(hole, extract_neighbourhood(hole))
        assert own.shape == (len(hole), N_HOLE_FEATURES) and np.isfinite(own).all()
        mirrored = measure_hole(other, extract_neighbourhood(other))[order]
        assert np.allclose(mirror_hole(own), mirrored, atol=1e-9)


@given(st.data())
def test_traits_of_assignments_as_in_plain_python(data: st.DataObject) -> None:
    n = data.draw(st.integers(3, 14))
    quads = st.lists(st.integers(1, 4), min_size=n, max_size=n)
    due, assigned = data.draw(quads), data.draw(quads)
    logs = np.log(np.random.default_rng(n).dirichlet(np.ones(4), size=n))
    arrays = np.array(due, np.int32), np.array([assigned], np.int32)
    (row,) = measure_assignments(logs, *arrays)
    found = dict(zip(TRAITS, row.tolist(), strict=True))
    off = [k - d for k, d in zip(assigned, due, strict=True)]
    turns = sum(2 - k for k in assigned)
    corners = [i for i, k in enumerate(assigned) if k != 2]
    around = [(assigned[i - 1], assigned[i], off[i - 1], off[i]) for i in range(n)]
    lengths = [(b - a) % n for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    best = logs.max(axis=1).sum()
    expected = {
        "log_corners": sum(logs[i, k - 1] for i, k in enumerate(assigned)) - best,
        "turns_by_four": turns == 4,
        "turns_off": abs(turns - 4),
        "turns_off_squared": (turns - 4) ** 2 / 10,
        "turns_more": turns > 4,
        "turns_even": turns % 2 == 0,
        "irregular": sum(o != 0 for o in off),
        "valence_2": sum(o <= -2 for o in off),
        "valence_3": off.count(-1),
        "valence_5": off.count(1),
        "valence_6": sum(o >= 2 for o in off),
        "all_regular": not any(off),
        "convex": assigned.count(1),
        "reflex": assigned.count(3),
        "full": assigned.count(4),
        "irregular_pairs": sum(x != 0 and y != 0 for _, _, x, y in around),
        "dipoles": sum(x * y < 0 for _, _, x, y in around),
        "corner_pairs": sum(a != 2 and b != 2 for a, b, _, _ in around),
        "convex_pairs": sum(a == 1 and b == 1 for a, b, _, _ in around),
        "rectangle": len(corners) == 4 and turns == 4 and lengths[:2] == lengths[2:],
        "four_sides": len(corners) == 4 and turns == 4,
        "closed_side": not corners,
    }
    assert set(expected) == set(TRAITS)
    for name, value in expected.items():
        assert np.isclose(found[name], float(value)), name


def odd_grid() -> PolygonMesh:
    """A grid with a hole of nine edges: half of a quad beside it is gone, too."""
    faces = [list(face) for face in HOLED.faces()]
    at = next(i for i, face in enumerate(faces) if face[0] == 9)
    faces[at] = faces[at][:3]
    return PolygonMesh.from_faces(HOLED.points, faces)


@pytest.mark.parametrize("kind", ["triangle", "edge-loop", "split", "merge"])
def test_odd_loops_have_ways_out(source: PatternSource, kind: str) -> None:
    mesh = odd_grid()
    hole = find_holes(mesh)[0]
    assert len(hole) == 9
    with pytest.raises(
        InvalidQueryError, match=r"odd number.*triangle:.*edge-loop:.*split:.*merge:"
    ):
        fill_holes(source, hole)
    ways = [fix for fix in list_parity_fixes(hole, 50) if fix.kind == kind]
    assert ways and [way.cost for way in ways] == sorted(way.cost for way in ways)
    for way in ways:
        even = way.apply()
        new = even.topology.mesh
        assert len(even) in (8, 10) and not even.topology.crowded.any()
        assert new.points[: len(mesh.points)].tobytes() == mesh.points.tobytes()
        changed = [
            i
            for i, (a, b) in enumerate(zip(mesh.faces(), new.faces(), strict=False))
            if list(a) != list(b)
        ]
        assert changed == list(way.changes)
        assert sorted(len(h) for h in find_holes(even.topology))[0] == len(even)
        fill = next(fill_holes(source, even))
        check_fill(fill)
        welded = check_weld([fill])
        triangles = int((welded.arities() != 4).sum())
        assert triangles <= int((mesh.arities() != 4).sum()) + 1
    best = ways[0]
    if kind == "split":
        assert "becomes a quad" in best.description  # the triangle outside is mended by it
    if kind == "edge-loop":
        assert "border edge" in best.description


def test_an_odd_selection_of_faces_has_ways_out(source: PatternSource) -> None:
    mesh = odd_grid()
    triangle = next(i for i, face in enumerate(mesh.faces()) if len(face) == 3)
    topology = MeshTopology.of(mesh)
    outside = int(topology.face[topology.twin[topology.start[triangle]]])
    hole = hole_of_faces(topology, [triangle, outside])
    assert len(hole) == 5
    for way in list_parity_fixes(hole, 3):
        even = way.apply()
        assert not len(even.removed) and even.topology.mesh.n_faces >= mesh.n_faces - 2
        check_weld([next(fill_holes(source, even))])
    assert list_parity_fixes(find_holes(HOLED)[0]) == []


CUBE = (
    [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)],
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
)


def grid_with_hole(n: int = 6) -> PolygonMesh:
    """A flat grid of n by n quads without the four in its middle."""
    points = [[float(x), float(y), 0.0] for y in range(n + 1) for x in range(n + 1)]
    middle = {n // 2 - 1, n // 2}
    at = [(x, y) for y in range(n) for x in range(n) if not {x, y} <= middle]
    faces = [[x + (n + 1) * y, x + 1 + (n + 1) * y] for x, y in at]
    return PolygonMesh.from_faces(points, [[a, b, b + n + 1, a + n + 1] for a, b in faces])


def test_a_closed_mesh_is_named_as_such() -> None:
    cube = PolygonMesh.from_faces(*CUBE)
    assert find_holes(cube) == []
    (note,) = list_mesh_flaws(cube)
    assert "the mesh is closed" in note
    for loop in (None, 1, [1]):
        with pytest.raises(InvalidMeshError, match="the mesh is closed"):
            choose_hole(cube, loop=loop)


def test_one_vertex_names_a_loop() -> None:
    grid = grid_with_hole()
    inner, outer = find_holes(grid)
    for hole in (inner, outer):
        for vertex in (int(hole.loop[2]), hole.loop[2], [int(hole.loop[2])]):
            found = choose_hole(grid, loop=vertex)
            assert set(found.loop.tolist()) == set(hole.loop.tolist())
            assert found.loop[0] == hole.loop[2]
    with pytest.raises(InvalidMeshError, match="no border loop runs through vertex 8"):
        choose_hole(grid, loop=8)


def test_edges_of_more_than_two_faces_are_named() -> None:
    points, faces = CUBE
    fin = PolygonMesh.from_faces([*points, [0, 0, 2.0], [0, 1, 2.0]], [*faces, [1, 3, 9, 8]])
    for ask in (find_holes, choose_hole):
        with pytest.raises(InvalidMeshError, match=r"1 edge has more .* 1-3 \(3 faces, such as"):
            ask(fin)
    (note,) = list_mesh_flaws(fin)
    assert "vertices 1-3 (3 faces" in note
    # Loops away from such an edge are found all the same, and the edge is named.
    grid = grid_with_hole()
    both = PolygonMesh.from_faces(
        [*grid.points.tolist(), *(fin.points + 20.0).tolist()],
        [*grid.faces(), *([v + 49 for v in face] for face in fin.faces())],
    )
    assert [len(hole) for hole in find_holes(both)] == [8, 24]
    (note,) = list_mesh_flaws(both)
    assert "vertices 50-52 (3 faces" in note
    with pytest.raises(InvalidMeshError, match=r"runs through vertex 57; .* 50-52"):
        choose_hole(both, loop=[57])
    # Two closed parts that share an edge: no border, and four faces at the edge.
    other = [[v if v in (6, 7) else v + 8 for v in face] for face in faces]
    shared = PolygonMesh.from_faces([*points, *(np.array(points) + 1.0).tolist()], faces + other)
    (note,) = list_mesh_flaws(shared)
    assert "no border" in note and "6-7 (4 faces" in note and "closed" not in note


def test_faces_that_are_turned_against_others_are_reported(source: PatternSource) -> None:
    grid = grid_with_hole()
    assert list_mesh_flaws(grid) == ()
    (hole,) = [hole for hole in find_holes(grid) if len(hole) == 8]
    beside = int(hole.topology.face[hole.edges[0]])
    for turned in ([beside], list(range(12))):
        faces = [face[::-1] if k in turned else face for k, face in enumerate(grid.faces())]
        mesh = PolygonMesh.from_faces(grid.points, faces)
        (note,) = list_mesh_flaws(mesh)
        assert note.startswith(f"{len(turned)} face") and f"such as face {turned[0]};" in note
        hole = choose_hole(mesh, loop=[int(v) for v in hole.loop])
        fill = next(fill_holes(source, hole, limit=1))
        new = fill.weld().points[fill.weld().corners[-4 * fill.n_quads :].reshape(-1, 4)]
        normals = np.cross(new[:, 2] - new[:, 0], new[:, 3] - new[:, 1])
        assert (normals[:, 2] > 0).all()  # as most faces beside the hole are


@pytest.mark.parametrize("gap", [0.0, 1e-3, 0.04])
def test_border_edges_that_lie_on_each_other_are_reported(gap: float) -> None:
    grid = grid_with_hole()
    half = len(grid.points)
    other = grid.points * [-1.0, 1.0, 1.0] - [gap, 0.0, 0.0]
    faces = [*grid.faces(), *([v + half for v in face[::-1]] for face in grid.faces())]
    mesh = PolygonMesh.from_faces(np.concatenate([grid.points, other]), faces)
    (note,) = list_mesh_flaws(mesh)
    assert note.startswith("12 of 64 border edges lie on another one")
    if gap:
        assert f"up to {gap:g} away" in note
    apart = PolygonMesh.from_faces(np.concatenate([grid.points, other - [0.1, 0, 0]]), faces)
    assert list_mesh_flaws(apart) == ()


@pytest.mark.parametrize("corners", [3, 4])
def test_a_soup_is_refused_as_such(corners: int) -> None:
    grid = grid_with_hole()
    faces = [face[:corners] for face in grid.faces()]
    if corners == 3:
        faces += [[face[0], face[2], face[3]] for face in grid.faces()]
    soup = grid.points[np.array(faces)].reshape(-1, 3)
    mesh = PolygonMesh.from_faces(soup, np.arange(len(soup)).reshape(-1, corners))
    for ask in (find_holes, choose_hole):
        with pytest.raises(InvalidMeshError, match=f"a soup: most of its {len(faces)} faces"):
            ask(mesh)
    # Separate faces that lie nowhere on each other are what they are.
    far = soup.reshape(-1, corners, 3)
    far = far + 5.0 * far.mean(axis=1, keepdims=True)
    assert len(find_holes(PolygonMesh.from_faces(far.reshape(-1, 3), mesh.faces()))) == len(faces)
