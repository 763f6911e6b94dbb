-- The pattern database. Version 1.
--
-- One SQLite file holds the meshes that were learned, the patterns found in them, how often each
-- pattern occurs in each mesh, and how often its fills were used. docs/definitions.md explains the
-- terms, docs/database.md shows how to query the file.
--
-- Every table holds facts. What follows from other rows is not stored: the view counted_pattern
-- computes it.
--
-- A packed number takes seven bits of a byte, the lowest first; the high bit means that another
-- byte of the same number follows.

PRAGMA application_id = 0x50617444;  -- 'PatD'
PRAGMA user_version = 1;

-- One row for each mesh. A mesh is identified by the bytes of its file: the same file under
-- another name is the same mesh. A mesh that a program gave as arrays is identified by the bytes
-- that ingest/arrays.py writes of it. An imported table of patterns is a row here too; it has
-- patches but no quads, and all its limits are 0.
CREATE TABLE mesh (
    id               INTEGER PRIMARY KEY,
    sha256           BLOB    NOT NULL UNIQUE CHECK (length(sha256) = 32),
    name             TEXT    NOT NULL CHECK (name <> ''),
    author           TEXT,
    source           TEXT,
    licence          TEXT,
    -- The options it was learned with: the largest patch of each mode in quads (0: the mode was
    -- off), and whether polychords that only refine the mesh were collapsed first.
    basic_limit      INTEGER NOT NULL CHECK (basic_limit >= 0),
    side_limit       INTEGER NOT NULL CHECK (side_limit >= 0),
    convex_limit     INTEGER NOT NULL CHECK (convex_limit >= 0),
    prepared         INTEGER NOT NULL CHECK (prepared IN (0, 1)),
    -- What was found: quads in the file, quads after that collapse, patches of each mode, and
    -- distinct patches of all modes together.
    quads_read       INTEGER NOT NULL CHECK (quads_read >= 0),
    quads_used       INTEGER NOT NULL CHECK (quads_used BETWEEN 0 AND quads_read),
    basic_patches    INTEGER NOT NULL CHECK (basic_patches >= 0),
    side_patches     INTEGER NOT NULL CHECK (side_patches >= 0),
    convex_patches   INTEGER NOT NULL CHECK (convex_patches >= 0),
    distinct_patches INTEGER NOT NULL CHECK (distinct_patches >= 0),
    -- learned: patterndb found the patterns in quads. imported: another program counted them.
    origin           TEXT    NOT NULL DEFAULT 'learned' CHECK (origin IN ('learned', 'imported')),
    -- The largest number of patterns to keep of this mesh (0: all), and how many rarer ones were
    -- left out for it. The patches of those count in distinct_patches.
    pattern_limit     INTEGER NOT NULL DEFAULT 0 CHECK (pattern_limit >= 0),
    patterns_left_out INTEGER NOT NULL DEFAULT 0 CHECK (patterns_left_out >= 0),
    -- The sum of the hashes of its occurrences, modulo 2^128, written with them. The content hash
    -- and the keys of cached classes are made of it, so that neither reads all occurrences.
    occurrence_sum    BLOB    NOT NULL CHECK (length(occurrence_sum) = 16)
) STRICT;

-- One row for each pattern. A pattern is here because a mesh has it or a fill of it was used.
CREATE TABLE pattern (
    -- The top byte is the number of sides (127 means 127 or more); the rest is a hash of the code.
    -- The id is the same in every database, and the patterns of a class are adjacent.
    id            INTEGER PRIMARY KEY,
    code          BLOB    NOT NULL,  -- the canonical code, shortened by patterndb/core/shortcode.py
    -- These follow from the code and are stored for queries in SQL.
    n_sides       INTEGER NOT NULL CHECK (n_sides >= 0),
    n_reflex      INTEGER NOT NULL CHECK (n_reflex BETWEEN 0 AND n_sides),
    n_quads       INTEGER NOT NULL CHECK (n_quads >= 1),
    n_irregular   INTEGER NOT NULL CHECK (n_irregular >= 0),
    chiral        INTEGER NOT NULL CHECK (chiral IN (0, 1)),
    -- A hash of the smallest rotation or reflection of the boundary label. Patterns with the same
    -- signature fit the same boundaries.
    signature     BLOB    NOT NULL
) STRICT;

-- Counting patterns by shape reads this index instead of the table.
CREATE INDEX pattern_shape ON pattern (n_sides, n_irregular, chiral);

-- One row for each pattern of each mesh: how many distinct patches of the mesh reduce to the
-- pattern, and how many of these are mirror images of the stored code (0 where the pattern is its
-- own mirror image).
CREATE TABLE occurrence (
    pattern_id       INTEGER NOT NULL REFERENCES pattern (id),
    mesh_id          INTEGER NOT NULL REFERENCES mesh (id),
    patches          INTEGER NOT NULL CHECK (patches >= 1),
    mirrored_patches INTEGER NOT NULL CHECK (mirrored_patches BETWEEN 0 AND patches),
    -- The smallest of these patches: the numbers of its quads among the faces of the file, from 0,
    -- ascending, packed, each as the difference to the one before. Empty for an imported mesh.
    example          BLOB    NOT NULL,
    PRIMARY KEY (pattern_id, mesh_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX occurrence_mesh ON occurrence (mesh_id);

-- One row for each pattern that was used: how many fills of it were accepted. Usage belongs to
-- the user of this file: it is not part of the content hash, and merging leaves it out.
CREATE TABLE usage (
    pattern_id INTEGER PRIMARY KEY REFERENCES pattern (id),
    uses       INTEGER NOT NULL CHECK (uses >= 1),
    -- The origin of the pattern at its first use. A query makes patterns of families and
    -- constructed ones; learned and imported ones come from meshes, perhaps of another database.
    origin     TEXT    NOT NULL
               CHECK (origin IN ('learned', 'imported', 'family', 'constructed'))
) STRICT;

-- Patterns with what follows from the other tables. frequency: patches of all meshes. n_meshes:
-- meshes that have it. origin: learned if a learned mesh has it, else imported if an imported one
-- has it, else what it was at its first use. ('learned' > 'imported', so max() finds the first.)
CREATE VIEW counted_pattern AS
SELECT
    pattern.*,
    (SELECT coalesce(sum(patches), 0) FROM occurrence WHERE pattern_id = pattern.id) AS frequency,
    (SELECT count(*) FROM occurrence WHERE pattern_id = pattern.id) AS n_meshes,
    coalesce((SELECT usage.uses FROM usage WHERE pattern_id = pattern.id), 0) AS uses,
    coalesce(
        (
            SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
            WHERE pattern_id = pattern.id
        ),
        (SELECT usage.origin FROM usage WHERE pattern_id = pattern.id)
    ) AS origin
FROM pattern;
