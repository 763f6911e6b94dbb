"""Canonical codes, and isomorphism without them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from tests.support.reference.halfedge import Twin, as_complex, fans, next_edge

Code = tuple[int, ...]


def flip(h: int) -> int:
    """The name of half-edge h in the mirror image: a quad's edges run the other way round."""
    return 4 * (h // 4) + 3 - h % 4


def mirrored(twin: Sequence[int]) -> Twin:
    """The mirror image."""
    result = [-1] * len(twin)
    for h, t in enumerate(twin):
        result[flip(h)] = flip(t) if t >= 0 else -1
    return result


def rooted_code(twin: Sequence[int], start: int) -> Code:
    """The code read from half-edge ``start``, counter-clockwise."""
    number = {start // 4: 0}
    entry = [start]
    code: list[int] = []
    for first in entry:
        h = first
        for _ in range(4):
            t = twin[h]
            if t < 0:
                code.append(0)
            else:
                if t // 4 not in number:
                    number[t // 4] = len(entry)
                    entry.append(t)
                j = number[t // 4]
                code.append(1 + 4 * j + (t - entry[j]) % 4)
            h = next_edge(h)
    return tuple(code)


def code_starts(twin: Sequence[int]) -> list[int]:
    """Border half-edges that leave a corner, or all where there is none."""
    vertex = fans(as_complex(twin))
    count = Counter(vertex.values())
    border = [h for h, t in enumerate(twin) if t < 0]
    return [h for h in border if count[vertex[h]] != 2] or border


def own_code(twin: Sequence[int]) -> Code:
    """The smallest code of this handedness."""
    return min(rooted_code(twin, h) for h in code_starts(twin))


def canonical_code(twin: Sequence[int]) -> tuple[Code, bool, int, bool]:
    """(the smaller of both handednesses, is it the mirror image's, rotations, chiral)."""
    own, other = own_code(twin), own_code(mirrored(twin))
    rotations = sum(rooted_code(twin, h) == own for h in code_starts(twin))
    return min(own, other), other < own, rotations, own != other


def isomorphic(a: Sequence[int], b: Sequence[int]) -> bool:
    """Are two disks the same up to numbering and mirror image?

    One border edge of the one is laid on every border edge of the other, in both
    orientations, and everything else must follow.
    """
    if len(a) != len(b):
        return False
    first = next(h for h, t in enumerate(a) if t < 0)
    return any(
        _follows(a, first, image, h)
        for image in (list(b), mirrored(b))
        for h, t in enumerate(image)
        if t < 0
    )


def _follows(a: Sequence[int], g: int, b: Sequence[int], h: int) -> bool:
    image: dict[int, int] = {}
    todo = [(g, h)]
    while todo:
        g, h = todo.pop()
        if g in image:
            if image[g] != h:
                return False
            continue
        image[g] = h
        if (a[g] < 0) != (b[h] < 0):
            return False
        todo.append((next_edge(g), next_edge(h)))
        if a[g] >= 0:
            todo.append((a[g], b[h]))
    return len(set(image.values())) == len(a)
