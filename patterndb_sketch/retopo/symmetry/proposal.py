"""Propose the plane of symmetry that a surface has by itself, and measure how well it has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.symmetry.half import Plane
from patterndb_sketch.retopo.wording import format_place

#: Points of the surface whose images are looked at, about; a third as many, first.
POINTS = 1500

#: Planes that are made better after the first look; and the rounds in which.
BETTERED, ROUNDS = 4, 12

#: Directions that are tried besides the surface's own axes.
DIRECTIONS = 24

#: A plane through the axes is preferred to one that is better by less than this, in parts of the
#: diagonal: models are made so, and images are exact then.
AXES = 1e-3


#: A plane that the surface does not leave by more than this, in parts of its diagonal, lies along
#: it: a sheet is its own image in its own plane, and there is no half of it to work on.
ALONG = 0.02

#: A surface is symmetric in a plane if its image is this near to it, in parts of its diagonal: the
#: root of the mean square. A scan of what is symmetric is some thousandths off.
SYMMETRIC = 0.005


@dataclass(frozen=True, slots=True)
class Proposal:
    """A plane, and how far the image of the surface is from the surface: the root of the mean
    squared distance of points spread over it by area, as a part of the diagonal. 0 is symmetric;
    a few thousandths are a scan of what is."""

    plane: Plane
    off: float

    @property
    def symmetric(self) -> bool:
        """Is the surface symmetric in it, as far as scans are?"""
        return self.off <= SYMMETRIC

    def describe(self) -> str:
        """The plane, and how far off it is, in words."""
        point, normal = (format_place(one) for one in (self.plane.point, self.plane.normal))
        return f"the plane through {point} across {normal}, {format_share(self.off)} off"


def format_share(off: float) -> str:
    """Format a part of the diagonal in percent: 0.02 is ``2 %``."""
    return f"{100.0 * off:.2g} %" if off >= 1e-6 else "0 %"


def propose_plane(surface: Surface) -> Proposal:
    """The plane in which the surface is most nearly its own image.

    Tried are the planes x, y and z = 0 through the origin, and planes through the middle of the
    surface: at right angles to its axes, its principal axes and directions all around, the best
    of which are made better by turns of finding nearest points and fitting a plane to them. Planes
    along which all of it lies are none (ALONG).
    """
    points = spread_points(surface, POINTS)
    few = points[::3]
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((points - middle).T))
    directions = np.concatenate([np.eye(3), axes.T, spread_directions(DIRECTIONS)])
    least = ALONG * surface.diagonal

    def through(point: Points, directions: Points) -> list[Plane]:
        planes = [Plane.of(point, direction) for direction in directions]
        return [one for one in planes if np.abs(one.heights(points)).max() > least]

    tried = [
        Proposal(plane, measure_asymmetry(surface, plane, few))
        for plane in through(middle, directions)
    ]
    tried.sort(key=lambda one: one.off)
    better = [_improve_plane(surface, one.plane, few) for one in tried[:BETTERED]]
    best = min(
        (Proposal(plane, measure_asymmetry(surface, plane, points)) for plane in better),
        key=lambda one: one.off,
    )
    even = [
        Proposal(plane, measure_asymmetry(surface, plane, points))
        for plane in through(np.zeros(3), np.eye(3))
    ]
    straight = min(even, key=lambda one: one.off, default=best)
    return straight if straight.off <= best.off + AXES else best


def propose_given(surface: Surface, plane: Plane) -> Proposal:
    """A plane that is given, with how far off it is."""
    return Proposal(plane, measure_asymmetry(surface, plane, spread_points(surface, POINTS)))


def measure_asymmetry(surface: Surface, plane: Plane, points: Points) -> float:
    """How far the images of points (n, 3) are from the surface; see :class:`Proposal`."""
    images = plane.mirror(points)
    gaps = surface.nearest(images).points - images
    return float(np.sqrt((gaps**2).sum(axis=1).mean()) / surface.diagonal)


def spread_points(surface: Surface, about: int) -> Points:
    """(n, 3) points spread evenly over the surface by its area, the same ones every time."""
    areas = surface.areas
    ends = np.cumsum(areas)
    at = (np.arange(about) + 0.5) / about * ends[-1]
    triangle = np.minimum(np.searchsorted(ends, at), len(areas) - 1)
    # A sequence that fills the square evenly (Roberts), folded to a triangle.
    k = np.arange(about)
    u, v = (0.5 + 0.7548776662466927 * k) % 1.0, (0.5 + 0.5698402909980532 * k) % 1.0
    folded = u + v > 1.0
    u, v = np.where(folded, 1.0 - u, u), np.where(folded, 1.0 - v, v)
    corner = surface.vertices[surface.triangles[triangle]]
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    return np.einsum("ne,nec->nc", weights, corner)


def spread_directions(n: int) -> NDArray[np.float64]:
    """(n, 3) directions spread evenly over a hemisphere, along a spiral."""
    k = np.arange(n)
    z = (k + 0.5) / n
    turn = k * (np.pi * (3.0 - np.sqrt(5.0)))
    radius = np.sqrt(1.0 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def _improve_plane(surface: Surface, plane: Plane, points: Points) -> Plane:
    """The plane after rounds of taking images to the surface, and fitting to them."""
    for _ in range(ROUNDS):
        images = surface.nearest(plane.mirror(points)).points
        one, two = points.mean(axis=0), images.mean(axis=0)
        # The reflection that takes points to images best: the least of p . q along its normal.
        together = (points - one).T @ (images - two)
        _, axes = np.linalg.eigh(together + together.T)
        normal = axes[:, 0]
        if normal @ np.array(plane.normal) < 0.0:
            normal = -normal
        plane = Plane.of(0.5 * (one + two), normal)
    return plane
