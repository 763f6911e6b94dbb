"""The list of all small quad disks, and what writes it: ``python -m tests.support.smalldisks``.

All disks of at most 14 border and 4 inner vertices, the latter with 3 to 5 quads, with at most 3
quads at a border vertex, up to rotation and mirror image: 3,753.
"""

from __future__ import annotations

from functools import cache

from tests.support.reference.growth import list_small_disks
from tests.support.reference.halfedge import Quads, Twin, as_complex, fans
from tests.support.shared import DATA

MOST_BORDER = 14
MOST_INNER = 4

FILE = DATA / "small_disks.txt"

HEADER = "# border vertices, inner vertices, quads, then the vertices of each quad"


@cache
def read_small_disks() -> tuple[tuple[int, int, Quads], ...]:
    """Return the rows of the list: border vertices, inner vertices, quads (Q, 4)."""
    rows: list[tuple[int, int, Quads]] = []
    for line in FILE.read_text("ascii").splitlines():
        if not line.startswith("#"):
            n_border, n_inner, n_quads, *flat = map(int, line.split())
            rows.append((n_border, n_inner, [flat[4 * i : 4 * i + 4] for i in range(n_quads)]))
    return tuple(rows)


def make_row(twin: Twin) -> tuple[int, int, Quads]:
    """Name the vertices of a disk in the order in which its quads have them."""
    vertex = fans(as_complex(twin))
    number: dict[int, int] = {}
    flat = [number.setdefault(vertex[h], len(number)) for h in range(len(twin))]
    n_border = sum(t < 0 for t in twin)
    quads = [flat[i : i + 4] for i in range(0, len(flat), 4)]
    return n_border, len(number) - n_border, quads


def write_small_disks() -> None:
    """Write the list."""
    lines = [HEADER]
    for n_border, n_inner, quads in map(make_row, list_small_disks(MOST_BORDER, MOST_INNER)):
        numbers = [n_border, n_inner, len(quads), *(v for quad in quads for v in quad)]
        lines.append(" ".join(map(str, numbers)))
    FILE.write_text("\n".join(lines) + "\n", "ascii")


if __name__ == "__main__":
    write_small_disks()
