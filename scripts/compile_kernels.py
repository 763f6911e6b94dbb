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
from query import Boundary, Stroke, best, fills
from viewer import embed
square = Pattern.from_code(np.zeros(4, np.uint16))
squares = PatternClass.from_patterns(4, [square])
fill = best(squares, (3, 2, 3, 2))
embed(fill.disk())
list(fills(squares, (3, 2, 3, 2), limit=5))
list(fills(squares, (3, 2, 3, 2), strokes=[Stroke((0, 1), (2, 1))], limit=5))
none = PatternClass.from_patterns(12, [])
best(none, (1, 2) * 6)
points = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [2, 2], [1, 2], [0, 2], [0, 1]]
fill.place(points)
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
