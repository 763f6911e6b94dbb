"""Answers to questions about holes of a mesh: its loops, or the fills of one of them."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from ingest.formats import ReadLimits, parse
from ingest.formats.files import assemble
from patterndb.core.polygonmesh import PolygonMesh, flatten_faces
from patterndb.errors import InvalidMeshError
from patterndb.system.documents import JsonModel, Number, complete_points
from patterndb.system.requests import Count, Positive, Text, list_changed, option
from patterndb_app.service.catalogue import ServedDatabase
from patterndb_app.service.limits import Limits
from patterndb_app.service.questions import read_body
from patterndb_app.service.refusals import LargeRequestError, MalformedRequestError
from patterndb_app.service.work import RequestWork
from query.holes import (
    HoleFill,
    MeshTopology,
    choose_hole,
    fill_holes,
    find_holes,
    list_mesh_flaws,
    weld_fills,
)
from query.holes.options import HoleOptions, HoleRequest

#: The most corners of a face, as in files.
MOST_CORNERS = ReadLimits().max_arity

Point = Annotated[list[Number], Meta(min_length=2, max_length=3, description="a point [x, y, z]")]
Face = Annotated[
    list[Count],
    Meta(
        min_length=3,
        max_length=MOST_CORNERS,
        description=f"a face, its 3 to {MOST_CORNERS:,} vertices from 0",
    ),
]

#: Vertices or faces. Named here, for within a class that has an entry ``list`` that is no type.
Numbers = Annotated[list[Count], Meta(min_length=1)]

#: The most fills of a hole where none is asked for.
LIMIT = 5

#: The most fills of a hole.
MOST_FILLS = 100


class MeshEntries(JsonModel):
    """A mesh in a body: points, and faces that name them from 0."""

    points: Annotated[list[Point], Meta(extra={"missing": "a list of points"})]
    faces: Annotated[list[Face], Meta(extra={"missing": "a list of faces"})]


class HoleEntries(HoleRequest, frozen=True, kw_only=True, rename={"only_loops": "list"}):
    """A question about a mesh's holes: without loop and faces, and with list, only its loops."""

    mesh: MeshEntries | None = None
    obj: str | None = None
    loop: Numbers | None = None
    faces: Numbers | None = None
    limit: Annotated[Positive, option("List at most K fills of a hole.")] = LIMIT
    weld: Positive | None = None
    only_loops: bool = False
    db: Text | None = None


def read_hole_question(data: bytes, limits: Limits) -> tuple[HoleEntries, PolygonMesh]:
    """Read the body of a question about holes: what is asked, and the mesh.

    Raises MalformedRequestError for what is no such question, MeshFileError and InvalidMeshError
    for what is no mesh.
    """
    asked = read_body(data, limits, "a question about holes").read(HoleEntries)
    if (asked.mesh is None) == (asked.obj is None):
        raise MalformedRequestError(
            'give the mesh either as "mesh", {"points": [...], "faces": [...]}, or as "obj", the '
            "text of an OBJ file"
        )
    if asked.loop is not None and asked.faces is not None:
        raise MalformedRequestError("name a loop or faces, not both")
    if asked.limit > MOST_FILLS:
        raise LargeRequestError(f"limit is {asked.limit:,}; {MOST_FILLS} are the most for a hole")
    limits_of_file = ReadLimits(max_bytes=limits.mesh_bytes)
    if asked.obj is not None:
        return asked, parse(asked.obj.encode(), "mesh.obj", limits_of_file)
    assert asked.mesh is not None
    points = np.array(complete_points(asked.mesh.points), np.float64).reshape(-1, 3)
    corners, arities = flatten_faces(asked.mesh.faces)
    return asked, assemble(points, corners, arities, "mesh", limits_of_file)


def answer_holes(
    asked: HoleEntries,
    mesh: PolygonMesh,
    database: ServedDatabase,
    limits: Limits,
    work: RequestWork,
) -> dict[str, Any]:
    """The loops of a mesh, or the fills of one of its holes, as ``patterndb holes --json``.

    Raises InvalidMeshError and InvalidQueryError as :func:`query.holes.fill_holes` does.
    """
    topology = MeshTopology.of(mesh)
    notes = list_mesh_flaws(topology)
    if asked.only_loops and asked.loop is None and asked.faces is None:
        return {"holes": [hole.to_json() for hole in find_holes(topology)], "notes": notes}
    hole = choose_hole(topology, loop=asked.loop, faces=asked.faces)
    if len(hole) > limits.perimeter:
        raise LargeRequestError(
            f"the loop has {len(hole):,} edges; {limits.perimeter:,} are the most"
        )
    seconds = min(asked.time_limit or limits.seconds, limits.seconds)
    options: dict[str, Any] = {
        **list_changed(asked),
        "limit": asked.limit,
        "time_limit": seconds,
        "threads": 1,
    }
    found = fill_holes(database.opened, hole, HoleOptions(**options))
    fills: list[HoleFill] = []
    for fill in found:
        fills.append(fill)
        if work.stopped is not None:
            break
    document: dict[str, Any] = {"holes": [found.to_json(fills)], "notes": notes}
    if asked.weld is not None:
        if asked.weld > len(fills):
            ended = "" if found.complete else f"; the search was not complete ({found.stopped})"
            raise InvalidMeshError(f"no fill {asked.weld} was found, only {len(fills)}{ended}")
        welded = weld_fills([fills[asked.weld - 1]])
        document["mesh"] = {"points": welded.points.tolist(), "faces": welded.faces()}
    return document
