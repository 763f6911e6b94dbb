"""A smooth cross field: four directions at right angles in every triangle; and its singularities.

A cross is one complex number, exp(4 i angle). The field is the smoothest under the connection
Laplacian (Knoppel et al. 2013), pulled towards the directions of curvature, then diffused and made
of unit length again in rounds (Viertel and Osting 2019), which takes singularities away that lie
close together. Its crosses are then matched across edges (Bommes et al. 2009), and with these
matchings, whole numbers, the singularities are fixed: pairs of opposed indices that are near each
other are cancelled by changing the matchings on a way between them, and the angles are solved for
once more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from patterndb._native.retopo.draft.crossfield import solve_laplacian
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb_sketch.retopo.draft.frames import TangentFrames

QUARTER = np.pi / 2.0

#: Rounds of diffusing and normalising, each over SCALE of the diagonal. Measured: fewer leave
#: pairs of singularities beside each other, more move them without taking any away.
ROUNDS = 20

SCALE = 0.04

#: A difference of the two curvatures above this, in 1 / diagonal, is a direction to be trusted.
SURE_CURVATURE = 10.0

#: The crosses along borders weigh so many times what lies beside them.
HELD = 1e3

#: Weights of sides are at most so many times those of equilateral triangles: needles say nothing.
MOST_WEIGHT = 10.0

#: At an inner vertex of so many quarters two lines end, which go on into each other; of more it has
#: fewer, and they go so many edges off.
MOST_INDEX, MOST_ON_BORDER, PARTED = 2, 1, 1.5

Complexes = NDArray[np.complexfloating]

#: Edges of the mesh over which a border is seen to turn.
FAR_OFF = 3


@dataclass(frozen=True, slots=True, eq=False)
class CrossField:
    """angle: (t,) float64, of one direction of every cross, in the frame of its triangle.

    quarters: (3t,) int32: direction k of a triangle is direction k - quarters beyond a side; 0 at
              borders. Opposite sides have opposite ones.
    index:    (v,) int32, in quarters of a turn: an inner vertex has 4 - index directions. On a
              border it is 2 less the quarters of a turn between its two border sides.
    """

    mesh: TangentFrames
    angle: Floats
    quarters: Int32Array
    index: Int32Array

    @property
    def singular(self) -> NDArray[np.intp]:
        """The vertices whose index is not 0."""
        return np.flatnonzero(self.index)


class FieldSolver:
    """Finds fields of one mesh: pairs that are cancelled may differ, the smoothest field is found
    once. alignment: weight of the directions of curvature."""

    def __init__(self, mesh: TangentFrames, alignment: float) -> None:
        self.mesh = mesh
        surface = mesh.surface
        self.sides = mesh.inner
        self.here, self.there = self.sides // 3, mesh.across[self.sides] // 3
        length = np.linalg.norm(
            surface.vertices[surface.triangles.ravel()[self.sides]]
            - surface.vertices[surface.triangles[self.here, (self.sides % 3 + 1) % 3]],
            axis=1,
        )
        middle = surface.vertices[surface.triangles].mean(axis=1)
        apart = np.linalg.norm(middle[self.here] - middle[self.there], axis=1)
        ratio = np.sqrt(3.0) * length / np.maximum(apart, 1e-12 * surface.diagonal) / 3.0
        self.weight = np.zeros(3 * len(surface.triangles))
        self.weight[self.sides] = np.minimum(ratio, MOST_WEIGHT)
        area = surface.areas
        self.mass = area / area.mean()
        pull = alignment * area.mean() / (SCALE * surface.diagonal) ** 2
        target, sure = measure_curvature(mesh)
        # Directions of curvature by their certainty, along borders theirs.
        self.pull = 50.0 * pull * sure * self.mass
        self.target = target
        border = surface.adjacency.border
        total = np.zeros(len(self.pull), np.complex128)
        np.add.at(total, border // 3, np.exp(4j * mesh.side_angle.ravel()[border]))
        held = np.unique(border // 3)
        self.pull[held] = HELD
        # Two sides of one triangle may want crosses that cancel out: then one is as good.
        self.target[held] = _normalised(total[held])

    def solve(self, merging: float) -> CrossField:
        """Return the field; singularities of opposed indices nearer than ``merging``, a length, are
        cancelled."""
        mesh, angle = self.mesh, self.smoothest
        quarters = match_crosses(mesh, angle)
        index = measure_indices(mesh, angle, quarters)
        changed = cancel_pairs(mesh, quarters, index, merging)
        index = measure_indices(mesh, angle, changed)
        changed = part_poles(mesh, changed, index)
        for _ in range(2):
            angle = self.relax(angle, changed)
        return CrossField(mesh, angle, changed, measure_indices(mesh, angle, changed))

    @cached_property
    def smoothest(self) -> Floats:
        """(t,) angles of the field: smoothest, then diffused in rounds."""
        turned = np.zeros(len(self.weight), np.complex128)
        turned[self.sides] = np.exp(4j * self.mesh.turn[self.mesh.across[self.sides]])
        wanted = self.pull * self.target
        least = 1e-6 * self.mass
        u = np.ones(len(self.mass), np.complex128)
        # Where nothing says which way, the inverse power method goes towards the smoothest.
        for _ in range(1 if self.pull.any() else ROUNDS):
            u = _normalised(self._solve(self.pull + least, turned, wanted + least * u, u))
        step = self.mass * self.mesh.surface.areas.mean()
        step /= (SCALE * self.mesh.surface.diagonal) ** 2
        for _ in range(ROUNDS):
            u = _normalised(self._solve(self.pull + step, turned, wanted + step * u, u))
        return np.angle(u).astype(np.float64) / 4.0

    def relax(self, angle: Floats, quarters: Int32Array) -> Floats:
        """(t,) the angles that fit the matchings best; the field has the same singularities."""
        jump = np.zeros(len(self.weight))
        jump[self.sides] = self.mesh.turn[self.sides] + QUARTER * quarters[self.sides]
        right = -(self.weight * jump).reshape(-1, 3).sum(axis=1)
        # Each triangle is pulled to that direction of its target which is nearest now.
        aim = np.angle(self.target) / 4.0
        aim += QUARTER * np.rint((angle - aim) / QUARTER)
        pull = self.pull + 1e-6 * self.mass
        alike = np.ones(len(self.weight), np.complex128)
        found = self._solve(pull, alike, right + pull * aim + 0j, angle + 0j)
        return np.ascontiguousarray(found.real, np.float64)

    def _solve(self, pull: Floats, turned: Complexes, right: Complexes, u: Complexes) -> Complexes:
        return solve_laplacian(self.mesh.across, self.weight, turned, pull, right, u)


def _normalised(u: Complexes) -> Complexes:
    size = np.abs(u)
    return np.where(size > 1e-30, u / np.maximum(size, 1e-30), 1.0)


def match_crosses(mesh: TangentFrames, angle: Floats) -> Int32Array:
    """(3t,) quarters of the nearest matchings across all sides."""
    quarters = np.zeros(3 * len(angle), np.int32)
    sides = mesh.inner
    other = mesh.across[sides]
    gap = angle[other // 3] - angle[sides // 3] - mesh.turn[sides]
    found = np.rint(gap / QUARTER).astype(np.int32)
    # A tie must be the same from both sides.
    first = sides < other
    quarters[sides[first]] = found[first]
    quarters[other[first]] = -found[first]
    return _unwind(mesh, quarters)


def _unwind(mesh: TangentFrames, quarters: Int32Array) -> Int32Array:
    """Quarters as they are; a full turn between two frames counts as the frames' own."""
    sides = mesh.inner
    full = np.rint((mesh.turn[sides] + mesh.turn[mesh.across[sides]]) / QUARTER).astype(np.int32)
    # turn + turn back is a multiple of a full turn, which the second of each pair takes up.
    second = sides > mesh.across[sides]
    quarters[sides[second]] -= full[second]
    return quarters


