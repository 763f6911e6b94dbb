"""Ingestion: mesh files, or meshes in arrays -> patches -> patterns -> store."""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from ingest.formats import ReadLimits, read_mesh
    from ingest.learning import learn
    from ingest.pipeline import (
        IngestReport,
        MeshReport,
        Progress,
        check_files,
        ingest,
        learn_mesh,
    )

__all__ = [
    "IngestReport",
    "MeshReport",
    "Progress",
    "ReadLimits",
    "check_files",
    "ingest",
    "learn",
    "learn_mesh",
    "read_mesh",
]

_HOME = {
    "IngestReport": "ingest.pipeline",
    "MeshReport": "ingest.pipeline",
    "Progress": "ingest.pipeline",
    "ReadLimits": "ingest.formats",
    "check_files": "ingest.pipeline",
    "ingest": "ingest.pipeline",
    "learn": "ingest.learning",
    "learn_mesh": "ingest.pipeline",
    "read_mesh": "ingest.formats",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOME)
