"""The panels of a registration: the model with its network, the membrane, the quads."""

from __future__ import annotations

import numpy as np
from draw_features_scene import BOLD, Scene, write
from numpy.typing import NDArray
from PIL import Image

from patterndb.geometry.surface import Surface
from patterndb_sketch.features.registration import Registration

#: From where cars are seen: the driver's side from the front.
FRONT_LEFT = (-0.62, -1.0, 0.42)


def stages(model: Surface, laid: Registration, name: str) -> list[Image.Image]:
    """The three panels of one model."""
    size = (470, 300)
    half = [curve.sample(120) for curve in laid.network.curves.values()]
    hidden = (laid.occluded | within_openings(laid))[laid.quads]
    a, b, c, d = laid.points[laid.quads].transpose(1, 0, 2)
    across = np.cross(c - a, d - b)
    sideways = np.abs(across[:, 1]) > 0.7 * np.linalg.norm(across, axis=1)
    shown = ~np.where(sideways, hidden.any(axis=1), hidden.all(axis=1))
    images: list[Image.Image] = []
    for title, points in (
        (f"{name} and its network", None),
        ("membrane", laid.membrane),
        (f"{len(laid.quads):,} quads on the model", laid.points),
    ):
        scene = Scene.around(size, FRONT_LEFT, model.vertices, 0.04, 36)
        if points is None:
            scene.solid(model.vertices, model.triangles, sharp=True)
        else:
            scene.solid(points, laid.quads[shown], wire=True)
        for line in half:
            scene.curve(line, radius=0.6 * BOLD)
        image = scene.image()
        write(image, (16, 10), title, 15.0)
        images.append(image)
    return images


def within_openings(laid: Registration) -> NDArray[np.bool_]:
    """(w,) the vertices on the straight lines that close wheel arches at the bottom."""
    result = np.zeros(len(laid.points), np.bool_)
    # The other half has the same openings.
    points = np.c_[laid.points[:, 0], -np.abs(laid.points[:, 1]), laid.points[:, 2]]
    for wheel in ("front", "rear"):
        start, end = (laid.network.nodes[f"{wheel}_arch_{foot}_foot"] for foot in ("front", "rear"))
        share = (points - start) @ (end - start) / ((end - start) @ (end - start))
        off = np.linalg.norm(points - start - share[:, None] * (end - start), axis=1)
        result |= (share > 0.0) & (share < 1.0) & (off < 1e-6)
    return result
