"""The discrete exponential map's front: frames and (u, v) handed on from vertex to vertex."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.surface import Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.ground.heap import grown, pop, push

#: A neighbour's proposal weighs its distance to this power. Source: the released program of
#: Takayama et al. 2013.
NEARNESS = -0.25

#: Normals whose dot product is nearly -1 have no least rotation from one to the other.
OPPOSITE = 1e-9


@kernel
def propose(
    vertices: Points, normals: Points, axes: Points, p: Index, q: Index, out: NDArray[np.float64]
) -> bool:
    """What p hands on to q: out (5,) becomes the step in (u, v) and the u axis at q.

    False if it has nothing to say: q is straight above p, or they face opposite ways.
    """
    nx, ny, nz = normals[p, 0], normals[p, 1], normals[p, 2]
    ux, uy, uz = axes[p, 0], axes[p, 1], axes[p, 2]
    dx = vertices[q, 0] - vertices[p, 0]
    dy = vertices[q, 1] - vertices[p, 1]
    dz = vertices[q, 2] - vertices[p, 2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    up = dx * nx + dy * ny + dz * nz
    dx, dy, dz = dx - up * nx, dy - up * ny, dz - up * nz
    flat = math.sqrt(dx * dx + dy * dy + dz * dz)
    facing = nx * normals[q, 0] + ny * normals[q, 1] + nz * normals[q, 2]
    if flat <= OPPOSITE * length or 1.0 + facing <= OPPOSITE:
        return False
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    out[0] = (dx * ux + dy * uy + dz * uz) * length / flat
    out[1] = (dx * vx + dy * vy + dz * vz) * length / flat
    turn = ux * normals[q, 0] + uy * normals[q, 1] + uz * normals[q, 2]
    turn /= 1.0 + facing
    out[2] = ux - turn * (nx + normals[q, 0])
    out[3] = uy - turn * (ny + normals[q, 1])
    out[4] = uz - turn * (nz + normals[q, 2])
    return True


@kernel
def _settle(axes: Points, normals: Points, q: Index) -> bool:
    """Put q's u axis into its tangent plane, at length 1; False if nothing is left of it."""
    up = 0.0
    for c in range(3):
        up += axes[q, c] * normals[q, c]
    size = 0.0
    for c in range(3):
        axes[q, c] -= up * normals[q, c]
        size += axes[q, c] ** 2
    if size <= OPPOSITE * OPPOSITE:
        return False
    for c in range(3):
        axes[q, c] /= math.sqrt(size)
    return True


@kernel
def spread(
    vertices: Points,
    normals: Points,
    star_start: Int32Array,
    star: Int32Array,
    seeds: Int32Array,
    seed_uv: Points,
    seed_axes: Points,
    seed_distance: NDArray[np.float64],
    distance: float,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[Int32Array, Points, NDArray[np.float64]]:
    """(m,) vertices in order of their distance, their (u, v) (m, 2) and distances (m,).

    seeds (s,) distinct vertices with their (u, v), u axes (s, 3) and distances; beyond the
    distance, or the box from low (2,) to high (2,), nothing is handed on.
    """
    v = len(vertices)
    far = np.full(v, np.inf)
    frozen = np.zeros(v, np.bool_)
    seeded = np.zeros(v, np.bool_)
    uv = np.empty((v, 2))
    axes = np.empty((v, 3))
    found = np.empty(v, np.int32)
    keys = np.empty(1024)
    items = np.empty(1024, np.int32)
    step = np.empty(5)
    n = 0
    m = 0
    for s in range(len(seeds)):
        q = seeds[s]
        far[q] = seed_distance[s]
        seeded[q] = True
        uv[q] = seed_uv[s]
        axes[q] = seed_axes[s]
        if n == len(keys):
            keys, items = grown(keys, items)
        n = push(keys, items, n, far[q], q)
    while n:
        key, q = keys[0], items[0]
        n = pop(keys, items, n)
        if key > distance:
            break
        if frozen[q] or key > far[q]:
            continue
        if not seeded[q]:
            total = 0.0
            u, w = 0.0, 0.0
            axes[q] = 0.0
            for k in range(star_start[q], star_start[q + 1]):
                p = star[k]
                if not frozen[p] or not propose(vertices, normals, axes, p, q, step):
                    continue
                size = 0.0
                for c in range(3):
                    size += (vertices[q, c] - vertices[p, c]) ** 2
                weight = size ** (0.5 * NEARNESS)
                total += weight
                u += weight * (uv[p, 0] + step[0])
                w += weight * (uv[p, 1] + step[1])
                for c in range(3):
                    axes[q, c] += weight * step[2 + c]
            if total == 0.0:
                far[q] = np.inf
                continue
            uv[q, 0] = u / total
            uv[q, 1] = w / total
        if uv[q, 0] < low[0] or uv[q, 0] > high[0] or uv[q, 1] < low[1] or uv[q, 1] > high[1]:
            continue
        if not _settle(axes, normals, q):
            continue
        frozen[q] = True
        found[m] = q
        m += 1
        for k in range(star_start[q], star_start[q + 1]):
            p = star[k]
            if frozen[p]:
                continue
            size = 0.0
            for c in range(3):
                size += (vertices[q, c] - vertices[p, c]) ** 2
            reached = key + math.sqrt(size)
            if reached < far[p] and reached <= distance:
                far[p] = reached
                if n == len(keys):
                    keys, items = grown(keys, items)
                n = push(keys, items, n, reached, p)
    return found[:m].copy(), uv[found[:m]], far[found[:m]]


@kernel
def held(
    triangles: Int32Array, vertices: Points, found: Int32Array, uv: Points, torn: float
) -> tuple[Int32Array, Int32Array]:
    """(k,) the triangles all of whose corners were found (m,), ascending; (k, 3) those corners
    as places in ``found``.

    Left out is a triangle with an edge more than ``torn`` times as long in (u, v) (m, 2) as it is.
    """
    name = np.full(len(vertices), -1, np.int32)
    for i in range(len(found)):
        name[found[i]] = i
    which = np.empty(len(triangles), np.int32)
    k = 0
    for f in range(len(triangles)):
        if name[triangles[f, 0]] < 0 or name[triangles[f, 1]] < 0 or name[triangles[f, 2]] < 0:
            continue
        whole = True
        for e in range(3):
            i, j = triangles[f, e], triangles[f, (e + 1) % 3]
            size = 0.0
            for c in range(3):
                size += (vertices[j, c] - vertices[i, c]) ** 2
            flat = 0.0
            for c in range(2):
                flat += (uv[name[j], c] - uv[name[i], c]) ** 2
            whole &= flat <= torn * torn * size
        if whole:
            which[k] = f
            k += 1
    corners = np.empty((k, 3), np.int32)
    for i in range(k):
        for e in range(3):
            corners[i, e] = name[triangles[which[i], e]]
    return which[:k].copy(), corners
