"""Patches of a mesh as sets of quads, mode by mode, and the patterns they reduce to."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tests.support.reference.code import Code, canonical_code, rooted_code
from tests.support.reference.halfedge import Twin, as_complex, border_loop, fans
from tests.support.reference.reduction import reduce_disk

Patch = frozenset[int]


class PatchMesh:
    """A mesh with its vertices, and what can be asked of a set of its quads."""

    def __init__(self, twin: Sequence[int]) -> None:
        self.twin = [int(t) for t in twin]
        self.n_quads = len(self.twin) // 4
        self.vertex = fans(as_complex(self.twin))
        self.star: dict[int, set[int]] = {}
        for h, v in self.vertex.items():
            self.star.setdefault(v, set()).add(h // 4)

    def neighbours(self, patch: Patch) -> set[int]:
        return {self.twin[h] // 4 for h in self.border(patch) if self.twin[h] >= 0}

    def border(self, patch: Patch) -> list[int]:
        """Half-edges with no quad of the patch beyond."""
        return [
            h
            for f in patch
            for h in range(4 * f, 4 * f + 4)
            if self.twin[h] < 0 or self.twin[h] // 4 not in patch
        ]

    def count(self, patch: Patch) -> Counter[int]:
        """The patch's quads at every vertex."""
        return Counter(self.vertex[h] for f in patch for h in range(4 * f, 4 * f + 4))

    def half_edges(self, patch: Patch) -> Twin:
        """The patch on its own."""
        place = {f: i for i, f in enumerate(sorted(patch))}
        return [
            4 * place[t // 4] + t % 4 if t >= 0 and t // 4 in place else -1
            for f in sorted(patch)
            for t in self.twin[4 * f : 4 * f + 4]
        ]

    def is_patch(self, patch: Patch) -> bool:
        """One border loop that visits no vertex of the mesh twice, and V - E + F = 1?

        Sets are grown edge by edge, so they are connected.
        """
        border = self.border(patch)
        tails = {self.vertex[h] for h in border}
        if not border or len(tails) < len(border):
            return False
        local = as_complex(self.half_edges(patch))
        first = next(h for h, t in local.items() if t < 0)
        n_edges = (4 * len(patch) + len(border)) // 2
        return (
            len(border_loop(local, first)) == len(border)
            and len(self.count(patch)) - n_edges + len(patch) == 1
        )

    def sides(self, patch: Patch) -> list[list[int]]:
        """Border half-edges side by side; the whole border where there is no corner."""
        count = self.count(patch)
        leaving = {self.vertex[h]: h for h in self.border(patch)}
        corners = [v for v in leaving if count[v] != 2]
        sides: list[list[int]] = []
        for corner in corners or [next(iter(leaving))]:
            side = [leaving[corner]]
            while True:
                h = side[-1]
                v = self.vertex[4 * (h // 4) + (h + 1) % 4]
                if v == corner or v in corners:
                    break
                side.append(leaving[v])
            sides.append(side)
        return sides


def basic(mesh: PatchMesh, limit: int) -> set[Patch]:
    """Every edge-connected set of at most ``limit`` quads that is a patch."""
    layer: set[Patch] = {frozenset([f]) for f in range(mesh.n_quads)} if limit else set()
    patches = set(filter(mesh.is_patch, layer))
    for _ in range(limit - 1):
        layer = {p | {f} for p in layer for f in mesh.neighbours(p)}
        patches |= set(filter(mesh.is_patch, layer))
    return patches


def side(mesh: PatchMesh, limit: int) -> set[Patch]:
    return _grow(mesh, limit, lambda patch: patch)


def convex(mesh: PatchMesh, limit: int) -> set[Patch]:
    return _grow(mesh, limit, lambda patch: _mended(mesh, patch, limit))


def _grow(mesh: PatchMesh, limit: int, mend: Callable[[Patch], Patch | None]) -> set[Patch]:
    """All patches reached from single quads by adding what lies beyond a whole side."""
    patches: set[Patch] = set()
    todo: list[Patch] = [frozenset([f]) for f in range(mesh.n_quads)] if limit else []
    while todo:
        patch = todo.pop()
        if patch in patches or len(patch) > limit or not mesh.is_patch(patch):
            continue
        patches.add(patch)
        for edges in mesh.sides(patch):
            if all(mesh.twin[h] >= 0 for h in edges):
                grown = mend(patch | {mesh.twin[h] // 4 for h in edges})
                if grown is not None:
                    todo.append(grown)
    return patches


def _mended(mesh: PatchMesh, patch: Patch, limit: int) -> Patch | None:
    """The patch with all quads at reflex corners, until there is no such corner."""
    while len(patch) <= limit:
        count = mesh.count(patch)
        reflex = {mesh.vertex[h] for h in mesh.border(patch) if count[mesh.vertex[h]] >= 3}
        if not reflex:
            return patch
        if any(mesh.star[v] <= patch for v in reflex):
            return None
        patch = patch.union(*(mesh.star[v] for v in reflex))
    return None


@dataclass(frozen=True, slots=True)
class Counts:
    """patterns: per canonical code, patches as it is and as its mirror image.
    examples: per canonical code, the patches."""

    basic: int
    side: int
    convex: int
    patterns: dict[Code, tuple[int, int]]
    examples: dict[Code, set[Patch]]


def learn(twin: Sequence[int], basic_limit: int, side_limit: int, convex_limit: int) -> Counts:
    """Everything a mesh teaches, taken as it is."""
    mesh = PatchMesh(twin)
    modes = (
        basic(mesh, basic_limit),
        side(mesh, side_limit),
        convex(mesh, convex_limit),
    )
    known: dict[Code, tuple[Code, bool]] = {}
    patterns: dict[Code, list[int]] = {}
    examples: dict[Code, set[Patch]] = {}
    for patch in set.union(*modes):
        local = mesh.half_edges(patch)
        reading = rooted_code(local, 0)
        if reading not in known:
            pattern = reduce_disk(local, random.Random(len(known)), strict=False)
            known[reading] = canonical_code(pattern)[:2]
        code, mirrored = known[reading]
        patterns.setdefault(code, [0, 0])[mirrored] += 1
        examples.setdefault(code, set()).add(patch)
    return Counts(
        *map(len, modes), {code: (own, other) for code, (own, other) in patterns.items()}, examples
    )
