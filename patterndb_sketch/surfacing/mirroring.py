"""Symmetric sketches: half of the curves and their mirror images are one network.

Programs that draw with a mirror save one half. Its curves end on the plane: there each goes on in
its image, and a curve that lies in the plane is its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import (
    Curve,
    CurveId,
    CurveNetwork,
    InvalidNetworkError,
    list_steps_at_nodes,
)
from patterndb_sketch.curvenetwork.normals import find_nearest_normals
from patterndb_sketch.curvenetwork.polylines import drop_repeats, move_ends
from patterndb_sketch.retopo.symmetry.half import Plane

#: What is this near to the plane, as a part of the half's diagonal, is on it: ends drawn by hand
#: up to a plane that one sees miss it by some thousandths.
REACH = 5e-3

AXES = "xyz"


def parse_plane(text: str) -> Plane:
    """The plane that a text names: x, y or z (through the origin), x=1.5, or a,b,c,d.

    The last is a x + b y + c z = d. Raises InvalidNetworkError for anything else.
    """
    name, _, value = text.partition("=")
    numbers = text.split(",")
    try:
        if name.strip().lower() in AXES and name.strip():
            axis = np.eye(3)[AXES.index(name.strip().lower())]
            return Plane.of(axis * float(value or 0.0), axis)
        normal, offset = np.array(numbers[:3], np.float64), float(numbers[3])
        squared = float(normal @ normal)
        if len(numbers) == 4 and np.isfinite([squared, offset]).all() and squared > 0.0:
            return Plane.of(normal * (offset / squared), normal)
    except (ValueError, IndexError):
        pass
    raise InvalidNetworkError(
        f"{text!r} is not a plane; give x, y or z, x=1.5, or a,b,c,d for ax + by + cz = d"
    )


def describe_plane(plane: Plane) -> str:
    """Write a plane as :func:`parse_plane` reads it."""
    normal = np.array(plane.normal)
    at = int(np.abs(normal).argmax())
    offset = float(normal @ np.array(plane.point))
    if abs(normal[at]) == 1.0:
        return f"{AXES[at]} = {offset * normal[at] + 0.0:.6g}"
    return ",".join(f"{number + 0.0:.6g}" for number in (*normal, offset))


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A plane, how many curves end on it where nothing goes on, and how many nodes are on it."""

    plane: Plane
    loose: int
    nodes: int


def find_mirror_plane(network: CurveNetwork) -> Plane:
    """Find the plane in which half of a sketch is to be mirrored.

    The whole half lies on one side of it, and of all such planes it is the one on which most curves
    end where nothing goes on. Looked at are the planes at right angles to the axes through the
    origin and through the ends of the half, and the plane of all ends where nothing goes on. Where
    no curve ends so, the plane of the origin is taken that has the most nodes.

    Raises InvalidNetworkError where there is none, or several serve as well.
    """
    if not network.curves:
        raise InvalidNetworkError("the network has no curves to mirror; give some")
    points = np.concatenate([curve.points for curve in network.curves])
    reach = REACH * network.diagonal
    at_nodes = list_steps_at_nodes(network)
    used = network.nodes[[bool(steps) for steps in at_nodes]]
    loose = network.nodes[[len(steps) == 1 for steps in at_nodes]]
    found: list[_Candidate] = []
    for plane in _list_planes(points, loose, reach):
        heights = plane.heights(points)
        both_sides = heights.min() < -reach and heights.max() > reach
        if both_sides or np.abs(heights).max() <= reach:
            continue
        ends = int((np.abs(plane.heights(loose)) <= reach).sum())
        candidate = _Candidate(plane, ends, int((np.abs(plane.heights(used)) <= reach).sum()))
        alike = [one for one in found if _is_same(one.plane, plane, points, reach)]
        if candidate.nodes and not alike:
            found.append(candidate)
    best = [one for one in found if one.loose == max(other.loose for other in found)]
    if best and not best[0].loose:
        through = [one for one in best if abs(one.plane.heights(np.zeros((1, 3)))[0]) <= reach]
        best = [one for one in through if one.nodes == max(other.nodes for other in through)]
    if len(best) == 1:
        return best[0].plane
    if not best:
        raise InvalidNetworkError(
            "there is no plane on which curves of the sketch end, with all of it on one side; name "
            "the plane, such as x or x=1.5"
        )
    names = ", ".join(describe_plane(one.plane) for one in best)
    raise InvalidNetworkError(f"the sketch may be mirrored in {names} as well; name the plane")


def _list_planes(points: Points, loose: Points, reach: float) -> list[Plane]:
    planes: list[Plane] = []
    low, high = points.min(axis=0), points.max(axis=0)
    for axis in np.eye(3):
        # The origin first: of planes within reach of each other that one is meant.
        planes += [Plane.of(axis * value, axis) for value in (0.0, low @ axis, high @ axis)]
    if len(loose) >= 3:
        middle = loose.mean(axis=0)
        _, spread, axes = np.linalg.svd(loose - middle)
        if spread[1] > reach:
            planes.append(Plane.of(middle, axes[2]))
    return planes


