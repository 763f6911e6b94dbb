"""Templates of boxes: a car's roof, body and wheelhouses as grids between the feature curves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from patterndb_sketch.features.bodies.network import BOXES, Box, BoxEdge
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import Chain, Part, Step, Template

#: Vertices along an edge of a box: with the fewest a face is one quad; with the most a car has a
#: quarter of a million vertices.
LEAST, MOST = 2, 128

#: What hides parts of what.
YIELDS = {"body": ("roof", "front_wheelhouse", "rear_wheelhouse")}

#: What is seen from inside.
HOLLOW = ("front_wheelhouse", "rear_wheelhouse")

#: Corners where one curve of an edge goes on as the next, by the two curves.
BREAKS = {
    ("hood_profile", "cabin_profile"): "windscreen_base_centre",
    ("cabin_profile", "deck_profile"): "rear_window_base_centre",
    ("sill_front", "front_opening"): "front_arch_front_foot",
    ("front_opening", "sill_middle"): "front_arch_rear_foot",
    ("sill_middle", "rear_opening"): "rear_arch_front_foot",
    ("rear_opening", "sill_rear"): "rear_arch_rear_foot",
}

#: Curves that other components hide: nobody can draw them.
HIDDEN = ("cabin_profile", "front_opening", "rear_opening")

#: Names of the features that follow several curves; others have their curve's name, and a number
#: if there are several to a curve.
TOGETHER = {
    ("hood_profile", "cabin_profile", "deck_profile"): "upper_profile",
    ("sill_front", "front_opening", "sill_middle", "rear_opening", "sill_rear"): "sill",
}

#: How the corners in the middle plane are named.
CENTRE = "_centre"

#: The components by name.
COMPONENTS: dict[str, Box] = {box.component: box for box in BOXES}


def box_template(
    r: int, along: int | None = None, components: Sequence[str] = tuple(COMPONENTS)
) -> Template:
    """The template of the driver's half of a car, or of some of its components.

    r:     vertices along every edge of a box, its ends included.
    along: the same for the edges along the car, which are the longest; by default r.
    The roof has four faces, the body five, each wheelhouse four. Of (roof, body, wheelhouses) with
    r = along there are 32 + 45 (r - 2) + 17 (r - 2)^2 vertices.

    Source: feature curve recovery paper, section 5.1.2 and figure 7. Raises InvalidFeatureError
    for resolutions that are too low or too high and for components that are not there.
    """
    along = r if along is None else along
    for name, value in (("r", r), ("along", along)):
        if not LEAST <= value <= MOST:
            raise InvalidFeatureError(f"{name} is {value}; give {LEAST} to {MOST} vertices")
    unknown = [name for name in components if name not in COMPONENTS]
    if unknown or not components or len(set(components)) < len(components):
        raise InvalidFeatureError(
            f"components are {', '.join(COMPONENTS)}, each at most once; got {list(components)}"
        )
    quads: list[np.ndarray] = []
    chains: list[Chain] = []
    plane: list[np.ndarray] = []
    owner: list[np.ndarray] = []
    first = 0
    for number, name in enumerate(components):
        grid = _Grid(COMPONENTS[name], r, along, first)
        quads.append(np.concatenate(grid.faces))
        chains += grid.chains()
        mask = np.zeros(grid.count, np.bool_)
        for edge, vertices in grid.edges.items():
            mask[vertices - first] |= all(corner.endswith(CENTRE) for corner in edge)
        plane.append(mask)
        owner.append(np.full(grid.count, number, np.int32))
        first += grid.count
    parts = tuple(
        Part(name, tuple(one for one in YIELDS.get(name, ()) if one in components), name in HOLLOW)
        for name in components
    )
    title = "car" if tuple(components) == tuple(COMPONENTS) else "+".join(components)
    size = f"r={r}" if along == r else f"r={r}&along={along}"
    curves = {step.curve for chain in chains for step in chain.steps}
    return Template(
        f"box:{title}?{size}",
        np.concatenate(quads).astype(np.int32),
        parts,
        np.concatenate(owner),
        tuple(chains),
        np.concatenate(plane),
        tuple(name for name in HIDDEN if name in curves),
    )


def template_of_name(name: str) -> Template:
    """The built-in template of a name such as box:car?r=11, box:roof?r=8&along=16.

    What is before ? is car or components joined by +; r is 11 if it is left out. Raises
    InvalidFeatureError for other names.
    """
    head, _, tail = name.partition("?")
    kind, _, what = head.partition(":")
    if kind != "box" or not what:
        raise InvalidFeatureError(
            f"{name!r} is no built-in template; box:car?r=11 is one, and box:roof+body?r=8&along=16"
        )
    sizes: dict[str, int] = {"r": 11}
    for entry in tail.split("&") if tail else ():
        key, _, value = entry.partition("=")
        if key not in ("r", "along") or not (value.isascii() and value.isdigit()):
            raise InvalidFeatureError(f"{entry!r} in {name!r} is neither r=NUMBER nor along=NUMBER")
        sizes[key] = int(value)
    components = tuple(COMPONENTS) if what == "car" else tuple(what.split("+"))
    return box_template(sizes["r"], sizes.get("along"), components)


class _Grid:
    """The vertices of one box: corners, then those within edges, then those within faces."""

    def __init__(self, box: Box, r: int, along: int, first: int) -> None:
        self.box = box
        used = dict.fromkeys(corner for face in box.faces for corner in face.corners)
        corner = {name: first + i for i, name in enumerate(used)}
        sizes = _sizes(box, r, along)
        self.edges: dict[tuple[str, str], np.ndarray] = {}
        top = first + len(corner)
        for edge in box.edges:
            inside = np.arange(top, top + sizes[edge.start, edge.end] - 2)
            ends = corner[edge.start], corner[edge.end]
            self.edges[edge.start, edge.end] = np.r_[ends[0], inside, ends[1]]
            top += len(inside)
        self.faces: list[np.ndarray] = []
        for face in box.faces:
            a, b, c, d = face.corners
            bottom, right, upper, left = (
                self.side(*ends) for ends in ((a, b), (b, c), (d, c), (a, d))
            )
            grid = np.empty((len(bottom), len(right)), np.int64)
            inner = np.arange(top, top + max(grid.shape[0] - 2, 0) * max(grid.shape[1] - 2, 0))
            grid[1:-1, 1:-1] = inner.reshape(grid.shape[0] - 2, grid.shape[1] - 2)
            grid[:, 0], grid[:, -1], grid[0], grid[-1] = bottom, upper, left, right
            top += len(inner)
            cells = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
            self.faces.append(np.stack(cells, axis=-1).reshape(-1, 4))
        self.count = top - first

    def side(self, start: str, end: str) -> np.ndarray:
        """The vertices of the edge from a corner to another."""
        if (start, end) in self.edges:
            return self.edges[start, end]
        return self.edges[end, start][::-1]

    def chains(self) -> list[Chain]:
        curves = [edge.curves[0] for edge in self.box.edges]
        result: list[Chain] = []
        for i, edge in enumerate(self.box.edges):
            name = TOGETHER.get(edge.curves, curves[i])
            if curves.count(name) > 1:
                name = f"{name}/{1 + curves[:i].count(name)}"
            vertices = self.edges[edge.start, edge.end].astype(np.int32)
            result.append(Chain(name, vertices, _steps(edge)))
        return result


def _steps(edge: BoxEdge) -> tuple[Step, ...]:
    corners = [edge.start, *(BREAKS[pair] for pair in pairwise(edge.curves)), edge.end]
    return tuple(
        Step(curve, start, end)
        for curve, (start, end) in zip(edge.curves, pairwise(corners), strict=True)
    )


def _sizes(box: Box, r: int, along: int) -> dict[tuple[str, str], int]:
    """Vertices of every edge: opposite sides of a face have the same number."""
    edges = [(edge.start, edge.end) for edge in box.edges]
    group = {edge: i for i, edge in enumerate(edges)}

    def known(a: str, b: str) -> tuple[str, str]:
        return (a, b) if (a, b) in group else (b, a)

    for _ in edges:
        for face in box.faces:
            a, b, c, d = face.corners
            sides = known(a, b), known(b, c), known(c, d), known(d, a)
            for one, two in ((sides[0], sides[2]), (sides[1], sides[3])):
                group[one] = group[two] = min(group[one], group[two])
    # The second side of a top runs along the car.
    top = next(face for face in box.faces if face.name == "top")
    long = group[known(top.corners[1], top.corners[2])]
    return {edge: along if group[edge] == long else r for edge in edges}
