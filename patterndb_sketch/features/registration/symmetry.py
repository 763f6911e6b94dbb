"""Whole shapes from halves: the mirror image in the plane y = 0, welded there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.features.registration.template import Template

MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Mirroring:
    """How a half of v vertices becomes a whole of w: its own, then the images of those off the
    plane.

    quads:  (2 q, 4) int32, those of the half, then their images, turned so that all face out.
    source: (w,) int64, the vertex of the half that each comes from.
    image:  (w,) bool, is it an image?
    plane:  (v,) bool, the half's vertices in the plane.
    """

    quads: Int32Array
    source: NDArray[np.int64]
    image: NDArray[np.bool_]
    plane: NDArray[np.bool_]

    @classmethod
    def of(cls, template: Template) -> Mirroring:
        """Of the template of a half; a template that is not half of something stays as it is."""
        v = template.n_vertices
        if not template.mirrored:
            return cls(template.quads, np.arange(v), np.zeros(v, np.bool_), template.plane)
        off = np.flatnonzero(~template.plane)
        twin = np.arange(v)
        twin[off] = v + np.arange(len(off))
        images = twin[template.quads][:, ::-1].astype(np.int32)
        return cls(
            np.concatenate([template.quads, images]),
            np.r_[np.arange(v), off],
            np.arange(v + len(off)) >= v,
            template.plane,
        )

    def whole(self, points: Points) -> Points:
        """(w, 3) the whole of a half (v, 3); vertices in the plane get y = 0."""
        half = points.copy()
        half[self.plane, 1] = 0.0
        result = half[self.source]
        result[self.image] *= MIRROR
        return result
