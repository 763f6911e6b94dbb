"""Keep patterns, meshes and occurrences in one SQLite file (schema.sql).

Read in this order: records (what goes in and comes out, rows and columns), connection (the file
and its schema), reading, writing, classes (a class as arrays, its cache and its block),
verification and recovery, compact and starter (the shipped database), ddqkey and ddq (tables of the
paper's authors), database (all of it as one object), union (several as one).
"""

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
from patterndb.store.union import DatabaseUnion, MemberOccurrence

__all__ = [
    "Database",
    "DatabaseUnion",
    "Exported",
    "Learned",
    "LearningOptions",
    "MemberOccurrence",
    "Mesh",
    "Occurrence",
    "PatchTable",
    "Provenance",
    "RefusedRow",
    "Statistics",
    "read_table",
]
