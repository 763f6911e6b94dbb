"""Templates as plain JSON.

    {"name": "dome",
     "quads": [[0, 1, 4, 3], [1, 2, 5, 4], ...],
     "features": [{"name": "rim", "vertices": [0, 1, 2],
                   "curves": ["rim_left", "rim_right"], "corners": ["left", "middle", "right"]},
                  ...],
     "parts": [{"name": "roof", "vertex": 0},
               {"name": "body", "vertex": 40, "yields_to": ["roof"]},
               {"name": "well", "vertex": 90, "hollow": true}],
     "plane": [0, 3, 6],
     "bridged": ["rim_right"]}

quads: counter-clockwise from outside, vertices numbered from 0; or "mesh": "dome.obj", a file
beside this one whose faces are the quads. features: chains of vertices that follow curves of a
network from corner to corner, one corner more than curves; curves is the feature's name if it is
left out. Features end at common vertices and corners. parts: each with one of its vertices, what
hides some of it, and whether it is a well seen from inside; unnamed if left out. plane: vertices
in the plane y = 0, if the template is half of something. bridged: curves that a network may
lack.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import UNSET, Meta, UnsetType
from msgspec import field as entry

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.system.documents import JsonModel, JsonValue, encode_json, read_document
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import (
    ChainStep,
    FeatureChain,
    Template,
    TemplatePart,
    template_of_name,
)
from patterndb_sketch.features.registration.template import find_parts

#: Bytes that a file may have: a template of a million quads has some 40 million.
MAX_BYTES = 64_000_000

#: Reads a mesh file; knows the formats.
MeshReader = Callable[[Path], PolygonMesh]

Vertex = Annotated[int, Meta(description="the number of a vertex")]
Quad = Annotated[
    list[Annotated[int, Meta(ge=-(2**31), le=2**31 - 1, description="the number of a vertex")]],
    Meta(min_length=4, max_length=4, extra={"length": "a quad has 4 vertices"}),
]
CurveName = Annotated[str, Meta(description="the name of a curve")]
CornerName = Annotated[str, Meta(description="the name of a corner")]


class ChainModel(JsonModel, kw_only=True):
    """A feature of a template: vertices that follow curves from corner to corner."""

    name: str
    vertices: list[Vertex]
    curves: list[CurveName] | UnsetType = UNSET
    corners: Annotated[list[CornerName], Meta(extra={"missing": "one more than there are curves"})]


class PartModel(JsonModel):
    """A part of a template, with one of its vertices."""

    name: str
    vertex: Annotated[Vertex, Meta(extra={"missing": "one of the part's vertices"})]
    yields_to: list[str] = entry(default_factory=list)
    hollow: bool = False


class TemplateModel(JsonModel, omit_defaults=True):
    """A template; either quads, or mesh, the name of a file that has them."""

    name: str | UnsetType = UNSET
    mesh: Annotated[str, Meta(description="the name of a mesh file")] | UnsetType = UNSET
    quads: list[Quad] | UnsetType = UNSET
    features: list[ChainModel] | UnsetType = UNSET
    parts: list[PartModel] | UnsetType = UNSET
    plane: list[Vertex] = entry(default_factory=list)
    bridged: list[str] = entry(default_factory=list)

    @classmethod
    def of(cls, template: Template) -> TemplateModel:
        """Return the model of a template, with its quads."""
        first = [int(np.flatnonzero(template.of_part == i)[0]) for i in range(len(template.parts))]
        return cls(
            name=template.name,
            quads=template.quads.tolist(),
            features=[
                ChainModel(
                    name=chain.name,
                    vertices=chain.vertices.tolist(),
                    curves=[step.curve for step in chain.steps],
                    corners=[chain.steps[0].start, *(step.end for step in chain.steps)],
                )
                for chain in template.chains
            ],
            parts=[
                PartModel(part.name, vertex, list(part.yields_to), part.hollow)
                for part, vertex in zip(template.parts, first, strict=True)
            ],
            plane=np.flatnonzero(template.plane).tolist(),
            bridged=list(template.bridged),
        )

    def template(self, place: JsonValue, name: str, read_mesh: MeshReader) -> Template:
        """Return the template; raises the error of its place.

        name: of the template if the document has none. read_mesh: reads the mesh that it names.
        """
        if (self.mesh is UNSET) == (self.quads is UNSET):
            place.fail('give either "quads", or "mesh", the name of a file that has them')
        quads = np.array([] if self.quads is UNSET else self.quads, np.int32).reshape(-1, 4)
        if self.mesh is not UNSET:
            quads = _quads_of(read_mesh(Path(self.mesh)))
        v = int(quads.max(initial=-1)) + 1
        if not len(quads):
            place.fail("the template has no quads")
        if quads.min() < 0:
            place.fail("a quad names a vertex below 0; vertices are numbered from 0")
        if self.features is UNSET:
            place.fail('"features" is missing: a list with chains of vertices')
        chains = tuple(_chain(one, place.at("features", i)) for i, one in enumerate(self.features))
        parts, of_part = self._parts(find_parts(quads, v), place)
        plane = np.zeros(v, np.bool_)
        for i, vertex in enumerate(self.plane):
            _check_vertex(vertex, v, place, ("plane", i))
            plane[vertex] = True
        title = name if self.name is UNSET else self.name
        return Template(title, quads, parts, of_part, chains, plane, tuple(self.bridged))

    def _parts(
        self, connected: Int32Array, place: JsonValue
    ) -> tuple[tuple[TemplatePart, ...], Int32Array]:
        count = int(connected.max()) + 1
        if self.parts is UNSET:
            return tuple(TemplatePart(f"part {i + 1}") for i in range(count)), connected
        number = np.full(count, -1, np.int32)
        for i, one in enumerate(self.parts):
            _check_vertex(one.vertex, len(connected), place, ("parts", i, "vertex"))
            here = connected[one.vertex]
            if number[here] >= 0:
                place.at("parts", i).fail(
                    f"it is the same part as {self.parts[number[here]].name}: they are joined by "
                    "edges"
                )
            number[here] = i
        if (number < 0).any():
            vertex = int(np.flatnonzero(connected == np.flatnonzero(number < 0)[0])[0])
            place.at("parts").fail(
                f"the part around vertex {vertex} is missing; name every part, or none"
            )
        parts = tuple(
            TemplatePart(one.name, tuple(one.yields_to), one.hollow) for one in self.parts
        )
        return parts, number[connected]


def read_template(name: Path | str, read_mesh: MeshReader) -> Template:
    """Return the template of a name such as box:car?r=11, else that in a JSON file.

    See :func:`patterndb_sketch.features.registration.boxes.template_of_name`. read_mesh: reads the
    mesh that the file names. Raises InvalidFeatureError with the file and the place in it, what
    read_mesh does, and OSError.
    """
    if isinstance(name, str) and name.startswith("box:"):
        return template_of_name(name)
    path = Path(name)

    def read(document: JsonValue) -> Template:
        found = document.read(TemplateModel, 'an object such as {"quads": [...], "features": []}')
        return found.template(document, path.stem, lambda mesh: read_mesh(path.parent / mesh))

    return read_document(path, MAX_BYTES, InvalidFeatureError, "a template", read)


def write_template(path: Path | str, template: Template) -> None:
    """Write a template with its quads; :func:`read_template` gives it back. Raises OSError."""
    replace_file(Path(path), encode_json(TemplateModel.of(template)))


def _quads_of(mesh: PolygonMesh) -> Int32Array:
    arities = mesh.arities()
    if (arities != 4).any():
        k = int(np.flatnonzero(arities != 4)[0])
        raise InvalidFeatureError(
            f"face {k} of the template's mesh has {arities[k]} corners; a template is of quads"
        )
    return mesh.corners.reshape(-1, 4).astype(np.int32)


def _chain(model: ChainModel, place: JsonValue) -> FeatureChain:
    curves = [model.name] if model.curves is UNSET else model.curves
    if len(model.corners) != len(curves) + 1:
        place.at("corners").fail(
            f"{len(curves)} curves need {len(curves) + 1} corners, from the first's start to the "
            f"last's end; there are {len(model.corners)}"
        )
    if any(not 0 <= vertex < 2**31 for vertex in model.vertices):
        place.at("vertices").fail("vertices are numbered from 0")
    ends = pairwise(model.corners)
    steps = tuple(ChainStep(curve, *two) for curve, two in zip(curves, ends, strict=True))
    return FeatureChain(model.name, np.array(model.vertices, np.int32), steps)


def _check_vertex(vertex: int, v: int, place: JsonValue, steps: tuple[str | int, ...]) -> None:
    if not 0 <= vertex < v:
        place.at(*steps).fail(f"there is no vertex {vertex}; the quads name 0..{v - 1}")
