"""patterndb: patterns of hand-made quad meshes, in SQLite, to fill boundaries and holes with quads.

    import patterndb

    with patterndb.open("my.db", "create") as db:
        db.ingest(["head.obj", "hand.obj"])
        for fill in db.fills((3, 5, 4, 6), limit=5):
            print(fill)
        mesh = patterndb.read("cup.obj")
        filled = next(mesh.holes()[0].fills(db)).weld()

A script needs no other import; names are imported on first use. The packages are core (quad disks,
codes, patterns), geometry, store (the database file) and system (files, JSON) here, and ingest,
query, patterndb_sketch and viewer. Only verbs, notebook and this module import from higher ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, overload

try:
    from patterndb._native import __version__ as __version__
except ModuleNotFoundError:
    raise ModuleNotFoundError(
        f"{Path(__file__).parents[1]} has sources of patterndb without the compiled core: there, "
        "'python -m pip install --editable .' builds it; started elsewhere, Python takes a "
        "patterndb that is installed",
        name="patterndb._native",
    ) from None
from patterndb.core.display import Suffix, set_renderer
from patterndb.errors import PatternDBError
from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from ingest.formats import ReadLimits
    from ingest.pipeline import IngestReport, MeshReport
    from patterndb.core.pattern import Pattern
    from patterndb.core.polygonmesh import PolygonMesh
    from patterndb.errors import (
        DatabaseError,
        InvalidBoundaryError,
        InvalidMeshError,
        MeshFileError,
        NotFoundError,
        UnsupportedFormatError,
    )
    from patterndb.geometry.surface import Surface, SurfacePoints
    from patterndb.notebook import Sheet
    from patterndb.store import Database, DatabaseUnion, LearningOptions, Provenance
    from patterndb.store.connection import Mode
    from patterndb_app.client.remote import connect
    from patterndb_sketch.curvenetwork.network import CurveNetwork
    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.surfacing.networkfile import read_network
    from query.boundary import Boundary
    from query.boundaryfile import read_boundary
    from query.errors import InvalidQueryError
    from query.fill import Fill
    from query.holes import Hole, HoleFill, HoleFills, HoleOptions, weld_fills
    from query.listing.fills import Fills
    from query.placing import Placement, enclose_region
    from query.request import FillRequest
    from query.stroke import Stroke

#: What the starter database is called where databases are named by their files.
STARTER_NAME = ":starter:"

__all__ = [
    "Boundary",
    "CurveNetwork",
    "Database",
    "DatabaseError",
    "DatabaseUnion",
    "Fill",
    "FillRequest",
    "Fills",
    "Hole",
    "HoleFill",
    "HoleFills",
    "HoleOptions",
    "IngestReport",
    "InvalidBoundaryError",
    "InvalidMeshError",
    "InvalidQueryError",
    "LearningOptions",
    "MeshFileError",
    "MeshReport",
    "NotFoundError",
    "Pattern",
    "PatternDBError",
    "Placement",
    "PolygonMesh",
    "Provenance",
    "ReadLimits",
    "Retopology",
    "Sheet",
    "Stroke",
    "Surface",
    "SurfacePoints",
    "UnsupportedFormatError",
    "connect",
    "enclose_region",
    "open",
    "read",
    "read_boundary",
    "read_network",
    "weld_fills",
]

#: The module that defines each public name.
_HOMES = {
    "Boundary": "query",
    "CurveNetwork": "patterndb_sketch.curvenetwork.network",
    "Database": "patterndb.store",
    "DatabaseError": "patterndb.errors",
    "DatabaseUnion": "patterndb.store",
    "Fill": "query",
    "FillRequest": "query.request",
    "Fills": "query",
    "Hole": "query.holes",
    "HoleFill": "query.holes",
    "HoleFills": "query.holes",
    "HoleOptions": "query.holes",
    "IngestReport": "ingest.pipeline",
    "InvalidBoundaryError": "patterndb.errors",
    "InvalidMeshError": "patterndb.errors",
    "InvalidQueryError": "query.errors",
    "LearningOptions": "patterndb.store",
    "MeshFileError": "patterndb.errors",
    "MeshReport": "ingest.pipeline",
    "NotFoundError": "patterndb.errors",
    "Pattern": "patterndb.core.pattern",
    "Placement": "query.placing",
    "PolygonMesh": "patterndb.core.polygonmesh",
    "Provenance": "patterndb.store",
    "ReadLimits": "ingest.formats",
    "Retopology": "patterndb_sketch.retopo.editor",
    "Sheet": "patterndb.notebook",
    "Stroke": "query",
    "Surface": "patterndb.geometry.surface",
    "SurfacePoints": "patterndb.geometry.surface",
    "UnsupportedFormatError": "patterndb.errors",
    "connect": "patterndb_app.client.remote",
    "enclose_region": "query.placing",
    "read_boundary": "query.boundaryfile",
    "read_network": "patterndb_sketch.surfacing.networkfile",
    "weld_fills": "query.holes",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)


def _draw(item: Pattern | Fill, suffix: Suffix) -> bytes:
    from patterndb.notebook import draw

    return draw(item, suffix)


set_renderer(_draw)


def read(path: Path | str, *, limits: ReadLimits | None = None) -> PolygonMesh:
    """Read the polygon mesh in a file, by the file's suffix.

    limits: the most that a file may have. Raises MeshFileError, with file, line and token, for a
    file that is damaged, over a limit or without faces; UnsupportedFormatError for a format that is
    unknown or cannot hold quads; MissingExtraError where the extra that reads a format is missing.

    Example: ``patterndb.read("penguin.obj").holes()``
    """
    from ingest.formats import ReadLimits, read_mesh

    return read_mesh(path, limits=limits or ReadLimits())


@overload
def open(
    path: Path | str | None = None,
    mode: Mode = "read",
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Database: ...
@overload
def open(
    path: Sequence[Path | str | tuple[Path | str | None, float] | None],
    mode: Mode = "read",
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> DatabaseUnion: ...
def open(
    path: Path | str | Sequence[Path | str | tuple[Path | str | None, float] | None] | None = None,
    mode: Mode = "read",
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Database | DatabaseUnion:
    """Open a pattern database; without a path, the starter database that comes along.

    mode: "read", "write" (it must exist) or "create" (made if it does not). The starter
    database can only be read. Queries read it as it was shipped; whatever else is asked first,
    unpacks it into an SQLite file, which takes seconds: ``say`` is told so, and ``progress`` how
    much is done, of how much. Raises DatabaseError, saying what would mend it.

    A list of paths is asked as one database (:class:`patterndb.store.DatabaseUnion`): frequencies
    are added, each times a weight where a path comes as ``(path, weight)``; None, or ":starter:",
    is the starter database. With mode "write" the first that may be written gets what is recorded.

    Example: ``patterndb.open().statistics().patterns``;
    ``patterndb.open([None, ("own.db", 3.0)])``
    """
    from patterndb.store import Database
    from patterndb.store.starter import StarterDatabase

    if path is None or path == STARTER_NAME:
        if mode != "read":
            raise ValueError("the starter database is never written to; give a path of your own")
        return StarterDatabase(say, progress)
    if isinstance(path, str | Path):
        return Database(path, mode)
    from patterndb.store.union import open_union

    named: list[tuple[str, Path | None, float]] = []
    for item in path:
        one, weight = item if isinstance(item, tuple) else (item, 1.0)
        if one is None or one == STARTER_NAME:
            named.append((STARTER_NAME, None, weight))
        else:
            named.append((str(one), Path(one), weight))
    return open_union(named, mode, lambda: StarterDatabase(say, progress))
