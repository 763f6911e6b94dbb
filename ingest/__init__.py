"""Ingestion: mesh files, or meshes in arrays -> patches -> patterns -> store."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
    "learn": "ingest.learning",
    "ReadLimits": "ingest.formats",
    "read_mesh": "ingest.formats",
}


def __getattr__(name: str) -> Any:
    # Only what is asked for is imported: reading a mesh must not wait for compiled kernels.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME.get(name, "ingest.pipeline")), name)
