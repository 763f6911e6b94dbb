"""All small quad disks, grown quad by quad in plain Python.

Every disk can be built by laying quads along one, two or three consecutive edges of the border,
a disk at each step. A quad along one edge adds two border vertices; along two edges it closes one
vertex and along three it closes two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tests.support.reference.code import Code, mirrored, rooted_code
from tests.support.reference.halfedge import Twin

#: Quads at a vertex inside, and the most at a vertex of the border.
INNER_VALENCES = (3, 5)
MOST_AT_BORDER = 3


@dataclass(frozen=True, slots=True)
class _Grown:
    """A disk with its border: half-edges counter-clockwise, and the quads at each one's start."""

    twin: Twin
    border: list[int]
    counts: list[int]
    n_inner: int


def list_small_disks(most_border: int, most_inner: int) -> list[Twin]:
    """Return the half-edges of every disk, once up to rotation and mirror image.

    Vertices inside have 3 to 5 quads, border vertices at most 3. Sorted by border vertices,
    vertices inside and code. Disks on the way may have two border vertices more for every vertex
    that is yet to be closed by pairs.
    """
    reach = most_border + most_inner
    level = {(0,) * 4: _Grown([-1] * 4, [0, 1, 2, 3], [1] * 4, 0)}
    found: list[tuple[int, int, Code]] = []
    while level:
        following: dict[Code, _Grown] = {}
        for code, disk in level.items():
            size = len(disk.border)
            if size <= most_border and max(disk.counts) <= MOST_AT_BORDER:
                found.append((size, disk.n_inner, code))
            for larger in _enlarge(disk, most_inner, reach):
                following.setdefault(_code(larger), larger)
        level = following
    return [decode_rooted(code) for _, _, code in sorted(found)]


def _enlarge(disk: _Grown, most_inner: int, reach: int) -> Iterator[_Grown]:
    """Lay one quad along one to three edges, wherever it may lie."""
    size = len(disk.border)
    least, most = INNER_VALENCES
    for span in (1, 2, 3):
        n_inner = disk.n_inner + span - 1
        if n_inner > most_inner or size + 4 - 2 * span + n_inner > reach or span >= size - 1:
            continue
        for at in range(size):
            border = disk.border[at:] + disk.border[:at]
            counts = disk.counts[at:] + disk.counts[:at]
            closed = counts[1:span]
            if not all(least <= count + 1 <= most for count in closed):
                continue
            # What is full on the border could never be closed, nor stay.
            if counts[0] + 1 >= most or counts[span] + 1 >= most:
                continue
            twin = [*disk.twin, -1, -1, -1, -1]
            h = len(disk.twin)
            for i in range(span):
                twin[border[i]] = h + span - 1 - i
                twin[h + span - 1 - i] = border[i]
            yield _Grown(
                twin,
                [*range(h + span, h + 4), *border[span:]],
                [counts[0] + 1, *(1,) * (3 - span), counts[span] + 1, *counts[span + 1 :]],
                n_inner,
            )


def _code(disk: _Grown) -> Code:
    """Return the smallest code from where the quads along the border, read on, are fewest.

    Both senses are tried. A code read elsewhere may be smaller, but no isomorphic disk has another
    code by this rule.
    """
    size = len(disk.border)
    forward = disk.counts * 2
    backward = forward[::-1]
    least = min(round_[i : i + size] for round_ in (forward, backward) for i in range(size))
    codes = [
        rooted_code(disk.twin, disk.border[i])
        for i in range(size)
        if forward[i : i + size] == least
    ]
    if any(backward[i : i + size] == least for i in range(size)):
        image = mirrored(disk.twin)
        for i in range(size):
            if backward[i : i + size] == least:
                # Entry i of the reversed list is the start of border edge -1 - i, which in the
                # mirror image ends there: the edge before it starts there.
                edge = disk.border[(-2 - i) % size]
                codes.append(rooted_code(image, 4 * (edge // 4) + 3 - edge % 4))
    return min(codes)


def decode_rooted(code: Code) -> Twin:
    """Return the half-edges of a code, the quads numbered as they are met."""
    twin = [-1] * len(code)
    entry = [0]
    for quad in range(len(code) // 4):
        for i in range(4):
            h = 4 * quad + (entry[quad] + i) % 4
            word = code[4 * quad + i]
            if word and twin[h] < 0:
                other, turn = divmod(word - 1, 4)
                if other == len(entry):
                    entry.append(0)
                twin[h] = 4 * other + (entry[other] + turn) % 4
                twin[twin[h]] = h
    return twin
