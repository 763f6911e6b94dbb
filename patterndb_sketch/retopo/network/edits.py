"""Single edits of a network, as functions; several at once are a :class:`Draft`'s."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.ends import End, Free
from patterndb_sketch.retopo.network.structure import Network


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """What a tool did.

    network: as it is now. notes: what the user should know, in words.
    nodes, chains, patches: ids of those that are there now and were not before.
    """

    network: Network = field(repr=False)
    notes: tuple[str, ...]
    nodes: tuple[int, ...]
    chains: tuple[int, ...]
    patches: tuple[int, ...]

    @classmethod
    def of(cls, before: Network, after: Network, notes: Iterable[str] = ()) -> Edit:
        """By comparing two networks."""
        return cls(
            after,
            tuple(notes),
            tuple(after.nodes.keys() - before.nodes.keys()),
            tuple(after.chains.keys() - before.chains.keys()),
            tuple(after.patches.keys() - before.patches.keys()),
        )


def add_chain(
    network: Network,
    points: ArrayLike,
    normals: ArrayLike,
    start: End = Free(),  # noqa: B008 (immutable)
    end: End = Free(),  # noqa: B008
) -> tuple[Network, int]:
    """With a chain that crosses no other; its id. See :meth:`Draft.add_chain`."""
    draft = Draft(network)
    chain = draft.add_chain(points, normals, start, end)
    return draft.finished(), chain


def add_loop(network: Network, points: ArrayLike, normals: ArrayLike) -> tuple[Network, int]:
    """With a closed chain that crosses no other; its id. See :meth:`Draft.add_loop`."""
    draft = Draft(network)
    chain = draft.add_loop(points, normals)
    return draft.finished(), chain


def cut_chain(
    network: Network, chain: int, place: float, at: tuple[Points, Points] | None = None
) -> tuple[Network, int]:
    """With a chain cut by a corner (on both sides) at a place; the node."""
    draft = Draft(network)
    node = draft.cut_chain(chain, place, at)
    if node not in network.nodes:
        for half in draft.nodes[node].ends:
            draft.flag(half, True)
    return draft.finished(), node


def remove_chains(network: Network, chains: Iterable[int]) -> Network:
    """Without some chains; nodes that they leave stay corners. See :meth:`Draft.remove_chain`.

    :func:`~patterndb_sketch.retopo.tools.erase.erase` also joins what the removed ones had cut.
    """
    draft = Draft(network)
    for chain in sorted(set(chains)):
        draft.remove_chain(chain)
    return draft.finished(forget=True)


def with_count(network: Network, chain: int, count: int, pinned: bool = False) -> Network:
    """With a number of edges along a chain, 0 for not chosen."""
    if count < 0 or (pinned and count == 0):
        raise InvalidRetopoError(f"a chain of {count} edges; give 1 or more, or 0 to let choose")
    new = replace(network.chain(chain), count=count, pinned=pinned)
    return replace(network, chains={**network.chains, chain: new})


def with_choice(network: Network, patch: int, choice: Any) -> Network:
    """With a fill chosen for a patch, or None."""
    if patch not in network.patches:
        raise InvalidRetopoError(f"there is no patch {patch} in the network")
    new = replace(network.patches[patch], choice=choice)
    return replace(network, patches={**network.patches, patch: new})
