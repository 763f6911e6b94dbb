"""Set traced lines into a network, with the order of ends around every node as it was traced.

Adding the lines one by one would order them by measured angles, and refuse those that nearly lie on
each other; here every order is known: around a singularity as its separatrices were listed, at a
T-junction as the line was met, left or right, within the triangle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.polyline import interpolate
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.joints import BEYOND, AtSingularity, InWedge, OnChain, OnLine
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    NONE,
    HalfChain,
    Network,
    NetworkBuilder,
    Node,
    count_genus,
    count_handles,
    has_dead_end,
    walk_face,
)
from patterndb_sketch.retopo.network.faces import SurfaceParts, find_joined_chains
from patterndb_sketch.retopo.network.patches import FEWEST_CORNERS
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tracing.curves import project_near
from patterndb_sketch.retopo.wording import format_place

Key = tuple[str, int]


class RoundRegionError(RefusedError):
    """A region came out with too few corners; another line through it may give it some. at: a point
    on the curve beside it."""

    def __init__(self, message: str, at: Points | None = None) -> None:
        super().__init__(message)
        self.at = at


@dataclass(frozen=True, slots=True, eq=False)
class DraftLine:
    """A line to be laid: (n, 3) points with normals, from one joint to another."""

    points: Points
    normals: Points
    along: Floats
    start: AtSingularity | OnChain | InWedge
    end: AtSingularity | OnLine | OnChain | InWedge


@dataclass(slots=True, eq=False)
class _Junction:
    """A node to be: where it is, and what ends there, by order counter-clockwise. through: does a
    line pass it, on the far side straight?"""

    point: Points
    normal: Points
    through: bool
    ends: list[tuple[float, HalfChain]] = field(default_factory=list)
    wall: int = -1


class LayoutBuilder:
    """The steps of laying lines, which need the same things; :meth:`build` takes them all.

    laid: the chains that lines became. kept: the patches that were there, by their ids now.
    """

    def __init__(
        self,
        network: Network,
        surface: Surface,
        sizes: Sizes,
        lines: list[DraftLine],
        joining: float,
        corners: list[OnChain | InWedge],
    ) -> None:
        self.builder = NetworkBuilder(network, surface)
        self.surface = surface
        self.sizes = sizes
        self.lines = lines
        self.laid: set[int] = set()
        self.kept: frozenset[int] = frozenset()
        self.junctions: dict[Key, _Junction] = {}
        self.walls: dict[tuple[int, float], int] = {}
        self.marked_corners = [at for at in corners if isinstance(at, OnChain)]
        self.wedge_corners = {at.half for at in corners if isinstance(at, InWedge)}
        self.in_wedges: dict[int, list[tuple[HalfChain, float, HalfChain]]] = {}
        self.ends_at: dict[int, Key] = {}
        self.stops: dict[int, list[tuple[float, Key]]] = {}
        self.joining = joining
        self._join_opposite(joining)

    def _join_opposite(self, joining: float) -> None:
        """Find the nodes of T-junctions; two from both sides nearer than ``joining`` are one."""
        met: dict[int, list[tuple[float, int, bool]]] = {}
        for k, line in enumerate(self.lines):
            if isinstance(line.end, OnLine):
                met.setdefault(line.end.line, []).append((line.end.there, k, line.end.left))
        for number, events in met.items():
            events.sort()
            stops = self.stops.setdefault(number, [])
            pairs = sorted(
                (b[0] - a[0], a[1], b[1])
                for a, b in pairwise(events)
                if a[2] != b[2] and b[0] - a[0] < joining
            )
            mate: dict[int, int] = {}
            for _, one, two in pairs:
                if one not in mate and two not in mate:
                    mate[one], mate[two] = two, one
            for there, k, _ in events:
                other = mate.get(k)
                if other is None:
                    self.ends_at[k] = ("T", k)
                    stops.append((there, ("T", k)))
                elif k not in self.ends_at:
                    end = self.lines[other].end
                    assert isinstance(end, OnLine)
                    self.ends_at[k] = self.ends_at[other] = ("T", k)
                    stops.append((0.5 * (there + end.there), ("T", k)))

    def build(self) -> Network:
        """Lay everything; raises RefusedError where a region is no patch."""
        self._cut_walls()
        for number, stops in self.stops.items():
            line = self.lines[number]
            for there, key in stops:
                at = np.array([there])
                point, normal = interpolate_line(line.points, line.normals, line.along, at)
                self._add_junction(key, point, normal, True)
        for line in self.lines:
            if isinstance(line.start, AtSingularity):
                self._add_junction(("S", line.start.vertex), line.points[:1], line.normals[:1])
            if isinstance(line.end, AtSingularity):
                self._add_junction(("S", line.end.vertex), line.points[-1:], line.normals[-1:])
        for k in range(len(self.lines)):
            self._lay(k)
        self._set_nodes()
        made = self._finish()
        owner = made.patch_of()
        before = self.builder.before.patches.values()
        self.kept = frozenset(owner[self.builder.half_now(patch.loop[0])] for patch in before)
        return made

    def _add_junction(self, key: Key, point: Points, normal: Points, through: bool = False) -> None:
        if key in self.junctions:
            return
        there = project_near(self.surface, point, units(normal), self.sizes)
        self.junctions[key] = _Junction(there.points[0], there.normals[0], through)

    def _cut_walls(self) -> None:
        """Cut the network's own chains where lines end on them."""
        joints: list[OnChain] = [*self.marked_corners]
        for line in self.lines:
            joints += [at for at in (line.start, line.end) if isinstance(at, OnChain)]
        same = self._join_across(joints)
        for at in joints:
            key = (at.chain, at.place)
            if key in self.walls:
                continue
            if key in same:
                key = same[key]
                if key in self.walls:
                    self.walls[(at.chain, at.place)] = self.walls[key]
                    continue
            node = self.builder.cut_chain(*key)
            self.walls[key] = self.walls[(at.chain, at.place)] = node
            made = self.builder.nodes[node]
            self.junctions[("W", node)] = _Junction(made.point, made.normal, False, wall=node)

    def _join_across(self, joints: list[OnChain]) -> dict[tuple[int, float], tuple[int, float]]:
        """Of places on both sides of a chain, nearer than ``joining`` to each other, the place
        between, for each."""
        by_chain: dict[int, set[tuple[float, bool]]] = {}
        for at in joints:
            by_chain.setdefault(at.chain, set()).add((at.place, at.left))
        found: dict[tuple[int, float], tuple[int, float]] = {}
        for number, places in by_chain.items():
            chain = self.builder.chains[number]
            if chain.marked:
                continue
            ordered = sorted(places)
            spacing = chain.length / chain.segments
            pairs = sorted(
                (b[0] - a[0], a[0], b[0])
                for a, b in pairwise(ordered)
                if a[1] != b[1] and 0.0 < (b[0] - a[0]) * spacing < self.joining
            )
            for _, one, two in pairs:
                if (number, one) not in found and (number, two) not in found:
                    middle = (number, 0.5 * (one + two))
                    found[number, one] = found[number, two] = middle
        return found

    def _key(self, k: int, at: AtSingularity | OnLine | OnChain | InWedge) -> Key:
        if isinstance(at, AtSingularity):
            return ("S", at.vertex)
        if isinstance(at, InWedge):
            key = ("N", at.node)
            if key not in self.junctions:
                node = self.builder.nodes[at.node]
                self.junctions[key] = _Junction(node.point, node.normal, False)
            return key
        if isinstance(at, OnChain):
            return ("W", self.walls[(at.chain, at.place)])
        return self.ends_at[k]

    def _order(self, at: AtSingularity | OnLine | OnChain | InWedge) -> float:
        """Where among the ends of its node a line's own end comes."""
        if isinstance(at, AtSingularity | InWedge):
            return at.order
        if isinstance(at, OnChain):
            return at.order if at.left else at.order + BEYOND
        # Of the line that is met the end onward is 0 and the end back is 2.
        return 1 if at.left else 3

    def _lay(self, k: int) -> None:
        """Cut a line at its stops, and make a chain of each piece."""
        line = self.lines[k]
        stops = [
            (0.0, self._key(k, line.start)),
            *sorted(self.stops.get(k, [])),
            (float(line.along[-1]), self._key(k, line.end)),
        ]
        for j, ((low, one), (high, two)) in enumerate(pairwise(stops)):
            chain = self._add_piece(line, low, high, one, two)
            start = self._order(line.start) if j == 0 else 0
            end = self._order(line.end) if j == len(stops) - 2 else 2
            for key, at, order, half in (
                (one, line.start if j == 0 else None, start, 2 * chain),
                (two, line.end if j == len(stops) - 2 else None, end, 2 * chain + 1),
            ):
                if isinstance(at, InWedge):
                    self.in_wedges.setdefault(at.node, []).append((at.half, order, half))
                self.junctions[key].ends.append((order, half))

    def _add_piece(self, line: DraftLine, low: float, high: float, one: Key, two: Key) -> int:
        parts = max(2, math.ceil((high - low) / self.sizes.sampling))
        at = np.linspace(low, high, parts + 1)
        points, normals = interpolate_line(line.points, line.normals, line.along, at)
        there = project_near(self.surface, points, normals, self.sizes)
        begin, end = self.junctions[one], self.junctions[two]
        share = np.linspace(0.0, 1.0, parts + 1)[:, None]
        shift = (1.0 - share) * (begin.point - there.points[0])
        shift = shift + share * (end.point - there.points[-1])
        if np.abs(shift).max() > 1e-9 * self.surface.diagonal:
            there = project_near(self.surface, there.points + shift, there.normals, self.sizes)
        points, normals = there.points.copy(), there.normals.copy()
        points[0], normals[0] = begin.point, begin.normal
        points[-1], normals[-1] = end.point, end.normal
        chain = self.builder.new_chain(NONE, NONE, points, normals)
        self.laid.add(chain)
        return chain

    def _set_nodes(self) -> None:
        """Give every node its ends in order, and every end its node."""
        corners = {(self.walls[(at.chain, at.place)], at.left) for at in self.marked_corners}
        self._flag_drawn()
        for (kind, number), at in self.junctions.items():
            at.ends.sort()
            if kind == "N":
                node = self._fill_wedges(number)
            elif at.wall >= 0:
                node = self._open_wall(at, *((at.wall, side) in corners for side in (True, False)))
            else:
                ends = tuple(half for _, half in at.ends)
                flags = [True] * len(ends)
                orders = [order for order, _ in at.ends]
                if at.through and orders == [0, 1, 2]:
                    flags[2] = False
                elif at.through and orders == [0, 2, 3]:
                    flags[0] = False
                node = Node(
                    self.builder.new_id(), at.point, at.normal, ends, tuple(flags), at.through
                )
            self.builder.set_node(node)
            for _, half in at.ends:
                name = "end" if half & 1 else "start"
                chain = self.builder.chains[half >> 1]
                self.builder.chains[half >> 1] = replace(chain, **{name: node.id})

    def _flag_drawn(self) -> None:
        """At nodes of curves that were drawn, wedges without a patch are corners where the field
        has one, and else straight."""
        before = self.builder.before
        taken = before.patch_of()
        drawn = {
            node
            for chain in before.chains.values()
            if not (chain.marked or chain.is_closed_loop)
            for node in (chain.start, chain.end)
        }
        for number in sorted(drawn):
            old, now = before.nodes[number], self.builder.nodes[number]
            flags = tuple(
                flag if half in taken or before.mark(half) else half in self.wedge_corners
                for half, flag in zip(old.ends, old.corner_flags, strict=True)
            )
            self.builder.set_node(replace(now, corner_flags=flags))

    def _fill_wedges(self, number: int) -> Node:
        """A node that was there, with what ends there now in its wedges."""
        node = self.builder.nodes[number]
        added: dict[HalfChain, list[tuple[float, HalfChain]]] = {}
        for first, order, half in self.in_wedges.get(number, []):
            added.setdefault(self.builder.half_now(first), []).append((order, half))
        ends: list[HalfChain] = []
        flags: list[bool] = []
        for end, flag in zip(node.ends, node.corner_flags, strict=True):
            more = [half for _, half in sorted(added.get(end, []))]
            ends += [end, *more]
            flags += [True] * (len(more) + 1) if more else [flag]
        return replace(node, ends=tuple(ends), corner_flags=tuple(flags))

    def _open_wall(self, at: _Junction, corner: bool, beyond: bool) -> Node:
        """A node on a chain that was there, with what ends there on its left and its right; corner,
        beyond: is it a corner of what is there, too, without a line?"""
        old = self.builder.nodes[at.wall]
        forth, back = old.ends
        left = [half for order, half in at.ends if order < BEYOND]
        right = [half for order, half in at.ends if order >= BEYOND]
        ends = (forth, *left, back, *right)
        flags = (
            *((True,) * (len(left) + 1) if left or corner else (False,)),
            *((True,) * (len(right) + 1) if right or beyond else (False,)),
        )
        return replace(old, ends=ends, corner_flags=flags)

    def _finish(self) -> Network:
        nodes, chains = self.builder.nodes, self.builder.chains
        taken = self.builder.before.patch_of()
        kept = {h for h in taken if h >> 1 in chains}
        forced: list[HalfChain] = []
        seen: set[HalfChain] = set()
        for chain in sorted(chains):
            for half in (2 * chain, 2 * chain + 1):
                if half in seen or half in kept or chains[chain].marks[half & 1]:
                    continue
                loop, corners = walk_face(nodes, chains, half)
                seen.update(loop)
                beyond = next((h for h in loop if chains[h >> 1].marks[h & 1]), None)
                if beyond is not None:
                    # Two borders with a vertex in common are one to the network, and none here.
                    place = format_place(chains[beyond >> 1].points[0])
                    raise RefusedError(
                        f"borders of the surface touch at {place}: part them there, or join them"
                    )
                if has_dead_end(nodes, chains, loop):
                    ends = {nodes[n].id for h in loop for n in self._ends(h) if nodes[n].open}
                    x, y, z = nodes[min(ends)].point
                    raise RefusedError(
                        f"a curve ends openly at ({x:.4g}, {y:.4g}, {z:.4g}), and no line of the "
                        "field goes on from there; lead it to another curve, or erase it"
                    )
                if len(corners) < FEWEST_CORNERS:
                    x, y, z = chains[loop[0] >> 1].points[len(chains[loop[0] >> 1].points) // 2]
                    raise RoundRegionError(
                        f"the region beside the curve at ({x:.4g}, {y:.4g}, {z:.4g}) came out with "
                        f"{len(corners)} corners, and cannot be filled; draw a curve through it",
                        np.array([x, y, z]),
                    )
                forced.append(loop[0])
        return self.builder.finish(also=forced)

    def _ends(self, half: HalfChain) -> tuple[int, ...]:
        """The nodes of a half-chain's curve."""
        chain = self.builder.chains[half >> 1]
        return () if chain.is_closed_loop else (chain.start, chain.end)


def interpolate_line(
    points: Points, normals: Points, along: Floats, wanted: Floats
) -> tuple[Points, Points]:
    """(k, 3) points of a polyline at lengths (k,) along it, and (k, 3) unit normals."""
    return interpolate(points, along, wanted), units(interpolate(normals, along, wanted))


def is_cellular(network: Network, surface: Surface) -> bool:
    """Is every region of the surface a disk: one network on each part, which goes round all its
    handles?"""
    whole = SurfaceParts.of(surface)
    on: list[int] = []
    left = set(network.chains)
    while left:
        joined = find_joined_chains(network.nodes, network.chains, next(iter(left)))
        # Where parts touch or pass through each other, single points may lie on another.
        at = surface.nearest(network.chains[min(joined)].points).triangles
        on.append(int(np.bincount(whole.part[at]).argmax()))
        left -= joined
    if len(on) != whole.parts or len(set(on)) != whole.parts:
        return False
    return count_genus(network.nodes, network.chains) == count_handles(surface)
