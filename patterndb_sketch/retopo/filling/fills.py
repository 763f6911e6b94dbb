"""Rank the fills that a patch can have, and choose the one that it gets."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.choice import By, Choice, Filling, Flow, pattern_code
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.placing import (
    PlacedPatch,
    is_divided_alike,
    place_between,
    place_fill,
    trace_border,
)
from patterndb_sketch.retopo.network import Network, Patch, set_choice
from query.boundary import Boundary
from query.engine import PatternSource, fills
from query.fill import Fill
from query.stroke import Stroke

#: Fills of a patch that are listed for stepping through.
LISTED = 40

#: Of the first fills, so many are placed until one has no flipped quad.
PLACED = 4

#: Quads that are placed for one patch, after which the best fill so far is taken: untangling a
#: patch of thousands takes seconds.
MOST_PLACED = 1_000


def filling_of(patch: Patch) -> Filling:
    """What the network keeps of a patch's fill."""
    return patch.choice if isinstance(patch.choice, Filling) else Filling()


def has_suitable_fill(network: Network, patch: Patch) -> bool:
    """Has the patch a fill, and for the counts that its chains have now?"""
    choice = filling_of(patch).choice
    return choice is not None and choice.lengths == side_lengths(network, patch)


def rank_fills(
    network: Network, patch: Patch, source: PatternSource, limit: int = LISTED
) -> Iterator[Fill]:
    """The fills of a patch, best first, as the query engine ranks them.

    With flow lines those whose edges follow them; a line that ends where it began is a loop.
    Raises RefusedError for a patch that has no even boundary.
    """
    sides = side_lengths(network, patch)
    if sum(sides) % 2 or sum(sides) < 4 or min(sides) < 1:
        raise RefusedError(
            f"patch {patch.id} has {sum(sides)} edges around it, and a fill needs an even number "
            "of 4 or more; change a count beside it"
        )
    points, _ = trace_border(network, patch)
    with _refuse_errors(patch):
        boundary = Boundary(sides, points=points)
        strokes = [_stroke_of(boundary, flow) for flow in filling_of(patch).flows]
        # Placed on the surface and judged there (:func:`fill_patch`), so not by how they lie flat.
        order = "flow" if strokes else "artist"
        return fills(source, boundary, strokes=strokes, limit=limit, order=order)


def fill_patch(
    network: Network, surface: Surface, source: PatternSource, patch: int
) -> tuple[Network, PlacedPatch]:
    """The network with a fill for a patch that suits its counts, and the fill placed.

    A fill that suits stays. A user's pattern is taken again if it fits other counts, too. Else
    it is the first of the list, or the first of the first few without flipped quads.
    """
    at = network.patches[patch]
    if has_suitable_fill(network, at):
        return network, _place(network, surface, at)
    former = filling_of(at)
    listed = rank_fills(network, at, source)
    if former.choice is not None and former.choice.by == "user":
        for fill in listed:
            if pattern_code(fill) == former.choice.code:
                network = _with_fill(network, at, fill, "user")
                return network, _place(network, surface, network.patches[patch])
        listed = rank_fills(network, at, source)
    best: tuple[Network, PlacedPatch] | None = None
    quads = 0
    for _, fill in zip(range(PLACED), listed, strict=False):
        tried = _with_fill(network, at, fill, "program")
        shown = _place(tried, surface, tried.patches[patch])
        if best is None or len(shown.flipped) < len(best[1].flipped):
            best = tried, shown
        quads += fill.n_quads
        if not len(shown.flipped) or quads > MOST_PLACED:
            break
    if best is None:
        raise RefusedError(
            f"patch {patch} has no fill that follows its flow lines; remove one, or draw it "
            "from side to side"
        )
    return best


def fill_between(
    network: Network, surface: Surface, source: PatternSource, patch: int
) -> tuple[Network, PlacedPatch]:
    """The network with the first fill of a patch, placed by :func:`place_between`.

    Raises RefusedError where there is none.
    """
    at = network.patches[patch]
    fill = next(iter(rank_fills(network, at, source, 1)), None)
    if fill is None:
        raise RefusedError(f"patch {patch} has no fill that follows its flow lines")
    network = _with_fill(network, at, fill, "program")
    return network, place_between(network, surface, network.patches[patch])


