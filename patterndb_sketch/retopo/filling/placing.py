"""Place the vertices of a patch's fill on the surface.

Boundary vertices divide the network's curves; interior ones are at rest under rounds of
smoothing and projection (:mod:`query.placing`). Only the surface within the patch is looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.choice import Choice, Filling
from patterndb_sketch.retopo.network import (
    EVEN,
    SYMMETRY,
    Chain,
    Density,
    HalfChain,
    Network,
    Patch,
)
from patterndb_sketch.retopo.network.flooding import explain_region
from query.fill import Fill
from query.placing import enclose_region, place
from query.placing.laplace import HeldQuads


def divide_lengths(chain: Chain, density: Density = EVEN) -> NDArray[np.float64]:
    """(count + 1,) arc lengths that divide a chain evenly, where nothing is painted; else each edge
    has the same length times density."""
    lengths, measured = density.measure(chain.round, chain.round_normals)
    wanted = np.linspace(0.0, measured[-1], chain.count + 1)
    return wanted if measured is lengths else np.interp(wanted, measured, lengths)


def is_divided_alike(chain: Chain, one: Density, other: Density) -> bool:
    """Do two densities divide a chain at the same places?"""
    # Most of what is painted is elsewhere.
    if one == other or one.find_over(chain.round) == other.find_over(chain.round):
        return True
    return np.array_equal(divide_lengths(chain, one), divide_lengths(chain, other))


def divide_chain(chain: Chain, density: Density = EVEN) -> tuple[Points, Points]:
    """(count + 1, 3) points and normals that divide a chain by :func:`divide_lengths`.

    Ends are the chain's own, bit for bit: patches on both sides, and chains at one node, share
    them.
    """
    line, up = chain.round, chain.round_normals
    along = arc_length(line)
    wanted = divide_lengths(chain, density)
    points = np.stack([np.interp(wanted, along, line[:, d]) for d in range(3)], axis=1)
    normals = units(np.stack([np.interp(wanted, along, up[:, d]) for d in range(3)], axis=1))
    points[0], points[-1] = line[0], line[-1]
    normals[0], normals[-1] = up[0], up[-1]
    return points, normals


def divide_half_chain(network: Network, half: HalfChain) -> tuple[Points, Points]:
    """The same in the direction of a half-chain."""
    points, normals = divide_chain(network.chains[half >> 1], network.density)
    return (points[::-1], normals[::-1]) if half & 1 else (points, normals)


def lay_border(network: Network, patch: Patch, surface: Surface) -> Points:
    """(P, 3) points around a patch, from its first corner on, each on the surface.

    Between its samples a chain cuts across the surface's edges; points of it are taken to the
    nearest triangle that faces as they do, each by itself, so that both sides still share them.
    Nodes are on the surface already, and what is on the plane of symmetry stays there exactly.
    """
    parts: list[Points] = []
    for half in patch.loop:
        points, normals = divide_half_chain(network, half)
        points, normals = points[:-1].copy(), normals[:-1]
        if len(points) > 1 and SYMMETRY not in network.chains[half >> 1].marks:
            points[1:] = surface.nearest_facing(points[1:], normals[1:]).points
        parts.append(points)
    return np.concatenate(parts)


def trace_border(network: Network, patch: Patch) -> tuple[Points, Points]:
    """(P, 3) points and normals around a patch, from its first corner on."""
    parts = [divide_half_chain(network, half) for half in patch.loop]
    return (
        np.concatenate([points[:-1] for points, _ in parts]),
        np.concatenate([normals[:-1] for _, normals in parts]),
    )


def name_border_vertices(network: Network, patch: Patch) -> list[tuple[int, int]]:
    """What each boundary vertex of a patch is: (node, -1), or (chain, its number along it)."""
    keys: list[tuple[int, int]] = []
    for half in patch.loop:
        chain = network.chains[half >> 1]
        keys.append((network.origin(half), -1) if not chain.is_closed_loop else (chain.id, 0))
        inner = range(1, chain.count)
        keys += [(chain.id, k) for k in (reversed(inner) if half & 1 else inner)]
    return keys


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPatch:
    """A patch's quads on the surface.

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

    def find_flipped(self) -> Points:
        """(f, 3) the middles of the quads that are flipped."""
        return self.vertices[self.quads[self.flipped]].mean(axis=1)


def is_as_given(patch: Patch) -> bool:
    """Does a patch have its fill as a mesh was given, every vertex where it was?"""
    filling: Filling = patch.choice
    choice = filling.choice
    return choice is not None and len(filling.moved_vertices[0]) == choice.n_vertices


def place_fill(network: Network, surface: Surface, patch: Patch) -> PlacedPatch:
    """The quads of a patch, which must have a choice that its counts suit, on the surface.

    Differs from the paper: smoothing and projection alternate until nothing moves by more than
    1e-4 of the patch's diagonal, tangentially and to the least sum of squared edges, and
    flipped quads are untangled where that can be. Raises RefusedError for a patch that is no disk
    of the surface.
    """
    filling: Filling = patch.choice
    choice = filling.choice
    if choice is None:
        raise ValueError(f"patch {patch.id} has no fill yet")
    quads = choice.faces
    which, at = filling.moved_vertices
    if is_as_given(patch):
        # There is nothing left to place.
        vertices, at_rest = np.empty_like(at), True
    elif len(which) and np.array_equal(which, np.arange(choice.perimeter, choice.n_vertices)):
        # All that is within is held: the border alone follows the curves.
        vertices, at_rest = np.empty((choice.n_vertices, 3)), True
        vertices[: choice.perimeter] = lay_border(network, patch, surface)
    else:
        points = lay_border(network, patch, surface)
        region = enclose_region(surface, points)
        why = explain_region(surface, region, points)
        if why is not None:
            raise RefusedError(f"patch {patch.id} has no quads: {why}")
        found = place(fill_of(choice), points, region)
        if not len(which):
            normals = surface.nearest(found.vertices).normals
            return PlacedPatch(
                quads, found.vertices, normals, choice.perimeter, found.flipped, found.at_rest
            )
        vertices, at_rest = found.vertices.copy(), found.at_rest
    vertices[which] = at
    normals = surface.nearest(vertices).normals
    wrong = np.flatnonzero(flipped(quads, vertices, normals)).astype(np.int32)
    return PlacedPatch(quads, vertices, normals, choice.perimeter, wrong, at_rest)


def place_between(network: Network, surface: Surface, patch: Patch) -> PlacedPatch:
    """The quads of a patch, which must have a choice, with its inner vertices between those on its
    border, each projected by itself: without asking whether the patch is a disk of the surface.

    It is where quads begin that are fitted as a whole; on thin plates and rings paths over the
    surface from one vertex of the border to the next cross each other, and enclose nothing.
    """
    filling: Filling = patch.choice
    choice = filling.choice
    if choice is None:
        raise ValueError(f"patch {patch.id} has no fill yet")
    n = choice.perimeter
    net = HeldQuads.of(choice.faces, choice.n_vertices, n)
    points = net.place_harmonic(lay_border(network, patch, surface))
    up = net.place_harmonic(trace_border(network, patch)[1])
    if choice.n_vertices > n:
        there = surface.nearest_facing(points[n:], units(up[n:]))
        points[n:], up[n:] = there.points, there.normals
    wrong = np.flatnonzero(flipped(choice.faces, points, up)).astype(np.int32)
    return PlacedPatch(choice.faces, points, up, choice.perimeter, wrong, True)


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
