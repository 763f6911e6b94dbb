"""patterndb: a database of the patterns in hand-made quad meshes.

    import patterndb

    with patterndb.open("my.db", "create") as db:
        patterndb.ingest(db, ["head.obj", "hand.obj"])
        for fill in patterndb.fills(db, patterndb.Boundary((3, 5, 4, 6))):
            ...

This face has all that a script needs, and imports it when it is asked for. The packages behind
it: core (quad disks, codes, patterns), geometry, store (the database file) and system (files,
caches) here, then ingest, query, patterndb_sketch and viewer. The face and the module
notebook are the one exception to the rule that nothing here imports what stands above.
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
    from ingest.formats import ReadLimits, read_mesh, write_mesh
    from ingest.pipeline import IngestReport, MeshReport, ingest, learn_mesh
    from patterndb.core.pattern import Pattern
    from patterndb.core.polygonmesh import PolygonMesh
    from patterndb.geometry.surface import Surface
    from patterndb.notebook import Sheet
    from patterndb.store import Database, DatabaseUnion, LearningOptions, Provenance
    from patterndb.store.connection import Mode
    from patterndb_app.client.remote import connect
    from query.boundary import Boundary
    from query.boundaryfile import read_boundary
    from query.engine import best, fills
    from query.fill import Fill
    from query.holes import (
        HoleFill,
        HoleFills,
        fill_holes,
        find_holes,
        list_mesh_flaws,
        weld_fills,
    )
    from query.listing.stream import Fills
    from query.placing import Placement, enclose_region, place
    from query.request import FillRequest
    from query.stroke import Stroke

#: What the starter database is called where databases are named by their files.
STARTER_NAME = ":starter:"

__all__ = [
    "Boundary",
    "Database",
    "DatabaseUnion",
    "Fill",
    "FillRequest",
    "Fills",
    "HoleFill",
    "HoleFills",
    "IngestReport",
    "LearningOptions",
    "MeshReport",
    "Pattern",
    "PatternDBError",
    "Placement",
    "PolygonMesh",
    "Provenance",
    "ReadLimits",
    "Sheet",
    "Stroke",
    "Surface",
    "best",
    "connect",
    "enclose_region",
    "fill_holes",
    "fills",
    "find_holes",
    "ingest",
    "learn_mesh",
    "list_mesh_flaws",
    "open",
    "place",
    "read_boundary",
    "read_mesh",
    "weld_fills",
    "write_mesh",
]

#: Where each name of the face is defined.
_HOMES = {
    "Boundary": "query",
    "Database": "patterndb.store",
    "DatabaseUnion": "patterndb.store",
    "Fill": "query",
    "FillRequest": "query",
    "Fills": "query",
    "HoleFill": "query.holes",
    "HoleFills": "query.holes",
    "IngestReport": "ingest.pipeline",
    "LearningOptions": "patterndb.store",
    "MeshReport": "ingest.pipeline",
    "Pattern": "patterndb.core.pattern",
    "Placement": "query.placing",
    "PolygonMesh": "patterndb.core.polygonmesh",
    "Provenance": "patterndb.store",
    "ReadLimits": "ingest.formats",
    "Sheet": "patterndb.notebook",
    "Stroke": "query",
    "Surface": "patterndb.geometry.surface",
    "best": "query",
    "connect": "patterndb_app.client.remote",
    "enclose_region": "query.placing",
    "fill_holes": "query.holes",
    "fills": "query",
    "find_holes": "query.holes",
    "ingest": "ingest.pipeline",
    "learn_mesh": "ingest.pipeline",
    "list_mesh_flaws": "query.holes",
    "place": "query.placing",
    "read_boundary": "query.boundaryfile",
    "read_mesh": "ingest.formats",
    "weld_fills": "query.holes",
    "write_mesh": "ingest.formats",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)


def _draw(item: Pattern | Fill, suffix: Suffix) -> bytes:
    from patterndb.notebook import draw

    return draw(item, suffix)


set_renderer(_draw)


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
