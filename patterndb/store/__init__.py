"""The store: patterns, meshes and occurrences in one SQLite file (schema.sql)."""

from patterndb.store.database import Database
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
    "Learned",
    "LearningOptions",
    "Mesh",
    "Occurrence",
    "Provenance",
    "Statistics",
]
