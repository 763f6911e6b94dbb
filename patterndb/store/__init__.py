"""Keep patterns, meshes and occurrences in one SQLite file (schema.sql).

Read in this order: records (what goes in and comes out), migrations and connection (the file),
reading, tallies and writing, contents (hash and check), statistics, contentkey with classcache
(what is kept in the cache folder), compact and starter (the shipped database), ddqkey and ddq
(tables of the paper's authors), database (all of it as one object), union (several as one).
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
from patterndb.store.union import DatabaseUnion, PatternHolder

__all__ = [
    "Database",
    "DatabaseUnion",
    "Exported",
    "Learned",
    "LearningOptions",
    "Mesh",
    "Occurrence",
    "PatchTable",
    "PatternHolder",
    "Provenance",
    "RefusedRow",
    "Statistics",
    "read_table",
]