def release_vertices(before: Network, after: Network) -> Network:
    """The network after an edit, without vertices held by hand in patches whose curves took
    another course, or are divided elsewhere: they follow them."""
    for patch in list(after.patches.values()):
        former = before.patches.get(patch.id)
        filling = filling_of(patch)
        if former is None or not filling.moved[0] or filling.moved != filling_of(former).moved:
            continue
        chains = {half >> 1 for half in patch.loop}
        if any(_has_moved(before, after, chain) for chain in chains):
            free = filling.with_moved([], np.empty((0, 3)))
            after = set_choice(after, patch.id, free)
    return after


def _has_moved(before: Network, after: Network, chain: int) -> bool:
    one, two = before.chains.get(chain), after.chains[chain]
    return (
        one is None
        or (one is not two and not np.array_equal(one.points, two.points))
        or not is_divided_alike(two, before.density, after.density)
    )


def step_fill(network: Network, patch: int, source: PatternSource, by: int) -> Network:
    """The network with the fill that comes after a patch's own in the list, or before it.

    by: how many on; the list begins again at its end.
    """
    listed = list(rank_fills(network, network.patches[patch], source))
    if not listed:
        raise RefusedError(f"patch {patch} has no fill that follows its flow lines")
    now = filling_of(network.patches[patch]).choice
    at = next(
        (k for k, fill in enumerate(listed) if now is not None and _is_choice(fill, now)), None
    )
    if at is None:
        # Before the first, so that one on is the first, and one back the last.
        at = -1 if by > 0 else 0
    wanted = (at + by) % len(listed)
    return _with_fill(network, network.patches[patch], listed[wanted], "user")


def take_fill(network: Network, patch: int, source: PatternSource, number: int) -> Network:
    """The network with a fill of a patch's list, by its number from 0 on."""
    at = network.patches[patch]
    for k, fill in enumerate(rank_fills(network, at, source, max(LISTED, number + 1))):
        if k == number:
            return _with_fill(network, at, fill, "user")
    raise RefusedError(f"patch {patch} has no fill {number}; its list is shorter")


def add_flow(network: Network, patch: int, line: np.ndarray) -> Network:
    """The network with another line (n, 3) that a patch's edges are to follow."""
    former = filling_of(network.patches[patch])
    new = replace(former.with_choice(None), flows=(*former.flows, Flow.of(line)))
    return set_choice(network, patch, new)


def clear_flows(network: Network, patch: int) -> Network:
    """The network without a patch's flow lines; it gets the first fill again."""
    if not filling_of(network.patches[patch]).flows:
        raise RefusedError(f"patch {patch} has no flow lines")
    return set_choice(network, patch, None)


def _place(network: Network, surface: Surface, patch: Patch) -> PlacedPatch:
    with _refuse_errors(patch):
        return place_fill(network, surface, patch)


@contextmanager
def _refuse_errors(patch: Patch) -> Iterator[None]:
    """What is wrong with a boundary, such as two vertices in one place, is no fault of a call."""
    try:
        yield
    except RefusedError:
        raise
    except PatternDBError as error:
        raise RefusedError(f"patch {patch.id} cannot be filled: {error}") from error


def _with_fill(network: Network, patch: Patch, fill: Fill, by: By) -> Network:
    new = filling_of(patch).with_choice(Choice.of(fill, by))
    return set_choice(network, patch.id, new)


def _is_choice(fill: Fill, choice: Choice) -> bool:
    return replace(Choice.of(fill), by=choice.by) == choice


def _stroke_of(boundary: Boundary, flow: Flow) -> Stroke:
    points = flow.points
    reach = float(np.linalg.norm(np.ptp(points, axis=0)))
    closed = float(np.linalg.norm(points[0] - points[-1])) < 0.1 * reach
    return Stroke.loop(points) if closed else Stroke.drawn(boundary, points)
