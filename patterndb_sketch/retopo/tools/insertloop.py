"""The loop insertion tool: an edge loop is inserted along a strip of quads, which is split."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import Argument, Vector
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.edgecounts import complete_counts, side_lengths
from patterndb_sketch.retopo.filling.expansion import Expansion
from patterndb_sketch.retopo.filling.fills import fill_patch, filling_of, has_suitable_fill
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.filling.placing import PlacedPatch, divide_lengths
from patterndb_sketch.retopo.network import (
    EVEN,
    Chain,
    Density,
    Edit,
    HalfChain,
    Network,
    Patch,
    find_nearest_place,
    set_choice,
    take_samples,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from query.boundary import MAX_PERIMETER
from query.engine import PatternSource


def insert_loop(
    network: Network,
    surface: Surface,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
) -> Edit:
    """Insert the edge loop that runs along the strip of quads at a point.

    point, normal: (3,) on the surface. Within the snap radius of a curve it is the strip through
    the nearest of the curve's edges, else the one through the nearest edge of the quads of the
    patch there. It is followed through the fills of all patches that it passes, to curves with
    nothing behind or back to where it began, and doubled: patches keep their patterns, with
    wider polychords, and each curve gains an edge for every crossing, whether its count is
    pinned or not. A strip that is closed within one patch changes no count.

    Counts and fills that are not chosen yet, and are needed, are chosen. Vertices moved by
    hand in the patches on the way are placed anew, which is told.

    Raises RefusedError where there is no strip, if a patch on the way cannot be filled, and if
    one would have more edges around it than a boundary can have.
    Source: Takayama et al. 2013. Differs from their program: a curve that is crossed twice
    gains two edges, and fills are followed whatever they are.
    """
    before = network
    network, notes = complete_counts(network, sizes.edge)
    walk = _StripWalk(network, surface, source)
    at = find_nearest_place(take_samples(network), point, normal, sizes.snap)
    if at is not None and not walk.patch_of.keys().isdisjoint((2 * at.chain, 2 * at.chain + 1)):
        walk.through(
            2 * at.chain, find_edge_at(network.chains[at.chain], at.place, network.density)
        )
    else:
        walk.through_patch(find_patch(network, surface, point), np.asarray(point, np.float64))
    after, told = walk.double()
    return Edit.of(before, after, (*notes, *told))


def find_edge_at(chain: Chain, place: float, density: Density = EVEN) -> int:
    """Which of a chain's edges a place (in samples) lies on."""
    along = arc_length(chain.round)
    at = float(np.interp(place, np.arange(len(along)), along))
    ends = divide_lengths(chain, density)
    return min(max(int(np.searchsorted(ends, at, "right")) - 1, 0), chain.count - 1)


class _CrossedPatch:
    """A patch that the strip passes.

    edges: per boundary edge of its fill, the half-chain it is on and its number along the chain.
    chords: of the pattern, one for every passage. crossed: boundary edges.
    """

    def __init__(self, network: Network, patch: Patch) -> None:
        choice = filling_of(patch).choice
        assert choice is not None
        self.expansion = Expansion.of(choice)
        self.edges = _list_border_edges(network, patch)
        self.number = {edge: k for k, edge in enumerate(self.edges)}
        self.chords: list[int] = []
        self.crossed: list[int] = []

    def pass_from(self, edge: tuple[HalfChain, int]) -> tuple[HalfChain, int]:
        """Note a passage from a boundary edge; the one at its other end."""
        one = self.number[edge]
        two = self.expansion.across(one)
        self.chords.append(int(self.expansion.chord[self.expansion.border[one]]))
        self.crossed += [one, two]
        return self.edges[two]


