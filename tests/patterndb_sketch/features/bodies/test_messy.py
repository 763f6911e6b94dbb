"""Messy car-like bodies: every fault does what it says, and all keep the outside."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import EXTERIOR, INTERIOR, SURFACE, degrade
from bodies.clutter import exterior_parts, interior_parts
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from tests.support.features.bodies import NAMES, made, near, sagitta, winding


def test_without_faults_the_patches_are_the_clean_body() -> None:
    half = made("hatchback")
    mess = degrade(half, mirror=False)
    assert len(mess.triangles) == len(half.triangles)
    assert mess.parts.max() + 1 == len(half.patch_names)
    mine = np.sort(mess.points[mess.triangles].mean(axis=1), axis=0)
    clean = np.sort(half.points[half.triangles].mean(axis=1), axis=0)
    assert np.allclose(mine, clean, atol=1e-5)
    # No two patches share vertices.
    owners = np.full(len(mess.points), -1)
    for part in range(mess.parts.max() + 1):
        mine = np.unique(mess.triangles[mess.parts == part])
        assert (owners[mine] == -1).all()
        owners[mine] = part


def test_patches_meshed_on_their_own_do_not_meet_along_borders() -> None:
    half = made("hatchback")
    mess = degrade(half, 3, uneven=True, mirror=False)
    assert near(half, mess.points).max() < sagitta(half)
    vertices = [np.unique(mess.triangles[mess.parts == p]) for p in range(mess.parts.max() + 1)]
    tree = KDTree(mess.points)
    shared = sum(len(one) > 1 for one in tree.query_ball_point(mess.points, 1e-6))
    rail = half.feature("roof_rail").smooth
    along = KDTree(rail).query(mess.points)[0] < 0.01
    glass, roof = (half.patch_names.index(name) for name in ("glass", "roof"))
    counts = [int(along[vertices[part]].sum()) for part in (glass, roof)]
    assert counts[0] != counts[1] and min(counts) > 3
    assert shared < 0.1 * len(mess.points)


def test_gaps_end_patches_short_of_their_borders() -> None:
    half = made("wagon")
    mess = degrade(half, 1, gaps=0.004, mirror=False)
    gap = 0.004 * half.diagonal / 2.0
    lines = np.concatenate([
        one.points for one in half.features if one.kind not in ("hidden", "profile", "seam")
    ])  # fmt: skip
    apart = KDTree(lines).query(mess.points)[0]
    assert apart.min() > 0.15 * gap
    assert near(half, mess.points).max() < sagitta(half) and mess.reach == 0.0
    area = _area(mess.points, mess.triangles)
    clean_area = _area(half.points, half.triangles)
    assert 0.85 * clean_area < area < 0.995 * clean_area


def test_crossings_reach_beyond_borders_by_no_more_than_told() -> None:
    half = made("wagon")
    mess = degrade(half, 1, crossings=0.006, mirror=False)
    apart = near(half, mess.points)
    assert apart.max() <= mess.reach + 1e-9
    assert apart.max() > 0.3 * 0.006 * half.diagonal
    assert _area(mess.points, mess.triangles) > 1.01 * _area(half.points, half.triangles)


def test_flips_turn_whole_patches() -> None:
    half = made("sedan")
    plain, turned = degrade(half, 4, mirror=False), degrade(half, 4, flips=0.5, mirror=False)
    assert not plain.flipped.any() and 0.2 < turned.flipped.mean() < 0.8
    flipped = turned.flipped[turned.parts]
    assert np.array_equal(turned.triangles[~flipped], plain.triangles[~flipped])
    assert np.array_equal(turned.triangles[flipped], plain.triangles[flipped][:, ::-1])
    assert degrade(half, 4, flips=1.0, mirror=False).flipped.all()


def test_cuts_make_more_patches_of_the_same_triangles() -> None:
    half = made("sedan")
    plain, cut = degrade(half, 2, mirror=False), degrade(half, 2, cuts=4, mirror=False)
    assert cut.parts.max() > 1.5 * plain.parts.max()
    mine, other = (np.sort(one.points[one.triangles].mean(axis=1), axis=0) for one in (plain, cut))
    assert np.allclose(mine, other, atol=1e-12)


def test_shuffled_triangles_are_the_same_soup() -> None:
    half = made("sedan")
    plain, soup = (degrade(half, 2, mirror=False, shuffle=on) for on in (False, True))
    assert np.array_equal(np.sort(soup.triangles.ravel()), np.arange(3 * len(soup.triangles)))
    keys = [
        sorted(tuple(map(tuple, sorted(t))) for t in one.points[one.triangles].tolist())
        for one in (plain, soup)
    ]
    assert keys[0] == keys[1]
    assert not np.array_equal(plain.parts, soup.parts)


def test_a_mirrored_mess_has_both_halves() -> None:
    half = made("sedan")
    one, both = degrade(half, 2, mirror=False), degrade(half, 2)
    assert len(both.triangles) == 2 * len(one.triangles)
    assert np.allclose(np.sort(both.points[:, 1]), np.sort(-both.points[:, 1]))
    a, b, c = (both.points[both.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    whole = made("sedan", True)
    a, b, c = (whole.points[whole.triangles[:, k]] for k in range(3))
    assert np.isclose(volume, np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)
    assert one.points[:, 1].max() == 0.0 < both.points[:, 1].max()


@pytest.mark.parametrize("name", NAMES)
def test_interior_clutter_is_inside_and_exterior_clutter_reaches_out(name: str) -> None:
    whole = made(name, True)
    inner = np.unique(np.concatenate([points for points, _ in interior_parts(whole)]), axis=0)
    chosen = np.random.default_rng(0).permutation(len(inner))[:25]
    boxes = inner[np.isin(np.round(inner[:, 1], 9), np.round(inner[chosen, 1], 9))][:25]
    assert winding(whole, np.r_[inner[chosen], boxes]).min() > 0.99
    outer = np.concatenate([points for points, _ in exterior_parts(whole)])
    assert near(whole, outer).max() > 0.1
    if name != "sedan":
        return
    plain = degrade(whole)
    for options, kind, points in (
        ({"interior": True}, INTERIOR, inner), ({"exterior": True}, EXTERIOR, outer)
    ):  # fmt: skip
        mess = degrade(whole, **options)
        assert set(np.unique(mess.kinds)) == {SURFACE, kind}
        assert np.array_equal(mess.triangles[mess.kinds == SURFACE], plain.triangles)
        clutter = mess.points[np.unique(mess.triangles[mess.kinds == kind])]
        both = np.r_[points, points * [1.0, -1.0, 1.0]]
        assert KDTree(both).query(clutter)[0].max() == 0.0


def test_everything_at_once_keeps_the_outside() -> None:
    whole = made("van", True)
    mess = degrade(
        whole, 7, uneven=True, cuts=3, gaps=0.002, crossings=0.004, flips=0.4, interior=True,
        exterior=True, shuffle=True,
    )  # fmt: skip
    skin = mess.triangles[mess.kinds == SURFACE]
    used = np.unique(mess.points[skin].reshape(-1, 3), axis=0)
    assert near(whole, used).max() < mess.reach + sagitta(whole)
    # Nowhere is more than the gaps and an edge missing.
    covered = Surface.from_arrays(mess.points, skin)
    missing = np.linalg.norm(covered.nearest(whole.points).points - whole.points, axis=1)
    assert missing.max() < 2.0 * 0.002 * whole.diagonal + sagitta(whole)
    assert 100 <= mess.parts.max() + 1 <= 300
    again = degrade(
        whole, 7, uneven=True, cuts=3, gaps=0.002, crossings=0.004, flips=0.4, interior=True,
        exterior=True, shuffle=True,
    )  # fmt: skip
    assert np.array_equal(mess.points, again.points)


def _area(points: Points, triangles: NDArray[np.int64]) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