def _is_same(one: Plane, other: Plane, points: Points, reach: float) -> bool:
    """Is the sketch as far from one plane as from the other?"""
    apart = np.abs(one.heights(points)) - np.abs(other.heights(points))
    return bool(np.abs(apart).max() <= reach)


def mirror_drawing(drawing: Drawing, plane: Plane) -> Drawing:
    """Add the mirror images of a drawing's curves, joined to them in a plane.

    Nodes within REACH of the plane are moved onto it, the curves there with them. A curve that lies
    in the plane is its own image; images of others have "_mirrored" after their ids. So have
    cycles and stages their images.

    Raises InvalidNetworkError where curves lie on both sides of the plane or none reaches it.
    """
    network = drawing.network
    if not network.curves:
        raise InvalidNetworkError("the network has no curves to mirror; give some")
    reach = REACH * network.diagonal
    if sum(float(plane.heights(curve.points).sum()) for curve in network.curves) < 0.0:
        plane = plane.reversed
    _refuse_both_sides(network, plane, reach)
    heights = plane.heights(network.nodes)
    on_plane = np.abs(heights) <= reach
    if not on_plane.any():
        raise InvalidNetworkError(
            f"no curve ends on the plane {describe_plane(plane)}: the nearest node is "
            f"{float(np.abs(heights).min()):.3g} away; name another plane"
        )
    here = np.where(on_plane[:, None], plane.flatten(network.nodes), network.nodes)
    nodes = np.concatenate([here, plane.mirror(here[~on_plane])])
    image = np.where(on_plane, np.arange(len(here)), len(here) + np.cumsum(~on_plane) - 1)
    taken = {str(curve.id) for curve in network.curves}
    taken |= {str(curve.stroke) for curve in network.curves}
    curves: list[Curve] = []
    images: list[Curve] = []
    number: dict[int, int] = {}
    for at, drawn in enumerate(network.curves):
        curve, flat = _lay_curve(drawn, nodes, plane, reach)
        curves.append(curve)
        if flat:
            number[at] = at
            continue
        number[at] = len(network.curves) + len(images)
        ends = (int(image[curve.nodes[0]]), int(image[curve.nodes[1]]))
        mirrored = plane.mirror(curve.points)
        mirrored[[0, -1]] = nodes[list(ends)]
        images.append(
            Curve(
                mirrored,
                ends,
                _name_image(curve.id, taken),
                _name_image(curve.stroke, taken),
                None if curve.normals is None else plane.mirror_directions(curve.normals),
            )
        )
    cycles = list(network.cycles)
    for cycle in network.cycles:
        other = cycle.renumber(number)
        if other is not None and other.key != cycle.key:
            cycles.append(other.turned)
    stages = tuple(
        tuple(dict.fromkeys([*stage, *(number[curve] for curve in stage)]))
        for stage in drawing.stages
    )
    note = (
        f"mirrored in the plane {describe_plane(plane)}: {len(images):,} of {len(curves):,} curves "
        "have an image, the others lie in the plane"
    )
    off = float(np.abs(heights[on_plane]).max())
    if off > 0.0:
        note += f"; ends were moved onto it by up to {off:.3g}"
    whole = CurveNetwork((*curves, *images), nodes, tuple(cycles))
    return Drawing(whole, stages, (*drawing.notes, note))


def _refuse_both_sides(network: CurveNetwork, plane: Plane, reach: float) -> None:
    beyond = [
        (float(-plane.heights(curve.points).min()), str(curve.id)) for curve in network.curves
    ]
    beyond = [one for one in beyond if one[0] > reach]
    if beyond:
        names = ", ".join(dict.fromkeys(name for _, name in beyond[:5]))
        raise InvalidNetworkError(
            f"{len(beyond):,} curves go beyond the plane {describe_plane(plane)}, by up to "
            f"{max(beyond)[0]:.3g}: {names}; leave out one half of the sketch, or name another "
            "plane"
        )


def _lay_curve(curve: Curve, nodes: Points, plane: Plane, reach: float) -> tuple[Curve, bool]:
    """The curve with its ends at the moved nodes, on one side of the plane; does it lie in it?"""
    first, last = (nodes[node] for node in curve.nodes)
    flat = bool((np.abs(plane.heights(curve.points)) <= reach).all())
    below = np.full(len(curve.points), flat) | (plane.heights(curve.points) < 0.0)
    if not below.any() and np.array_equal(curve.points[[0, -1]], [first, last]):
        return curve, flat
    laid = np.where(below[:, None], plane.flatten(curve.points), curve.points)
    points = move_ends(drop_repeats(laid), first, last)
    normals = curve.normals
    if normals is not None and len(points) != len(curve.points):
        normals = find_nearest_normals(curve.points, normals, points)
    return replace(curve, points=points, normals=normals), flat


def _name_image(name: CurveId, taken: set[str]) -> str:
    image = f"{name}_mirrored"
    while image in taken:
        image += "_"
    return image
