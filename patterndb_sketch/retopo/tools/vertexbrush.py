"""Vertex brush: placed vertices follow the hand, or are smoothed; chains follow them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.filling.border import divided
from patterndb_sketch.retopo.filling.meshing import RetopoMesh
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Chain, Edit, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.course import on_ground
from patterndb_sketch.retopo.tools.underbrush import Under, falloff
from query.engine import PatternSource

#: Rounds of smoothing at one call unless told otherwise.
ROUNDS = 5


def brush(
    network: Network,
    ground: Ground,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    to: ArrayLike,
) -> Edit:
    """Drag the vertices of the quads within the brush's radius (``sizes.brush``) of a point.

    point, normal: (3,) on the surface, where the drag begins; to: (3,), where it ends. Vertices
    whose normals agree move by shares (1 - t)^4 (4 t + 1) of the drag, t their distance as a part
    of the radius, and are taken to the ground. What the network keeps of it: see
    :meth:`Under.edited`. Vertices on borders and on the seam of symmetry stay.

    Counts and fills that are not chosen yet, and are needed, are chosen. Raises RefusedError if
    no quads are near or a curve would have no length. Source: the program of Takayama et al. 2013.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    if (np.asarray(to, np.float64) == at).all():
        return Edit.of(network, network)
    under = Under.of(network, ground, source, sizes, at, up)
    foot = ground.nearest_facing(np.asarray(to, np.float64)[None], up[None])
    share = np.where(under.marked, 0.0, under.share)[:, None]
    points, normals = under.mesh.vertices.copy(), under.mesh.normals.copy()
    moves = share[:, 0] > 0.0
    points[moves], normals[moves] = on_ground(
        (points + share * (foot.points[0] - at))[moves],
        units(normals + share * (foot.normals[0] - up))[moves],
        ground,
        sizes,
    )

    def course(line: Chain) -> Points:
        by = falloff(line.points, at, sizes.brush) * (line.normals @ up > 0.0)
        # Ends that stay hold what is between them and the next vertex.
        over = by[[0, -1]] - under.vertices_on(line, share[:, 0])[[0, -1]]
        off = arc_length(line.points) / line.length * max(line.count, 1)
        by -= over[0] * np.maximum(1.0 - off, 0.0) + over[1] * np.maximum(1.0 - off[-1] + off, 0.0)
        return line.points + by[:, None] * (foot.points[0] - at)

    return under.edited(network, ground, sizes, points, normals, course)


def relax(
    network: Network,
    ground: Ground,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    rounds: int = ROUNDS,
) -> Edit:
    """Smooth the vertices of the quads within the brush's radius of a point.

    Each round takes every vertex, by the share of :func:`brush`, to the mean of its neighbours:
    for one on a side these are its two along the side and the inner ones of both patches, for a
    corner all around it. One on a curve that has quads on one side only goes to the middle
    between its neighbours along it, and stays on the curve; there, corners stay, and what is on
    a border or the seam of symmetry.

    Raises RefusedError if no quads are near. Source: the program of Takayama et al. 2013. Differs
    from it: there each patch weighs a corner's neighbours along its sides by half; as each such
    neighbour belongs to two patches, that is the mean of all.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    under = Under.of(network, ground, source, sizes, at, up)
    start, neighbour = _neighbours(under.mesh)
    degree = np.diff(start)[:, None]
    free = np.flatnonzero((under.share > 0.0) & ~under.rim & ~under.marked)
    slide, before, after = under.sliding()
    points, normals = under.mesh.vertices, under.mesh.normals
    for _ in range(rounds):
        mean = np.add.reduceat(points[neighbour], start[:-1], axis=0) / degree
        wanted = points + under.share[:, None] * (mean - points)
        where, there = on_ground(wanted[free], normals[free], ground, sizes)
        middle = 0.5 * (points[before] + points[after]) - points[slide]
        slid = points[slide] + under.share[slide, None] * middle
        points, normals = points.copy(), normals.copy()
        points[free], normals[free] = where, there
        for k, place in zip(slide, slid, strict=True):
            points[k], normals[k] = _on_chain(network.chains[int(under.mesh.chain[k])], place)
    places = points

    def course(line: Chain) -> Points:
        return _smooth_course(under, line, places, rounds)

    return under.edited(network, ground, sizes, points, normals, course, under.one_sided)


def _smooth_course(under: Under, line: Chain, places: Points, rounds: int) -> Points:
    """(n, 3) samples of a chain whose vertices are at other places: along the smooth curve through
    these where smoothing had full effect, and moved alongside the vertices where it had less."""
    old = divided(line)[0] if line.count else line.points[[0, -1]]
    moves = under.vertices_on(line, places - under.mesh.vertices)
    along = arc_length(line.points)
    number = np.arange(len(moves))
    at = np.interp(along, np.linspace(0.0, along[-1], len(moves)), number)
    by = np.stack([np.interp(at, number, moves[:, d]) for d in range(3)], axis=1)
    share = np.interp(at, number, under.vertices_on(line, under.share))
    weight = (1.0 - (1.0 - share) ** rounds)[:, None]
    curve = CubicSpline(number, old + moves, bc_type="natural")(at)
    return (1.0 - weight) * (line.points + by) + weight * curve


def _neighbours(mesh: RetopoMesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The vertices at the other ends of every vertex's edges: those of i are
    neighbour[start[i]:start[i + 1]]."""
    tail = mesh.quads.ravel().astype(np.int64)
    head = np.roll(mesh.quads, -1, axis=1).ravel().astype(np.int64)
    pairs = np.unique(
        np.concatenate([np.stack([tail, head], 1), np.stack([head, tail], 1)]), axis=0
    )
    start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(mesh.vertices)))])
    return start, pairs[:, 1]


def _on_chain(line: Chain, point: Points) -> tuple[Points, Points]:
    """The point of a chain nearest to a point (3,), and the normal there."""
    one, along = line.points[:-1], np.diff(line.points, axis=0)
    size = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((point - one) * along).sum(axis=1) / size, 0.0, 1.0)
    at = one + share[:, None] * along
    k = int(np.linalg.norm(at - point, axis=1).argmin())
    up = (1.0 - share[k]) * line.normals[k] + share[k] * line.normals[k + 1]
    return at[k], units(up[None])[0]