class _StripWalk:
    """Along a strip, from patch to patch."""

    def __init__(self, network: Network, surface: Surface, source: PatternSource) -> None:
        self.network = network
        self.surface = surface
        self.source = source
        self.patches: dict[int, _CrossedPatch] = {}
        self.gains: Counter[int] = Counter()  # edges more by chain

    @cached_property
    def patch_of(self) -> Mapping[HalfChain, int]:
        return self.network.patch_of()

    def through(self, half: HalfChain, edge: int) -> None:
        """Both ways from an edge of a chain."""
        self.gains[half >> 1] += 1
        start = half >> 1, edge
        if not self._follow(half, edge, start):
            self._follow(half ^ 1, edge, start)

    def through_patch(self, patch: int, point: np.ndarray) -> None:
        """From the edge of a patch's quads that is nearest to a point (3,)."""
        self.network, placed = fill_patch(self.network, self.surface, self.source, patch)
        crossed = self._crossed(patch)
        expansion = crossed.expansion
        first = half = find_nearest_edge(placed, point)
        while True:
            after = int(expansion.twin[half])
            if after < 0:
                self.through(*crossed.edges[int(placed.quads.ravel()[half])])
                return
            half = after ^ 2
            if half == first:
                crossed.chords.append(int(expansion.chord[first]))
                return

    def double(self) -> tuple[Network, list[str]]:
        """The network with the strip doubled, and notes."""
        network = self.network
        chains = {
            c: replace(network.chains[c], count=network.chains[c].count + more)
            for c, more in self.gains.items()
        }
        network = replace(network, chains={**network.chains, **chains})
        notes: list[str] = []
        for patch, crossed in self.patches.items():
            sides = side_lengths(network, network.patches[patch])
            if sum(sides) > MAX_PERIMETER:
                raise RefusedError(
                    f"patch {patch} would have {sum(sides)} edges around it, and "
                    f"{MAX_PERIMETER} are the most"
                )
            former = filling_of(network.patches[patch])
            choice = crossed.expansion.widen(crossed.chords, crossed.crossed, sides)
            if len(former.moved_vertices[0]):
                notes.append(f"vertices of patch {patch} that were moved by hand are placed anew")
            network = set_choice(network, patch, former.with_choice(choice))
        return network, notes

    def _follow(self, half: HalfChain, edge: int, start: tuple[int, int]) -> bool:
        """Into the patch on the left of a half-chain, and on; is it back at the start?"""
        while True:
            patch = self.patch_of.get(half)
            if patch is None:
                return False
            half, edge = self._crossed(patch).pass_from((half, edge))
            if (half >> 1, edge) == start:
                return True
            self.gains[half >> 1] += 1
            half ^= 1

    def _crossed(self, patch: int) -> _CrossedPatch:
        if patch not in self.patches:
            if not has_suitable_fill(self.network, self.network.patches[patch]):
                self.network, _ = fill_patch(self.network, self.surface, self.source, patch)
            self.patches[patch] = _CrossedPatch(self.network, self.network.patches[patch])
        return self.patches[patch]


def _list_border_edges(network: Network, patch: Patch) -> list[tuple[HalfChain, int]]:
    """Of each boundary edge of a patch's fill, the half-chain that it is on, and its number
    along the chain as that runs forwards."""
    found: list[tuple[HalfChain, int]] = []
    for half in patch.loop:
        numbers = range(network.chains[half >> 1].count)
        found += [(half, k) for k in (reversed(numbers) if half & 1 else numbers)]
    return found


def find_nearest_edge(placed: PlacedPatch, point: np.ndarray) -> int:
    """The half-edge of placed quads whose edge is nearest to a point (3,)."""
    one = placed.vertices[placed.quads.ravel()]
    along = placed.vertices[np.roll(placed.quads, -1, axis=1).ravel()] - one
    size = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((point - one) * along).sum(axis=1) / size, 0.0, 1.0)
    return int(np.linalg.norm(one + share[:, None] * along - point, axis=1).argmin())


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    foot, sizes = work.find_foot(a["at"]), work.state.sizes
    point, normal = foot.points[0], foot.normals[0]
    return work.keep_edit(
        insert_loop(work.network, work.surface, work.source, sizes, point, normal)
    )


INSERT_LOOP = Tool(
    "insertloop",
    "Insert an edge loop along the strip of quads through an edge.",
    {"at": Argument(Vector(), "a point of the surface near the edge")},
    _act,
    position=190,
    snaps=True,
    control=Control(
        "4", "add loop", "click an edge: a loop is added along its strip of quads", target="none"
    ),
)
