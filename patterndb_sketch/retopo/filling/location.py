"""Find which patch a point of the surface is in, and which patches lie within others.

A patch is the loop around it, whatever else is drawn in there. Where parts of the network lie
within it, joined to none of its sides (islands), its quads would lie over those of the patches
there; so it has none until a curve joins both, and makes other loops of them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.placing import PlacedPatch, is_as_given
from patterndb_sketch.retopo.network import FACE, Network, trace_outline
from patterndb_sketch.retopo.network.faces import SurfaceParts, find_joined_chains
from query.placing import enclose_region
from query.placing.region import measure_left

#: A point no further to the right of a patch's border, as a part of the surface's diagonal, is on
#: it, and so within: rounding alone moves points by less.
ON_BORDER = 1e-9


def find_patch(network: Network, surface: Surface, point: ArrayLike) -> int:
    """The patch that a point (3,) of the surface is in.

    Patches are tried in the order of how near their borders are; the surface within each is
    flooded until one has the point's triangle. On a triangle that the border crosses, or that is
    larger than the patch, the point is within if it is on the left of the nearest part of the
    border. Raises RefusedError if
    there is none.
    """
    foot = surface.nearest(np.asarray(point, np.float64)[None])
    borders = {patch.id: trace_outline(network, patch.loop) for patch in network.patches.values()}
    away = [
        (float(np.linalg.norm(points - foot.points[0], axis=1).min()), patch)
        for patch, (points, _) in borders.items()
    ]
    for _, patch in sorted(away):
        if is_within(surface, borders[patch], foot):
            return patch
    raise RefusedError("there is no patch here; point into one")


def is_within(surface: Surface, border: tuple[Points, Points], foot: SurfacePoints) -> bool:
    """Is a place, one foot, within a patch: on the surface to the left of its border?

    border: (n, 3) points and (n, 3) normals, the first not repeated. What is on it is within.
    """
    points, normals = border
    inside = enclose_region(surface, points)
    if not inside.separates:
        return False
    triangle = surface.triangles[foot.triangles[0]]
    own = (inside.surface.triangles == triangle).all(axis=1)
    if not own.any():
        return False
    # Flooding tells triangles apart, which is nothing where one is larger than the patch.
    size = np.linalg.norm(np.ptp(surface.vertices[triangle], axis=0))
    coarse = np.linalg.norm(np.ptp(points, axis=0)) < size
    if not coarse and np.isnan(inside.around[own]).all():
        return True
    left = measure_left(points, normals, foot.points[0], foot.normals[0])
    return left >= -ON_BORDER * surface.diagonal


def find_islands(
    network: Network, surface: Surface, placed: Mapping[int, PlacedPatch]
) -> dict[int, int | None]:
    """Placed patches within which others lie, of other parts of the network: for each one of
    those, or None where it is a face that was given. Curves without either are no islands: they
    may be about to be joined. Nor are patches and faces of a mesh that was given, within others as
    they were given: it may lie over itself."""
    part: dict[int, int] = {}
    for chain in sorted(network.chains):
        if chain not in part:
            part.update(
                dict.fromkeys(find_joined_chains(network.nodes, network.chains, chain), chain)
            )
    of = {patch: part[network.patches[patch].loop[0] >> 1] for patch in sorted(placed)}
    first: dict[int, int | None] = {name: patch for patch, name in reversed(of.items())}
    # A part lies within a patch if any place of it does that is not on the patch's border, for no
    # curves cross.
    places = {
        name: trace_outline(network, network.patches[p].loop)[0]
        for name, p in first.items()
        if p is not None
    }
    for chain, name in sorted(part.items()):
        if name not in first and FACE in network.chains[chain].marks:
            first[name], places[name] = None, network.chains[chain].points
    if len(first) < 2:
        return {}
    given = {patch for patch in of if is_as_given(network.patches[patch])}
    drawn = {name for patch, name in of.items() if patch not in given}
    found: dict[int, int | None] = {}
    surfaces: dict[int, int] | None = None
    for patch, name in of.items():
        there = [
            other
            for other in first
            if other != name
            and (patch not in given or other in drawn)
            and _is_near(placed[patch], places[other])
        ]
        if not there:
            continue
        border = trace_outline(network, network.patches[patch].loop)
        if surfaces is None:
            surfaces = _find_surfaces(network, surface, part)
        for other in there:
            if surfaces[other] != surfaces[name]:
                # Beside each other in space, as an eye and its lid.
                continue
            away = np.asarray(KDTree(border[0]).query(places[other])[0])
            at = int(away.argmax())
            if away[at] <= ON_BORDER * surface.diagonal:
                # Around the same piece of the surface, or on the other side of its border.
                continue
            if is_within(surface, border, surface.nearest(places[other][at : at + 1])):
                found[patch] = first[other]
                break
    return found


def _find_surfaces(network: Network, surface: Surface, part: Mapping[int, int]) -> dict[int, int]:
    """The part of the surface that each part of a network lies on, by most of its points: where
    parts touch, single points may lie on another. part: of each chain."""
    whole = SurfaceParts.of(surface)
    names = sorted(set(part.values()))
    if whole.parts == 1:
        return dict.fromkeys(names, 0)
    points = {name: list[Points]() for name in names}
    for chain, name in part.items():
        points[name].append(network.chains[chain].points)
    return {
        name: int(np.bincount(whole.part[surface.nearest(np.concatenate(at)).triangles]).argmax())
        for name, at in points.items()
    }


def _is_near(placed: PlacedPatch, points: Points) -> bool:
    """Is one of points (n, 3) as near to a vertex of the quads as those on them are?"""
    corner = placed.vertices[placed.quads]
    across = max(
        float(np.linalg.norm(corner[:, k] - corner[:, k + 2], axis=1).max()) for k in (0, 1)
    )
    return bool((np.asarray(KDTree(placed.vertices).query(points)[0]) <= across).any())
