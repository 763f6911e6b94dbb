"""The store: patterns, meshes and occurrences in one SQLite file (schema.sql)."""

from patterndb.store.database import Database
from patterndb.store.ddq import Exported, PatchTable, RefusedRow, read_table
from patterndb.store.records import (
    Learned,
    LearningOptions,
    Mesh,
    Occurrence,
    Provenance,
    Statistics,
)

__all__ = [
    "Database",
    "Exported",
    "Learned",
    "LearningOptions",
    "Mesh",
    "Occurrence",
    "PatchTable",
    "Provenance",
    "RefusedRow",
    "Statistics",
    "read_table",
]
