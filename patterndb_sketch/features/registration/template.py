"""Templates: quad meshes whose feature vertices follow the curves of a network, and the mirror
image in the plane y = 0 that makes a whole shape of a half.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.joints import CurveJoint, JoinedFeatures

MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """A quad mesh without places: the same vertices and quads for every model.

    quads:    (q, 4) int32, counter-clockwise from outside.
    of_part:  (v,) int32, the part that each vertex belongs to.
    chains:   the features; their vertices are the feature vertices.
    plane:    (v,) bool, vertices in the plane y = 0, where the half is mirrored; none of a
              template that is not half of something.
    bridged:  curves that a network may lack: a straight line takes their place.

    Raises InvalidFeatureError for what is no such template.
    """

    name: str
    quads: Int32Array
    parts: tuple[TemplatePart, ...]
    of_part: Int32Array
    chains: tuple[FeatureChain, ...]
    plane: Bools
    bridged: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_template(self)

    @property
    def n_vertices(self) -> int:
        return len(self.of_part)

    @property
    def fixed(self) -> Bools:
        """(v,) bool, is it a feature vertex?"""
        result = np.zeros(self.n_vertices, np.bool_)
        for chain in self.chains:
            result[chain.vertices] = True
        return result

    @property
    def mirrored(self) -> bool:
        """Is it half of something?"""
        return bool(self.plane.any())

    @property
    def curves(self) -> tuple[str, ...]:
        """The curves that it asks for, those that may be bridged included."""
        return tuple(dict.fromkeys(step.curve for chain in self.chains for step in chain.steps))

    def joints(self, there: Sequence[str]) -> tuple[CurveJoint, ...]:
        """The corners, of the curves that are there; those of one curve alone are left out."""
        meeting: dict[str, dict[str, None]] = {}
        for chain in self.chains:
            for step in chain.steps:
                if step.curve in there or step.curve not in self.bridged:
                    for corner in (step.start, step.end):
                        meeting.setdefault(corner, {})[step.curve] = None
        return tuple(CurveJoint(name, tuple(curves)) for name, curves in meeting.items())

    def in_plane(self) -> tuple[set[str], set[str]]:
        """The curves and the corners that lie in the plane y = 0."""
        chains = [chain for chain in self.chains if self.plane[chain.vertices].all()]
        steps = [step for chain in chains for step in chain.steps]
        corners = {corner for step in steps for corner in (step.start, step.end)}
        for chain in self.chains:
            ends = (
                (chain.vertices[0], chain.steps[0].start),
                (chain.vertices[-1], chain.steps[-1].end),
            )
            corners |= {corner for vertex, corner in ends if self.plane[vertex]}
        return {step.curve for step in steps}, corners

    def adjacency(self) -> csr_array:
        """(v, v) 1 where two vertices share an edge."""
        tail, head = list_edges(self.quads).T
        ones = np.ones(2 * len(tail))
        both = np.r_[tail, head], np.r_[head, tail]
        return coo_array((ones, both), (self.n_vertices, self.n_vertices)).tocsr()

    @property
    def hollow(self) -> Bools:
        """(v,) bool, is the vertex of a hollow part?"""
        return np.array([part.hollow for part in self.parts], np.bool_)[self.of_part]

    def part_quads(self, part: str) -> Int32Array:
        """(k, 4) the quads of a part."""
        number = [one.name for one in self.parts].index(part)
        return self.quads[self.of_part[self.quads[:, 0]] == number]


@dataclass(frozen=True, slots=True, eq=False)
class FeatureChain:
    """A feature of a template: vertices (n,) int32, n >= 2, joined by its edges in turn.

    They follow the steps at equal arc length, from corner to corner. A closed feature, n >= 4, ends
    at the vertex and the corner that it begins at: it goes once round a closed curve, or along
    several curves.
    """

    name: str
    vertices: Int32Array
    steps: tuple[ChainStep, ...]


@dataclass(frozen=True, slots=True)
class ChainStep:
    """Along a curve of a network from one of its corners to another."""

    curve: str
    start: str
    end: str


@dataclass(frozen=True, slots=True)
class TemplatePart:
    """A component.

    yields_to: those that hide parts of it, as a roof hides a body's top.
    hollow:    is it a well seen from inside, as a wheelhouse?
    """

    name: str
    yields_to: tuple[str, ...] = ()
    hollow: bool = False


def list_edges(quads: Int32Array) -> Int32Array:
    """(e, 2) the edges of quads (q, 4), each once, the lower vertex first."""
    pairs = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def sample_features(template: Template, network: JoinedFeatures) -> tuple[Points, tuple[str, ...]]:
    """The places (v, 3) of the feature vertices, nan for others; and notes.

    A chain's vertices are at equal arc length along its curves; those at corners are the
    network's nodes to the last bit.

    Source: feature curve recovery paper, section 5.1.2.
    """
    points = np.full((template.n_vertices, 3), np.nan)
    lacking: dict[str, None] = {}
    for chain in template.chains:
        there = [step.curve in network.curves for step in chain.steps]
        lacking |= {s.curve: None for s, one in zip(chain.steps, there, strict=True) if not one}
        points[chain.vertices] = _along(chain, network, there)
    notes = tuple(f"there is no curve {name}: a straight line takes its place" for name in lacking)
    return points, notes


def _along(chain: FeatureChain, network: JoinedFeatures, there: list[bool]) -> Points:
    lengths: list[float] = []
    tables: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    for step, drawn in zip(chain.steps, there, strict=True):
        if drawn:
            tables.append(network.interval(step.curve, step.start, step.end))
        else:
            gap = network.nodes[step.end] - network.nodes[step.start]
            tables.append((np.array([0.0, 1.0]), np.array([0.0, np.linalg.norm(gap)])))
        lengths.append(float(tables[-1][1][-1]))
    begin = np.r_[0.0, np.cumsum(lengths)]
    wanted = np.linspace(0.0, begin[-1], len(chain.vertices))
    piece = np.clip(np.searchsorted(begin, wanted, "right") - 1, 0, len(lengths) - 1)
    points = np.empty((len(wanted), 3))
    for k, (step, drawn) in enumerate(zip(chain.steps, there, strict=True)):
        mine = piece == k
        t = np.interp(wanted[mine] - begin[k], tables[k][1], tables[k][0])
        if drawn:
            points[mine] = network.curves[step.curve](t)
        else:
            a, b = network.nodes[step.start], network.nodes[step.end]
            points[mine] = a + t[:, None] * (b - a)
    points[0] = network.nodes[chain.steps[0].start]
    points[-1] = network.nodes[chain.steps[-1].end]
    return points


def find_parts(quads: ArrayLike, n_vertices: int) -> Int32Array:
    """(v,) int32, the connected part of every vertex, in the order of their first vertices."""
    tail, head = list_edges(np.asarray(quads, np.int32)).T
    graph = coo_array((np.ones(len(tail), np.int8), (tail, head)), (n_vertices, n_vertices))
    label = connected_components(graph, directed=False)[1]
    _, first, name = np.unique(label, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first)).astype(np.int32)[name]


def check_template(template: Template) -> None:
    """Raises InvalidFeatureError, with what would mend it, for a template that is none."""
    quads, v = template.quads, template.n_vertices
    if quads.ndim != 2 or quads.shape[1:] != (4,) or not len(quads):
        raise InvalidFeatureError(f"a template needs quads (q, 4), got {quads.shape}")
    if quads.min() < 0 or quads.max() >= v:
        raise InvalidFeatureError(f"a quad of the template names a vertex outside 0..{v - 1}")
    unused = np.setdiff1d(np.arange(v), quads)
    if len(unused):
        raise InvalidFeatureError(f"vertex {unused[0]} of the template is in no quad; leave it out")
    directed = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    different, count = np.unique(directed, axis=0, return_counts=True)
    if (different[:, 0] == different[:, 1]).any() or (count > 1).any():
        k = int(np.argmax((count > 1) | (different[:, 0] == different[:, 1])))
        a, b = different[k].tolist()
        raise InvalidFeatureError(
            f"the edge {a}-{b} of the template is run through twice in one sense: quads must be "
            "turned alike, and meet two at an edge"
        )
    if template.plane.shape != (v,):
        raise InvalidFeatureError(f"plane must be ({v},) bool, got {template.plane.shape}")
    _check_chains(template)
    fixed = template.fixed
    names = [part.name for part in template.parts]
    if len(set(names)) < len(names):
        raise InvalidFeatureError(f"two parts of the template have one name: {', '.join(names)}")
    for part in template.parts:
        for other in part.yields_to:
            if other not in names or other == part.name:
                raise InvalidFeatureError(
                    f"the part {part.name} yields to {other!r}; parts are {', '.join(names)}"
                )
    connected = find_parts(quads, v)
    loose = np.setdiff1d(connected, connected[fixed])
    if len(loose):
        vertex = int(np.flatnonzero(connected == loose[0])[0])
        raise InvalidFeatureError(
            f"no feature holds the part of the template around vertex {vertex}; give it one"
        )


def _check_chains(template: Template) -> None:
    v = template.n_vertices
    there = {tuple(edge) for edge in list_edges(template.quads).tolist()}
    corner_of: dict[int, str] = {}
    inner: dict[int, str] = {}
    if not template.chains:
        raise InvalidFeatureError("a template needs features; name chains of its vertices")
    names = [chain.name for chain in template.chains]
    for name in names:
        if names.count(name) > 1:
            raise InvalidFeatureError(f"two features of the template have the name {name}")
    for chain in template.chains:
        ids = chain.vertices.tolist()
        closed = len(ids) > 3 and ids[0] == ids[-1]
        if len(ids) < 2 or len(set(ids)) < len(ids) - closed or not chain.steps:
            raise InvalidFeatureError(
                f"the feature {chain.name} needs two vertices or more, each once but for the first "
                "of four or more at its end again, and a curve"
            )
        if min(ids) < 0 or max(ids) >= v:
            raise InvalidFeatureError(f"the feature {chain.name} names a vertex outside 0..{v - 1}")
        for a, b in pairwise(ids):
            if (min(a, b), max(a, b)) not in there:
                raise InvalidFeatureError(
                    f"the feature {chain.name} goes from vertex {a} to {b}: there is no such edge"
                )
        for one, two in pairwise(chain.steps):
            if one.end != two.start:
                raise InvalidFeatureError(
                    f"the feature {chain.name} goes along {one.curve} to {one.end}, and on from "
                    f"{two.start}; name one corner"
                )
        for vertex, corner in ((ids[0], chain.steps[0].start), (ids[-1], chain.steps[-1].end)):
            if corner_of.setdefault(vertex, corner) != corner:
                raise InvalidFeatureError(
                    f"vertex {vertex} of the template is at {corner_of[vertex]} and at {corner}"
                )
        for vertex in ids[1:-1]:
            if inner.setdefault(vertex, chain.name) != chain.name:
                raise InvalidFeatureError(
                    f"the features {inner[vertex]} and {chain.name} cross at vertex {vertex}; "
                    "end them there, at a corner"
                )
    both = sorted(set(inner) & set(corner_of))
    if both:
        raise InvalidFeatureError(
            f"the feature {inner[both[0]]} runs through vertex {both[0]}, which is the corner "
            f"{corner_of[both[0]]}; end it there"
        )


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
