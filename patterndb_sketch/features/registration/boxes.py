"""Templates of boxes: a car's roof, body and wheelhouses as grids between the feature curves.

The network of feature curves is the same for every car, and so are the boxes that it makes
(BOXES). Every component is a box, open where it joins others: the roof below, the wheelhouses to
the side and to the ground; a half is open in the middle plane too, as the roof and the body are.
A box's edge is an interval of one curve, or of several that follow each other, between two
corners; a corner is where curves meet, and so known once the curves are. A template
(box_template) lays a grid over every face of the boxes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import (
    ChainStep,
    FeatureChain,
    Template,
    TemplatePart,
)

#: The parts of a car that a template has a box for.
Component = Literal["roof", "body", "front_wheelhouse", "rear_wheelhouse"]


@dataclass(frozen=True, slots=True)
class BoxCorner:
    """A point of the network: curves that meet there, the first of which ends there."""

    name: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BoxEdge:
    """From the corner start to the corner end, along the curves in this order and direction."""

    start: str
    end: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BoxFace:
    """Four corners, counter-clockwise seen from outside of the body (from within the well, for
    a wheelhouse). An edge joins every two that follow each other."""

    name: str
    corners: tuple[str, str, str, str]


@dataclass(frozen=True, slots=True)
class Box:
    """The template of a component: at most six faces, at most twelve edges, eight corners.

    open: the names of the faces that it lacks. The middle plane's is open on roof and body.
    """

    component: Component
    edges: tuple[BoxEdge, ...]
    faces: tuple[BoxFace, ...]
    open: tuple[str, ...]


def _roof() -> tuple[list[BoxCorner], Box]:
    corners = [
        BoxCorner("windscreen_base_centre", ("windscreen_base", "windscreen_profile")),
        BoxCorner("roof_front_centre", ("roof_front", "windscreen_profile", "roof_profile")),
        BoxCorner("roof_rear_centre", ("roof_rear", "rear_window_profile", "roof_profile")),
        BoxCorner("rear_window_base_centre", ("rear_window_base", "rear_window_profile")),
        BoxCorner("a_pillar_base", ("a_pillar", "windscreen_base", "belt_line")),
        BoxCorner("a_pillar_top", ("a_pillar", "roof_front", "roof_rail")),
        BoxCorner("c_pillar_top", ("c_pillar", "roof_rear", "roof_rail")),
        BoxCorner("c_pillar_base", ("c_pillar", "rear_window_base", "belt_line")),
    ]
    edges = (
        BoxEdge("windscreen_base_centre", "a_pillar_base", ("windscreen_base",)),
        BoxEdge("roof_front_centre", "a_pillar_top", ("roof_front",)),
        BoxEdge("roof_rear_centre", "c_pillar_top", ("roof_rear",)),
        BoxEdge("rear_window_base_centre", "c_pillar_base", ("rear_window_base",)),
        BoxEdge("a_pillar_base", "a_pillar_top", ("a_pillar",)),
        BoxEdge("a_pillar_top", "c_pillar_top", ("roof_rail",)),
        BoxEdge("c_pillar_base", "c_pillar_top", ("c_pillar",)),
        BoxEdge("a_pillar_base", "c_pillar_base", ("belt_line",)),
        BoxEdge("windscreen_base_centre", "roof_front_centre", ("windscreen_profile",)),
        BoxEdge("roof_front_centre", "roof_rear_centre", ("roof_profile",)),
        BoxEdge("rear_window_base_centre", "roof_rear_centre", ("rear_window_profile",)),
    )
    faces = (
        BoxFace("front", (
            "windscreen_base_centre", "a_pillar_base", "a_pillar_top", "roof_front_centre")),
        BoxFace("top", ("roof_front_centre", "a_pillar_top", "c_pillar_top", "roof_rear_centre")),
        BoxFace("rear", (
            "c_pillar_base", "rear_window_base_centre", "roof_rear_centre", "c_pillar_top")),
        BoxFace("side", ("a_pillar_base", "c_pillar_base", "c_pillar_top", "a_pillar_top")),
    )  # fmt: skip
    return corners, Box("roof", edges, faces, ("bottom", "middle"))


def _body() -> tuple[list[BoxCorner], Box]:
    corners = [
        BoxCorner("nose_bottom_centre", ("front_bottom", "front_profile", "bottom_profile")),
        BoxCorner("nose_top_centre", ("hood_edge", "front_profile", "hood_profile")),
        BoxCorner("tail_top_centre", ("deck_edge", "rear_profile", "deck_profile")),
        BoxCorner("tail_bottom_centre", ("rear_bottom", "rear_profile", "bottom_profile")),
        BoxCorner("nose_bottom_side", ("front_corner", "front_bottom", "sill_front")),
        BoxCorner("nose_top_side", ("front_corner", "hood_edge", "shoulder")),
        BoxCorner("tail_top_side", ("rear_corner", "deck_edge", "shoulder")),
        BoxCorner("tail_bottom_side", ("rear_corner", "rear_bottom", "sill_rear")),
    ]
    sill = ("sill_front", "front_opening", "sill_middle", "rear_opening", "sill_rear")
    edges = (
        BoxEdge("nose_bottom_centre", "nose_bottom_side", ("front_bottom",)),
        BoxEdge("nose_top_centre", "nose_top_side", ("hood_edge",)),
        BoxEdge("tail_top_centre", "tail_top_side", ("deck_edge",)),
        BoxEdge("tail_bottom_centre", "tail_bottom_side", ("rear_bottom",)),
        BoxEdge("nose_bottom_side", "nose_top_side", ("front_corner",)),
        BoxEdge("nose_top_side", "tail_top_side", ("shoulder",)),
        BoxEdge("tail_bottom_side", "tail_top_side", ("rear_corner",)),
        BoxEdge("nose_bottom_side", "tail_bottom_side", sill),
        BoxEdge("nose_bottom_centre", "nose_top_centre", ("front_profile",)),
        BoxEdge(
            "nose_top_centre", "tail_top_centre", ("hood_profile", "cabin_profile", "deck_profile")
        ),
        BoxEdge("tail_bottom_centre", "tail_top_centre", ("rear_profile",)),
        BoxEdge("nose_bottom_centre", "tail_bottom_centre", ("bottom_profile",)),
    )
    faces = (
        BoxFace("front", (
            "nose_bottom_centre", "nose_bottom_side", "nose_top_side", "nose_top_centre")),
        BoxFace("top", ("nose_top_centre", "nose_top_side", "tail_top_side", "tail_top_centre")),
        BoxFace("rear", (
            "tail_bottom_side", "tail_bottom_centre", "tail_top_centre", "tail_top_side")),
        BoxFace("side", ("nose_bottom_side", "tail_bottom_side", "tail_top_side", "nose_top_side")),
        BoxFace("bottom", (
            "nose_bottom_side", "nose_bottom_centre", "tail_bottom_centre", "tail_bottom_side")),
    )  # fmt: skip
    return corners, Box("body", edges, faces, ("middle",))


def _wheelhouse(name: str, component: Component) -> tuple[list[BoxCorner], Box]:
    def the(curve: str) -> str:
        return f"{name}_{curve}"

    arch, inner = the("arch"), the("inner_arch")
    front, rear = the("tub_front"), the("tub_rear")
    bends = the("bend_front"), the("bend_rear")
    sills = ("sill_front", "sill_middle") if name == "front" else ("sill_middle", "sill_rear")
    corners = [
        BoxCorner(the("arch_front_foot"), (front, arch, sills[0])),
        BoxCorner(the("arch_front_bend"), (bends[0], arch)),
        BoxCorner(the("arch_rear_bend"), (bends[1], arch)),
        BoxCorner(the("arch_rear_foot"), (rear, arch, sills[1])),
        BoxCorner(the("inner_front_foot"), (front, inner, the("inner_sill"))),
        BoxCorner(the("inner_front_bend"), (bends[0], inner)),
        BoxCorner(the("inner_rear_bend"), (bends[1], inner)),
        BoxCorner(the("inner_rear_foot"), (rear, inner, the("inner_sill"))),
    ]
    outer, deep = [c.name for c in corners[:4]], [c.name for c in corners[4:]]
    across = (front, *bends, rear)
    edges = [BoxEdge(outer[i], outer[i + 1], (arch,)) for i in range(3)]
    edges += [BoxEdge(deep[i], deep[i + 1], (inner,)) for i in range(3)]
    edges += [BoxEdge(outer[i], deep[i], (across[i],)) for i in range(4)]
    edges += [BoxEdge(deep[0], deep[3], (the("inner_sill"),))]
    faces = [
        BoxFace(where, (outer[i], deep[i], deep[i + 1], outer[i + 1]))
        for i, where in enumerate(("front", "top", "rear"))
    ]
    faces.append(BoxFace("inner", (deep[0], deep[3], deep[2], deep[1])))
    return corners, Box(component, tuple(edges), tuple(faces), ("bottom", "outer"))


_PARTS = (
    _roof(),
    _body(),
    _wheelhouse("front", "front_wheelhouse"),
    _wheelhouse("rear", "rear_wheelhouse"),
)

#: All corners, by component.
CORNERS: tuple[BoxCorner, ...] = tuple(corner for corners, _ in _PARTS for corner in corners)

#: The four boxes.
BOXES: tuple[Box, ...] = tuple(box for _, box in _PARTS)


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
    chains: list[FeatureChain] = []
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
        TemplatePart(
            name, tuple(one for one in YIELDS.get(name, ()) if one in components), name in HOLLOW
        )
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

    def chains(self) -> list[FeatureChain]:
        curves = [edge.curves[0] for edge in self.box.edges]
        result: list[FeatureChain] = []
        for i, edge in enumerate(self.box.edges):
            name = TOGETHER.get(edge.curves, curves[i])
            if curves.count(name) > 1:
                name = f"{name}/{1 + curves[:i].count(name)}"
            vertices = self.edges[edge.start, edge.end].astype(np.int32)
            result.append(FeatureChain(name, vertices, _steps(edge)))
        return result


def _steps(edge: BoxEdge) -> tuple[ChainStep, ...]:
    corners = [edge.start, *(BREAKS[pair] for pair in pairwise(edge.curves)), edge.end]
    return tuple(
        ChainStep(curve, start, end)
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
