-- Version 1 of schema.sql, as databases have it that were made with it.
PRAGMA application_id = 0x50617444;
PRAGMA user_version = 1;
CREATE TABLE mesh (
    id               INTEGER PRIMARY KEY,
    sha256           BLOB    NOT NULL UNIQUE CHECK (length(sha256) = 32),
    name             TEXT    NOT NULL CHECK (name <> ''),
    author           TEXT,
    source           TEXT,
    licence          TEXT,
    basic_limit      INTEGER NOT NULL CHECK (basic_limit >= 0),
    side_limit       INTEGER NOT NULL CHECK (side_limit >= 0),
    convex_limit     INTEGER NOT NULL CHECK (convex_limit >= 0),
    prepared         INTEGER NOT NULL CHECK (prepared IN (0, 1)),
    quads_read       INTEGER NOT NULL CHECK (quads_read >= 0),
    quads_used       INTEGER NOT NULL CHECK (quads_used BETWEEN 0 AND quads_read),
    basic_patches    INTEGER NOT NULL CHECK (basic_patches >= 0),
    side_patches     INTEGER NOT NULL CHECK (side_patches >= 0),
    convex_patches   INTEGER NOT NULL CHECK (convex_patches >= 0),
    distinct_patches INTEGER NOT NULL CHECK (distinct_patches >= 0)
) STRICT;
CREATE TABLE pattern (
    id            INTEGER PRIMARY KEY,
    code          BLOB    NOT NULL,
    n_sides       INTEGER NOT NULL CHECK (n_sides >= 0),
    corners       BLOB    NOT NULL,
    n_reflex      INTEGER NOT NULL CHECK (n_reflex BETWEEN 0 AND n_sides),
    n_quads       INTEGER NOT NULL CHECK (n_quads >= 1),
    n_irregular   INTEGER NOT NULL CHECK (n_irregular >= 0),
    valences      BLOB    NOT NULL,
    n_chords      INTEGER NOT NULL CHECK (n_chords >= 0),
    n_loops       INTEGER NOT NULL CHECK (n_loops >= 0),
    self_crossing INTEGER NOT NULL CHECK (self_crossing IN (0, 1)),
    rotations     INTEGER NOT NULL CHECK (rotations >= 1),
    chiral        INTEGER NOT NULL CHECK (chiral IN (0, 1)),
    label         BLOB    NOT NULL,
    signature     BLOB    NOT NULL,
    sig_rotation  INTEGER NOT NULL CHECK (sig_rotation >= 0),
    sig_reflected INTEGER NOT NULL CHECK (sig_reflected IN (0, 1)),
    lengths       BLOB    NOT NULL,
    joins         BLOB    NOT NULL,
    frequency     INTEGER NOT NULL DEFAULT 0 CHECK (frequency >= 0)
) STRICT;
CREATE TABLE occurrence (
    pattern_id       INTEGER NOT NULL REFERENCES pattern (id),
    mesh_id          INTEGER NOT NULL REFERENCES mesh (id),
    patches          INTEGER NOT NULL CHECK (patches >= 1),
    mirrored_patches INTEGER NOT NULL CHECK (mirrored_patches BETWEEN 0 AND patches),
    example          BLOB    NOT NULL,
    PRIMARY KEY (pattern_id, mesh_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX occurrence_mesh ON occurrence (mesh_id);
CREATE TRIGGER occurrence_added AFTER INSERT ON occurrence BEGIN
    UPDATE pattern SET frequency = frequency + NEW.patches WHERE id = NEW.pattern_id;
END;
CREATE TRIGGER occurrence_removed AFTER DELETE ON occurrence BEGIN
    UPDATE pattern SET frequency = frequency - OLD.patches WHERE id = OLD.pattern_id;
END;
CREATE TRIGGER occurrence_changed AFTER UPDATE ON occurrence BEGIN
    UPDATE pattern SET frequency = frequency - OLD.patches WHERE id = OLD.pattern_id;
    UPDATE pattern SET frequency = frequency + NEW.patches WHERE id = NEW.pattern_id;
END;
