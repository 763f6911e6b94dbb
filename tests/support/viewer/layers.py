"""What a composed picture shows, by its layers."""

from __future__ import annotations

import numpy as np

from viewer.stage import Curves, Drawn, Faces, Layer, Marks


def find_layer(drawn: Drawn, name: str) -> Layer:
    """The layer of a name."""
    return next(layer for layer in drawn.layers if layer.name == name)


def count_marks(drawn: Drawn, colour: str) -> int:
    """How many marks of a colour are shown."""
    return sum(
        int(layer.find_shown(drawn.view).sum())
        for layer in drawn.layers
        if isinstance(layer, Marks) and layer.colour == colour
    )


def count_segments(drawn: Drawn, colour: str | None = None) -> int:
    """How many straight pieces of curves of a colour, or of any, are shown."""
    return sum(
        len(layer.find_joined(drawn.view))
        for layer in drawn.layers
        if isinstance(layer, Curves) and colour in (None, layer.look.colour)
    )


def are_finite(drawn: Drawn) -> bool:
    """Is every point of a picture finite?"""
    for layer in drawn.layers:
        points = layer.places if isinstance(layer, Marks) else layer.points
        if not np.isfinite(points).all():
            return False
        if isinstance(layer, Faces) and layer.normals is not None:
            assert len(layer.normals) == len(layer.points)
    flat = drawn.scene.patches
    return all(np.isfinite(p.corners).all() and len(p.corners) == len(p.colours) for p in flat)
