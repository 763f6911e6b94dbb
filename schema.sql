-- The pattern database, whole. Version 7.
--
-- One file holds the meshes that were learned from, the patterns found in them, how often
-- each pattern occurs in each mesh, and how often its fills were used. Words are those of
-- docs/definitions.md.
--
-- Blobs of numbers ("packed") hold seven bits a byte, lowest first, the high bit saying
-- that more follow; nearly every number takes one byte.

PRAGMA application_id = 0x50617444;  -- 'PatD'
PRAGMA user_version = 7;

-- A mesh is known by the bytes of its file: the same bytes under another name are the
-- same mesh, and are counted once. A mesh given by a program as arrays is known by the bytes
-- that ingest/arrays.py writes of it. A table of patterns made by another program is one row
-- here as well ("imported"), known by the bytes of its file; it has patches and no quads.
CREATE TABLE mesh (
    id               INTEGER PRIMARY KEY,
    sha256           BLOB    NOT NULL UNIQUE CHECK (length(sha256) = 32),
    name             TEXT    NOT NULL CHECK (name <> ''),
    author           TEXT,
    source           TEXT,
    licence          TEXT,
    -- What was asked for: the largest patch of each mode (0: the mode is off), and
    -- whether refining polychords were collapsed first.
    basic_limit      INTEGER NOT NULL CHECK (basic_limit >= 0),
    side_limit       INTEGER NOT NULL CHECK (side_limit >= 0),
    convex_limit     INTEGER NOT NULL CHECK (convex_limit >= 0),
    prepared         INTEGER NOT NULL CHECK (prepared IN (0, 1)),
    -- What was found: quads in the file and after preparation, patches of each mode, and
    -- distinct patches over all modes.
    quads_read       INTEGER NOT NULL CHECK (quads_read >= 0),
    quads_used       INTEGER NOT NULL CHECK (quads_used BETWEEN 0 AND quads_read),
    basic_patches    INTEGER NOT NULL CHECK (basic_patches >= 0),
    side_patches     INTEGER NOT NULL CHECK (side_patches >= 0),
    convex_patches   INTEGER NOT NULL CHECK (convex_patches >= 0),
    distinct_patches INTEGER NOT NULL CHECK (distinct_patches >= 0),
    -- learned: from quads. imported: as counted by another program; limits and quads are 0.
    origin           TEXT    NOT NULL DEFAULT 'learned' CHECK (origin IN ('learned', 'imported')),
    -- The most patterns that were to be kept of it (0: all). How many others it has: the rarer
    -- ones. Nothing of them is stored but that their patches count in distinct_patches. And the
    -- sum modulo 2^128 of the hashes of its occurrences: the content hash is made of these
    -- (patterndb/store/checksums.py).
    pattern_limit     INTEGER NOT NULL DEFAULT 0 CHECK (pattern_limit >= 0),
    patterns_left_out INTEGER NOT NULL DEFAULT 0 CHECK (patterns_left_out >= 0),
    occurrence_sum    BLOB    NOT NULL DEFAULT x'00000000000000000000000000000000'
                      CHECK (length(occurrence_sum) = 16)
) STRICT;

CREATE TABLE pattern (
    -- Number of sides in the top byte (127: 127 or more), then a hash of code: the same in
    -- every database, and the patterns of a class lie together.
    id            INTEGER PRIMARY KEY,
    code          BLOB    NOT NULL,  -- the canonical code, short: patterndb/core/shortcode.py
    -- All else follows from the code. These few are here for questions in SQL, and are checked
    -- when a class is loaded; corners, labels and the like are made of the codes then.
    n_sides       INTEGER NOT NULL CHECK (n_sides >= 0),
    n_reflex      INTEGER NOT NULL CHECK (n_reflex BETWEEN 0 AND n_sides),
    n_quads       INTEGER NOT NULL CHECK (n_quads >= 1),
    n_irregular   INTEGER NOT NULL CHECK (n_irregular >= 0),
    chiral        INTEGER NOT NULL CHECK (chiral IN (0, 1)),
    -- A hash of the boundary label's smallest rotation or reflection, which asks the same of
    -- every boundary: patterns with one signature fit the same ones.
    signature     BLOB    NOT NULL,
    frequency     INTEGER NOT NULL DEFAULT 0 CHECK (frequency >= 0),
    -- learned: a learned mesh holds it. imported: only imported tables do. A pattern that
    -- occurs nowhere is here because it was used, and says what it was then (table usage):
    -- family and constructed are made by a query, learned and imported come from elsewhere.
    origin        TEXT    NOT NULL DEFAULT 'learned'
                  CHECK (origin IN ('learned', 'imported', 'family', 'constructed'))
) STRICT;

