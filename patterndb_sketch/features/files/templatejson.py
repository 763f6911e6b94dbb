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

from itertools import pairwise

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.system.documents import JsonValue
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import ChainStep, FeatureChain, Template, TemplatePart
from patterndb_sketch.features.registration.template import find_parts

KEYS = ("name", "mesh", "quads", "features", "parts", "plane", "bridged")
FEATURE_KEYS = ("name", "vertices", "curves", "corners")
PART_KEYS = ("name", "vertex", "yields_to", "hollow")


def mesh_name(document: JsonValue) -> str | None:
    """The name of the mesh file that a document asks for, None if it has its quads itself."""
    entries = document.entries(KEYS, 'an object such as {"quads": [...], "features": [...]}')
    if ("mesh" in entries) == ("quads" in entries):
        document.fail('give either "quads", or "mesh", the name of a file that has them')
    return entries["mesh"].text("the name of a mesh file") if "mesh" in entries else None


def template_of(document: JsonValue, mesh: PolygonMesh | None, name: str) -> Template:
    """The template in a document.

    mesh: what is in the file that :func:`mesh_name` gave. name: of the template if the document
    has none. Raises InvalidFeatureError that names the place in the document.
    """
    entries = document.entries(KEYS)
    quads = _quads(entries, mesh)
    v = int(quads.max(initial=-1)) + 1
    if not len(quads):
        document.fail("the template has no quads")
    if quads.min() < 0:
        document.fail("a quad names a vertex below 0; vertices are numbered from 0")
    if "features" not in entries:
        document.fail('"features" is missing: a list with chains of vertices')
    chains = tuple(_chain(one) for one in entries["features"].items())
    parts, of_part = _parts(entries.get("parts"), find_parts(quads, v))
    plane = np.zeros(v, np.bool_)
    for vertex in entries["plane"].items() if "plane" in entries else ():
        plane[_vertex(vertex, v)] = True
    bridged = [one.text() for one in entries["bridged"].items()] if "bridged" in entries else []
    title = entries["name"].text() if "name" in entries else name
    return Template(title, quads, parts, of_part, chains, plane, tuple(bridged))


def template_document(template: Template) -> dict[str, object]:
    """The template as plain JSON has it; :func:`template_of` gives it back."""
    first = [int(np.flatnonzero(template.of_part == i)[0]) for i in range(len(template.parts))]
    document: dict[str, object] = {
        "name": template.name,
        "quads": template.quads.tolist(),
        "features": [
            {
                "name": chain.name,
                "vertices": chain.vertices.tolist(),
                "curves": [step.curve for step in chain.steps],
                "corners": [chain.steps[0].start, *(step.end for step in chain.steps)],
            }
            for chain in template.chains
        ],
        "parts": [
            {
                "name": part.name,
                "vertex": vertex,
                "yields_to": list(part.yields_to),
                "hollow": part.hollow,
            }
            for part, vertex in zip(template.parts, first, strict=True)
        ],
    }
    if template.plane.any():
        document["plane"] = np.flatnonzero(template.plane).tolist()
    if template.bridged:
        document["bridged"] = list(template.bridged)
    return document


def _quads(entries: dict[str, JsonValue], mesh: PolygonMesh | None) -> Int32Array:
    if mesh is not None:
        arities = mesh.arities()
        if (arities != 4).any():
            k = int(np.flatnonzero(arities != 4)[0])
            raise InvalidFeatureError(
                f"face {k} of the template's mesh has {arities[k]} corners; a template is of quads"
            )
        return mesh.corners.reshape(-1, 4).astype(np.int32)
    quads: list[list[int]] = []
    for quad in entries["quads"].items():
        corners = [
            one.whole("the number of a vertex") for one in quad.items("a list of 4 vertices")
        ]
        if len(corners) != 4:
            quad.fail(f"a quad has 4 vertices, not {len(corners)}")
        if max(map(abs, corners)) > np.iinfo(np.int32).max:
            quad.fail("a vertex has too large a number")
        quads.append(corners)
    return np.array(quads, np.int32).reshape(-1, 4)


def _chain(value: JsonValue) -> FeatureChain:
    entries = value.entries(FEATURE_KEYS)
    for key in ("name", "vertices", "corners"):
        if key not in entries:
            value.fail(f'"{key}" is missing; a feature has name, vertices, corners and curves')
    name = entries["name"].text()
    curves = [name]
    if "curves" in entries:
        curves = [one.text("the name of a curve") for one in entries["curves"].items()]
    corners = [one.text("the name of a corner") for one in entries["corners"].items()]
    if len(corners) != len(curves) + 1:
        entries["corners"].fail(
            f"{len(curves)} curves need {len(curves) + 1} corners, from the first's start to the "
            f"last's end; there are {len(corners)}"
        )
    steps = [ChainStep(curve, *ends) for curve, ends in zip(curves, pairwise(corners), strict=True)]
    vertices = [one.whole("the number of a vertex") for one in entries["vertices"].items()]
    if any(not 0 <= vertex <= np.iinfo(np.int32).max for vertex in vertices):
        entries["vertices"].fail("vertices are numbered from 0")
    return FeatureChain(name, np.array(vertices, np.int32), tuple(steps))


def _parts(
    value: JsonValue | None, connected: Int32Array
) -> tuple[tuple[TemplatePart, ...], Int32Array]:
    count = int(connected.max()) + 1
    if value is None:
        return tuple(TemplatePart(f"part {i + 1}") for i in range(count)), connected
    parts: list[TemplatePart] = []
    number = np.full(count, -1, np.int32)
    for i, one in enumerate(value.items()):
        entries = one.entries(PART_KEYS)
        for key in ("name", "vertex"):
            if key not in entries:
                one.fail(f'"{key}" is missing; a part has a name and one of its vertices')
        here = connected[_vertex(entries["vertex"], len(connected))]
        if number[here] >= 0:
            one.fail(f"it is the same part as {parts[number[here]].name}: they are joined by edges")
        number[here] = i
        others = [n.text() for n in entries["yields_to"].items()] if "yields_to" in entries else []
        hollow = "hollow" in entries and entries["hollow"].truth()
        parts.append(TemplatePart(entries["name"].text(), tuple(others), hollow))
    if (number < 0).any():
        vertex = int(np.flatnonzero(connected == np.flatnonzero(number < 0)[0])[0])
        value.fail(f"the part around vertex {vertex} is missing; name every part, or none")
    return tuple(parts), number[connected]


def _vertex(value: JsonValue, v: int) -> int:
    vertex = value.whole("the number of a vertex")
    if not 0 <= vertex < v:
        value.fail(f"there is no vertex {vertex}; the quads name 0..{v - 1}")
    return vertex
