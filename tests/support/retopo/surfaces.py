"""Surfaces that retopology is tested on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from patterndb.geometry.surface import Surface


def grid(
    columns: int,
    rows: int,
    step: float,
    seed: int | None = None,
    low: tuple[float, float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 2) and triangles of a grid whose diagonals alternate; seed: for a jitter of a
    quarter step inside."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    at = np.stack([x, y], axis=-1).astype(float)
    if seed is not None:
        shake = np.random.default_rng(seed).uniform(-0.25, 0.25, at.shape)
        shake[[0, -1]] = shake[:, [0, -1]] = 0.0
        at += shake
    name = x * (rows + 1) + y
    a, b, c, d = name[:-1, :-1], name[1:, :-1], name[1:, 1:], name[:-1, 1:]
    odd = ((x + y)[:-1, :-1] % 2 == 1)[..., None]
    one = np.where(odd, np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    two = np.where(odd, np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    faces = np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)])
    return at.reshape(-1, 2) * step + low, faces


def raised(flat: np.ndarray, height: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """(v, 3) points over flat ones (v, 2)."""
    return np.c_[flat, height(flat[:, 0], flat[:, 1])]


def plane(columns: int = 20, rows: int = 20, step: float = 0.1, seed: int | None = 0) -> Surface:
    flat, faces = grid(columns, rows, step, seed)
    return Surface.from_arrays(raised(flat, lambda x, y: 0.0 * x), faces).orient()


def tube(around: int = 32, along: int = 20, length: float = 2.0) -> Surface:
    """A prism with a regular polygon across, radius 1, open at both ends; it can be unrolled."""
    turn = 2.0 * np.pi * np.arange(around) / around
    height = np.linspace(0.0, length, along + 1)
    points = [(np.cos(t), np.sin(t), z) for z in height for t in turn]
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = b + around, a + around
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return Surface.from_arrays(points, faces).orient()


def sphere(level: int = 3) -> Surface:
    """An icosahedron, cut and blown up ``level`` times."""
    g = (1.0 + np.sqrt(5.0)) / 2.0
    points = np.array([(s, t * g, 0.0) for s in (-1, 1) for t in (-1, 1)])
    points = np.concatenate([points, np.roll(points, 1, axis=1), np.roll(points, 2, axis=1)])
    near = np.abs(np.linalg.norm(points[:, None] - points, axis=2) - 2.0) < 1e-9
    faces = [
        (i, j, k) if np.linalg.det(points[[i, j, k]]) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    corner = points[np.array(faces)]
    for _ in range(level):
        a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
        ab, bc, ca = a + b, b + c, c + a
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corner = np.concatenate([np.stack(q, axis=1) for q in quarters])
        corner /= np.linalg.norm(corner, axis=2, keepdims=True)
    corner /= np.linalg.norm(corner, axis=2, keepdims=True)
    places, number = np.unique(np.round(corner.reshape(-1, 3), 12), axis=0, return_inverse=True)
    return Surface.from_arrays(places, number.reshape(-1, 3)).orient()


def bumps(seed: int, n: int = 24) -> Surface:
    """A hilly square with a jittered grid."""
    flat, faces = grid(n, n, 1.0 / n, seed)
    rng = np.random.default_rng(seed)
    wave = rng.normal(size=(4, 2)) * 6.0
    shift = rng.uniform(0.0, 6.0, 4)

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return sum(
            (0.06 * np.sin(w[0] * x + w[1] * y + s) for w, s in zip(wave, shift, strict=True)),
            np.zeros_like(x),
        )

    return Surface.from_arrays(raised(flat, height), faces).orient()