def measure_indices(mesh: TangentFrames, angle: Floats, quarters: Int32Array) -> Int32Array:
    """(v,) indices of a field by its matchings; see :class:`CrossField`."""
    gap = np.zeros(len(quarters))
    sides = mesh.inner
    gap[sides] = (
        angle[mesh.across[sides] // 3]
        - angle[sides // 3]
        - mesh.turn[sides]
        - QUARTER * quarters[sides]
    )
    n = len(mesh.vertices)
    corners = mesh.triangles.ravel()
    total = np.bincount(corners, mesh.corner_angle.ravel(), n)
    # Counter-clockwise around a vertex, a triangle is left by the side that ends there.
    before = np.arange(len(gap)).reshape(-1, 3)[:, [2, 0, 1]].ravel()
    np.add.at(total, corners, -gap[before])
    whole = np.where(mesh.on_border, np.pi, 2.0 * np.pi)
    # From a border's side to the next the field turns by what it is off them, too.
    border = mesh.surface.adjacency.border
    off = mesh.side_angle.ravel()[border] - angle[border // 3]
    off -= QUARTER * np.rint(off / QUARTER)
    tail, head = mesh.border_ends
    np.add.at(total, tail, off)
    np.add.at(total, head, -off)
    index = np.rint((whole - total) / QUARTER).astype(np.int32)
    index[np.bincount(corners, minlength=n) == 0] = 0
    return index


def list_corner_indices(mesh: TangentFrames) -> Int32Array:
    """(v,) the indices that borders have by their angles alone, in quarters; 0 within."""
    angle = np.bincount(mesh.triangles.ravel(), mesh.corner_angle.ravel(), len(mesh.vertices))
    natural = np.minimum(np.rint((np.pi - angle) / QUARTER), MOST_ON_BORDER).astype(np.int32)
    natural[~mesh.on_border | (angle == 0.0)] = 0
    # A ragged border has turns of single vertices that are none, seen from further off.
    tail, head = mesh.border_ends
    ahead, back = np.arange(len(natural)), np.arange(len(natural))
    ahead[tail], back[head] = head, tail
    one, two = back.copy(), ahead.copy()
    for _ in range(FAR_OFF - 1):
        one, two = back[one], ahead[two]
    at = mesh.vertices
    a, b = at - at[one], at[two] - at
    cosine = np.einsum("vc,vc->v", a, b)
    cosine /= np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-300)
    natural[cosine > np.cos(QUARTER / 2.0)] = 0
    return natural


def cancel_pairs(
    mesh: TangentFrames, quarters: Int32Array, index: Int32Array, nearest: float
) -> Int32Array:
    """(3t,) quarters after pairs of vertices of opposed indices, nearest first, are gone.

    nearest: pairs further apart than this, along edges, stay; twice that where one is on a border,
    whose singularities count twice on a seam of symmetry: one of a single quarter is a vertex of
    two quads there.
    """
    quarters, index = quarters.copy(), index.copy()
    if nearest <= 0.0:
        return quarters
    graph = mesh.inner_graph
    # What a border's angle asks for is no pair's: a corner without its line has bent quads.
    free = index - list_corner_indices(mesh)
    plus, minus = np.flatnonzero(free > 0), np.flatnonzero(free < 0)
    if not len(plus) or not len(minus):
        return quarters
    far, before = dijkstra(graph, indices=plus, limit=2.0 * nearest, return_predecessors=True)
    border = mesh.on_border[plus][:, None] | mesh.on_border[minus][None]
    rows, columns = np.nonzero(far[:, minus] <= np.where(border, 2.0, 1.0) * nearest)
    order = np.lexsort((minus[columns], plus[rows], far[rows, minus[columns]]))
    sides_of = _sides_by_ends(mesh)
    for k in order.tolist():
        one, two = int(plus[rows[k]]), int(minus[columns[k]])
        if free[one] <= 0 or free[two] >= 0:
            continue
        free[one] -= 1
        free[two] += 1
        _move_quarter(mesh, quarters, sides_of, before[rows[k]], one, two)
    return quarters


def _move_quarter(
    mesh: TangentFrames,
    quarters: Int32Array,
    sides_of: dict[tuple[int, int], int],
    before: Int32Array,
    one: int,
    two: int,
) -> None:
    """Change matchings along a way: what its first vertex loses, its last one gains."""
    at = two
    while at != one:
        back = int(before[at])
        side = sides_of[back, at]
        quarters[side] -= 1
        quarters[mesh.across[side]] += 1
        at = back


def part_poles(mesh: TangentFrames, quarters: Int32Array, index: Int32Array) -> Int32Array:
    """(3t,) quarters after vertices of more than two quarters, tips of needles, have given those
    to vertices around them: fewer than two lines would end in one."""
    most = np.where(mesh.on_border, MOST_ON_BORDER, MOST_INDEX)
    poles = np.flatnonzero(index > most)
    if not len(poles):
        return quarters
    quarters, index = quarters.copy(), index.copy()
    graph = mesh.inner_graph
    far, before = dijkstra(graph, indices=poles, return_predecessors=True)
    sides_of = _sides_by_ends(mesh)
    for row, pole in enumerate(poles.tolist()):
        # Two edges off there is room for lines between them.
        own = graph.data[graph.indptr[pole] : graph.indptr[pole + 1]]
        apart = PARTED * float(own.mean() if len(own) else 0.0)
        fit = ~mesh.on_border & np.isfinite(far[row]) & (far[row] >= apart)
        while index[pole] > most[pole] and (fit & (index <= 0)).any():
            other = int(np.where(fit & (index <= 0), far[row], np.inf).argmin())
            _move_quarter(mesh, quarters, sides_of, before[row], pole, other)
            index[pole] -= 1
            index[other] += 1
    return quarters


def _sides_by_ends(mesh: TangentFrames) -> dict[tuple[int, int], int]:
    tail = mesh.triangles.ravel().tolist()
    head = np.roll(mesh.triangles, -1, axis=1).ravel().tolist()
    return {pair: side for side, pair in enumerate(zip(tail, head, strict=True))}


def measure_curvature(mesh: TangentFrames) -> tuple[Complexes, Floats]:
    """(t,) crosses along the directions of curvature, and (t,) how sure they are, 0 to 1.

    The shape operator of a triangle is fitted to how the normals of its vertices, smoothed, change
    along its sides (Rusinkiewicz 2004).
    """
    surface = mesh.surface
    triangles, area = mesh.triangles, surface.areas
    normals = surface.normals.copy()
    for _ in range(3):
        mean = normals[triangles].mean(axis=1) * area[:, None]
        total = np.zeros_like(normals)
        for e in range(3):
            np.add.at(total, triangles[:, e], mean)
        size = np.linalg.norm(total, axis=1, keepdims=True)
        normals = total / np.maximum(size, 1e-300)
    corner, up = surface.vertices[triangles], normals[triangles]
    step, change = np.roll(corner, -1, axis=1) - corner, np.roll(up, -1, axis=1) - up
    u, v = np.einsum("tec,tc->te", step, mesh.x), np.einsum("tec,tc->te", step, mesh.y)
    p, q = np.einsum("tec,tc->te", change, mesh.x), np.einsum("tec,tc->te", change, mesh.y)
    rows = np.zeros((len(triangles), 6, 3))
    rows[:, 0::2, 0], rows[:, 0::2, 1] = u, v
    rows[:, 1::2, 1], rows[:, 1::2, 2] = u, v
    wanted = np.stack([p, q], axis=2).reshape(len(triangles), 6)
    normal = np.einsum("tki,tkj->tij", rows, rows)
    normal += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    shape = np.linalg.solve(normal, np.einsum("tki,tk->ti", rows, wanted)[..., None])[..., 0]
    half, twist = (shape[:, 0] - shape[:, 2]) / 2.0, shape[:, 1]
    sure = np.minimum(np.hypot(half, twist) * surface.diagonal / SURE_CURVATURE, 1.0)
    return np.exp(2j * np.arctan2(twist, half)), sure
