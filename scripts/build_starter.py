"""Build the starter database from a folder of artist meshes with an INDEX.csv beside them.

    python scripts/build_starter.py ../shared/data/meshes

Takes the meshes that INDEX.csv gives as CC0 or public domain, learns them at the default
limits, and writes patterndb/data/starter.compact. Author, licence and origin of each mesh go in.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from pathlib import Path

import patterndb
from ingest import ingest
from patterndb.store import Provenance
from patterndb.store.starter import PACKED_NAME
from patterndb.system.files import replace_file

FREE = ("CC0-1.0", "public domain")
TARGET = Path(__file__).parents[1] / "patterndb" / "data" / PACKED_NAME

#: The starter must stay small enough to come with every installation.
LARGEST = 8_000_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="meshes, with INDEX.csv")
    parser.add_argument("-o", "--output", type=Path, default=TARGET)
    arguments = parser.parse_args()
    with (arguments.folder / "INDEX.csv").open(newline="", encoding="utf-8") as file:
        rows = {row["file"]: row for row in csv.DictReader(file) if row["licence"] in FREE}

    def provenance(path: Path) -> Provenance:
        row = rows[path.name]
        return Provenance(
            row["author"] or None,
            f"{row['repo']}: {row['path']} @ {row['commit']}",
            row["licence"],
        )

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "starter.db"
        with patterndb.open(path, "create") as database:
            ingest(
                database,
                [arguments.folder / name for name in sorted(rows)],
                provenance=provenance,
                report=lambda m: print(m.name, f"{m.patterns:,}", file=sys.stderr),
            )
            data = database.compact()
            patterns = database.statistics().patterns
    if len(data) > LARGEST:
        sys.exit(f"{len(data):,} bytes are more than the starter may have ({LARGEST:,})")
    arguments.output.parent.mkdir(exist_ok=True)
    replace_file(arguments.output, data)
    print(f"{len(rows)} meshes, {patterns:,} patterns, {len(data):,} bytes: {arguments.output}")


if __name__ == "__main__":
    main()
