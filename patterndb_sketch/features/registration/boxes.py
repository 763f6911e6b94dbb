"""Templates of boxes: a grid over every face of the boxes that feature curves make of a shape.

The network of feature curves is the same for every car, and so are the boxes that it makes: they
are data, in car.json. Every component is a box, open where it joins others: the roof below, the
wheelhouses to the side and to the ground; a half is open in the middle plane too, as the roof and
the body are. A box's edge is an interval of one curve, or of several that follow each other,
between two corners; a corner is where curves meet, and so known once the curves are.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.resources import files

import msgspec
import numpy as np

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import (
    ChainStep,
    FeatureChain,
    Template,
    TemplatePart,
)

#: Vertices along an edge of a box: with the fewest a face is one quad; with the most a car has a
#: quarter of a million vertices.
LEAST, MOST = 2, 128


class BoxEdge(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An edge of a box, from corner to corner along curves.

    walk: a corner, a curve, a corner, and so on; every curve in the direction of the walk.
    name: of the feature along the edge; by default the first curve's.
    """

    walk: tuple[str, ...]
    name: str = ""

    @property
    def ends(self) -> tuple[str, str]:
        """The corners where it begins and ends."""
        return self.walk[0], self.walk[-1]

    @property
    def curves(self) -> tuple[str, ...]:
        """The curves that it follows, in order."""
        return self.walk[1::2]

    @property
    def steps(self) -> tuple[ChainStep, ...]:
        """The interval of every curve that it follows."""
        return tuple(
            ChainStep(curve, start, end)
            for start, curve, end in zip(
                self.walk[:-1:2], self.curves, self.walk[2::2], strict=True
            )
        )


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The template of a component: at most six faces, at most twelve edges, eight corners.

    corners:   by name, the curves that meet there, the first of which ends there.
    faces:     by name, four corners, counter-clockwise seen from outside of the body (from within
               the well, for a hollow one). An edge joins every two that follow each other.
    open:      the names of the faces that it lacks.
    along:     the ends of an edge that runs along the car, the longest way.
    middle:    the corners in the plane y = 0, where a half is mirrored.
    yields_to: the components that hide parts of it.
    hollow:    whether it is seen from inside.
    """

    component: str
    corners: dict[str, tuple[str, ...]]
    edges: tuple[BoxEdge, ...]
    faces: dict[str, tuple[str, str, str, str]]
    open: tuple[str, ...]
    along: tuple[str, str]
    middle: tuple[str, ...] = ()
    yields_to: tuple[str, ...] = ()
    hollow: bool = False


class BoxModel(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The boxes of a kind of shape.

    hidden: curves that other components hide: nobody can draw them.
    """

    name: str
    hidden: tuple[str, ...]
    boxes: tuple[Box, ...]

    @property
    def components(self) -> tuple[str, ...]:
        """The names of the components."""
        return tuple(box.component for box in self.boxes)

    @property
    def corners(self) -> dict[str, tuple[str, ...]]:
        """The corners of all boxes, with the curves that meet there."""
        return {name: curves for box in self.boxes for name, curves in box.corners.items()}


@cache
def read_car() -> BoxModel:
    """Read the boxes of a car, which come with the package."""
    data = files("patterndb_sketch.features.registration").joinpath("car.json").read_bytes()
    return msgspec.json.decode(data, type=BoxModel)


