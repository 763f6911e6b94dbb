"""Placing: where the vertices of a patch's fill lie on the ground.

Boundary vertices divide the network's curves; interior ones are at rest under rounds of
smoothing and projection (:mod:`query.placing`). Only the ground within the patch is looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import flipped
from patterndb_sketch.retopo.filling.border import laid_border
from patterndb_sketch.retopo.filling.choice import Choice, Filling
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Network, Patch
from query.fill import Fill
from query.placing import enclosed, place


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A patch's quads on the ground.

    quads:   (q, 4) int32, counter-clockwise; boundary vertices are 0..P - 1 from the patch's
             first corner on. vertices, normals: (v, 3) float64, normals of unit length.
    flipped: (f,) int32, quads that are clockwise seen from outside, or cross themselves.
    at_rest: did smoothing and projection come to an end?
    """

    quads: Int32Array
    vertices: Points
    normals: Points
    perimeter: int
    flipped: Int32Array
    at_rest: bool


def placed(network: Network, ground: Ground, patch: Patch) -> Placed:
    """The quads of a patch, which must have a choice that its counts suit, on the ground.

    Differs from the paper: smoothing and projection alternate until nothing moves by more than
    1e-4 of the patch's diagonal, tangentially and to the least sum of squared edges, and
    flipped quads are untangled where that can be.
    """
    filling: Filling = patch.choice
    choice = filling.choice
    if choice is None:
        raise ValueError(f"patch {patch.id} has no fill yet")
    quads = choice.faces
    which, at = filling.moved_vertices
    if len(which) == choice.n_vertices:
        # As imported: there is nothing left to place.
        vertices, at_rest = np.empty_like(at), True
    else:
        points = laid_border(network, patch, ground)
        found = place(fill_of(choice), points, enclosed(ground.surface, points))
        if not len(which):
            normals = ground.nearest(found.vertices).normals
            return Placed(
                quads, found.vertices, normals, choice.perimeter, found.flipped, found.at_rest
            )
        vertices, at_rest = found.vertices.copy(), found.at_rest
    vertices[which] = at
    normals = ground.nearest(vertices).normals
    wrong = np.flatnonzero(flipped(quads, vertices, normals)).astype(np.int32)
    return Placed(quads, vertices, normals, choice.perimeter, wrong, at_rest)


def fill_of(choice: Choice) -> Fill:
    """The fill of a choice."""
    code = np.frombuffer(choice.code, np.uint16)
    return Fill(
        quads=choice.faces,
        n_vertices=choice.n_vertices,
        lengths=choice.lengths,
        pattern=Pattern.from_trusted_code(code, origin=choice.origin),
        widths=choice.widths,
        rotation=choice.rotation,
        mirrored=choice.mirrored,
        n_irregular=choice.n_irregular,
        origin=choice.origin,
    )