-- How many distinct patches of a mesh reduce to a pattern; of these, mirrored_patches are
-- mirror images of the stored code (0 where the pattern is its own mirror image).
CREATE TABLE occurrence (
    pattern_id       INTEGER NOT NULL REFERENCES pattern (id),
    mesh_id          INTEGER NOT NULL REFERENCES mesh (id),
    patches          INTEGER NOT NULL CHECK (patches >= 1),
    mirrored_patches INTEGER NOT NULL CHECK (mirrored_patches BETWEEN 0 AND patches),
    -- One such patch, the smallest: packed, its quads as the file numbers its faces, from 0,
    -- ascending, each but the first as the difference to the one before. Empty where the mesh
    -- is imported: such tables do not tell.
    example          BLOB    NOT NULL,
    PRIMARY KEY (pattern_id, mesh_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX occurrence_mesh ON occurrence (mesh_id);

-- How many accepted fills had the pattern. Content of its own: neither part of what was
-- learned (content_hash) nor merged, for it tells what this database's user likes.
CREATE TABLE usage (
    pattern_id INTEGER PRIMARY KEY REFERENCES pattern (id),
    uses       INTEGER NOT NULL CHECK (uses >= 1),
    -- What the pattern was to the query when it was first used.
    origin     TEXT    NOT NULL
               CHECK (origin IN ('learned', 'imported', 'family', 'constructed'))
) STRICT;

-- For each table the sum, modulo 2^128, of hashes of its rows; whoever writes keeps them. A row that
-- changed otherwise (a bad disk, another program) is so found by verify. Patterns need none: their id
-- is a hash of the code, and the rest follows. Occurrences are summed for each mesh, in its row. More
-- in patterndb/store/checksums.py.
CREATE TABLE checksum (
    name  TEXT PRIMARY KEY,
    total BLOB NOT NULL CHECK (length(total) = 16)
) STRICT, WITHOUT ROWID;
INSERT INTO checksum VALUES
    ('mesh', zeroblob(16)), ('usage', zeroblob(16));

-- What statistics tell, kept by whoever writes, so that none of it needs a look at every row
-- (patterndb/store/tallies.py); verify counts it anew. How many patterns are alike:
CREATE TABLE tally (
    n_sides     INTEGER NOT NULL,
    n_irregular INTEGER NOT NULL,
    chiral      INTEGER NOT NULL CHECK (chiral IN (0, 1)),
    patterns    INTEGER NOT NULL CHECK (patterns >= 0),
    PRIMARY KEY (n_sides, n_irregular, chiral)
) STRICT, WITHOUT ROWID;

-- The signatures of all patterns, those of one number of sides that were written together as one
-- row: 8 bytes each, in no order, one for each pattern.
CREATE TABLE signature (
    id      INTEGER PRIMARY KEY,
    n_sides INTEGER NOT NULL,
    hashes  BLOB    NOT NULL CHECK (length(hashes) > 0 AND length(hashes) % 8 = 0)
) STRICT;

-- One row: in how many handednesses patterns were met in meshes, all together.
CREATE TABLE handedness (
    met INTEGER NOT NULL CHECK (met >= 0)
) STRICT;
INSERT INTO handedness VALUES (0);

-- A pattern's frequency is the sum of its occurrences, and its origin follows from them; both
-- are kept by the database itself. 'learned' > 'imported', so that max() finds the origin.
CREATE TRIGGER occurrence_added AFTER INSERT ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency + NEW.patches,
        origin = CASE
            WHEN (SELECT origin FROM mesh WHERE id = NEW.mesh_id) = 'learned' THEN 'learned'
            ELSE (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = NEW.pattern_id
            )
        END
    WHERE id = NEW.pattern_id;
END;

CREATE TRIGGER occurrence_removed AFTER DELETE ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency - OLD.patches,
        origin = coalesce(
            (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = OLD.pattern_id
            ),
            (SELECT origin FROM usage WHERE pattern_id = OLD.pattern_id),
            origin
        )
    WHERE id = OLD.pattern_id;
END;

CREATE TRIGGER occurrence_changed AFTER UPDATE ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency - OLD.patches,
        origin = coalesce(
            (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = OLD.pattern_id
            ),
            (SELECT origin FROM usage WHERE pattern_id = OLD.pattern_id),
            origin
        )
    WHERE id = OLD.pattern_id;
    UPDATE pattern SET
        frequency = frequency + NEW.patches,
        origin = (
            SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
            WHERE pattern_id = NEW.pattern_id
        )
    WHERE id = NEW.pattern_id;
END;