def box_template(
    r: int, along: int | None = None, components: Sequence[str] | None = None
) -> Template:
    """Return the template of the driver's half of a car, or of some of its components.

    r:     vertices along every edge of a box, its ends included.
    along: the same for the edges along the car, which are the longest; by default r.
    The roof has four faces, the body five, each wheelhouse four. Of (roof, body, wheelhouses) with
    r = along there are 32 + 45 (r - 2) + 17 (r - 2)^2 vertices.

    Source: feature curve recovery paper, section 5.1.2 and figure 7. Raises InvalidFeatureError
    for resolutions that are too low or too high and for components that are not there.
    """
    car = read_car()
    known = {box.component: box for box in car.boxes}
    chosen = car.components if components is None else tuple(components)
    along = r if along is None else along
    for name, value in (("r", r), ("along", along)):
        if not LEAST <= value <= MOST:
            raise InvalidFeatureError(f"{name} is {value}; give {LEAST} to {MOST} vertices")
    unknown = [name for name in chosen if name not in known]
    if unknown or not chosen or len(set(chosen)) < len(chosen):
        raise InvalidFeatureError(
            f"components are {', '.join(known)}, each at most once; got {list(chosen)}"
        )
    quads: list[np.ndarray] = []
    chains: list[FeatureChain] = []
    plane: list[np.ndarray] = []
    owner: list[np.ndarray] = []
    parts: list[TemplatePart] = []
    first = 0
    for number, box in enumerate(known[name] for name in chosen):
        grid = _Grid(box, r, along, first)
        quads.append(np.concatenate(grid.faces))
        chains += grid.chains()
        mask = np.zeros(grid.count, np.bool_)
        for edge, vertices in grid.edges.items():
            mask[vertices - first] |= set(edge) <= set(box.middle)
        plane.append(mask)
        owner.append(np.full(grid.count, number, np.int32))
        yields_to = tuple(name for name in box.yields_to if name in chosen)
        parts.append(TemplatePart(box.component, yields_to, box.hollow))
        first += grid.count
    title = car.name if chosen == car.components else "+".join(chosen)
    size = f"r={r}" if along == r else f"r={r}&along={along}"
    curves = {step.curve for chain in chains for step in chain.steps}
    return Template(
        f"box:{title}?{size}",
        np.concatenate(quads).astype(np.int32),
        tuple(parts),
        np.concatenate(owner),
        tuple(chains),
        np.concatenate(plane),
        tuple(name for name in car.hidden if name in curves),
    )


def template_of_name(name: str) -> Template:
    """Return the built-in template of a name such as box:car?r=11, box:roof?r=8&along=16.

    Before ? stands car or components joined by +; r is 11 if it is left out. Raises
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
    components = None if what == read_car().name else what.split("+")
    return box_template(sizes["r"], sizes.get("along"), components)


class _Grid:
    """The vertices of one box: corners, then those within edges, then those within faces."""

    def __init__(self, box: Box, r: int, along: int, first: int) -> None:
        self.box = box
        used = dict.fromkeys(corner for face in box.faces.values() for corner in face)
        corner = {name: first + i for i, name in enumerate(used)}
        sizes = _sizes(box, r, along)
        self.edges: dict[tuple[str, str], np.ndarray] = {}
        top = first + len(corner)
        for ends in (edge.ends for edge in box.edges):
            inside = np.arange(top, top + sizes[ends] - 2)
            self.edges[ends] = np.r_[corner[ends[0]], inside, corner[ends[1]]]
            top += len(inside)
        self.faces: list[np.ndarray] = []
        for a, b, c, d in box.faces.values():
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
        """Return the vertices of the edge from a corner to another."""
        if (start, end) in self.edges:
            return self.edges[start, end]
        return self.edges[end, start][::-1]

    def chains(self) -> list[FeatureChain]:
        """List the features along the edges, numbered where several follow one curve."""
        names = [edge.name or edge.curves[0] for edge in self.box.edges]
        result: list[FeatureChain] = []
        for i, edge in enumerate(self.box.edges):
            name = names[i]
            if names.count(name) > 1:
                name = f"{name}/{1 + names[:i].count(name)}"
            vertices = self.edges[edge.ends].astype(np.int32)
            result.append(FeatureChain(name, vertices, edge.steps))
        return result


def _sizes(box: Box, r: int, along: int) -> dict[tuple[str, str], int]:
    """Count the vertices of every edge: opposite sides of a face have the same number."""
    edges = [edge.ends for edge in box.edges]
    group = {edge: i for i, edge in enumerate(edges)}

    def known(a: str, b: str) -> tuple[str, str]:
        return (a, b) if (a, b) in group else (b, a)

    for _ in edges:
        for a, b, c, d in box.faces.values():
            sides = known(a, b), known(b, c), known(c, d), known(d, a)
            for one, two in ((sides[0], sides[2]), (sides[1], sides[3])):
                group[one] = group[two] = min(group[one], group[two])
    long = group[known(*box.along)]
    return {edge: along if group[edge] == long else r for edge in edges}
