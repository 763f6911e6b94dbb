"""Compile the kernels, on two cores, so that the first real use need not wait for it.

    python scripts/compile_kernels.py

Numba keeps compiled code beside the sources and compiles again where they have changed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

EXAMPLE = Path(__file__).parents[1] / "examples" / "jug.obj"

#: What uses the kernels of learning, and what uses those of queries and pictures.
LEARN = """
import patterndb, ingest
with patterndb.open({folder!r} + "/a.db", "create") as database:
    ingest.ingest(database, [{example!r}])
    assert not database.verify()
"""
ASK = """
import numpy as np
from patterndb.pattern import Pattern
from patterndb.patternclass import PatternClass
from query import fills
from viewer import embed
square = Pattern.from_code(np.zeros(4, np.uint16))
embed(fills(PatternClass.from_patterns(4, [square]), (3, 2, 3, 2))[0].disk())
"""


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        runs = [
            subprocess.Popen([sys.executable, "-c", text])
            for text in (LEARN.format(folder=folder, example=str(EXAMPLE)), ASK)
        ]
        codes = [run.wait() for run in runs]
    if any(codes):
        sys.exit("the kernels could not be compiled; see above")


if __name__ == "__main__":
    main()
