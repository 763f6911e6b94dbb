"""Find what an edit left that is rarely meant, and say where: open ends, and curves that leave the
surface.

Nothing of it is refused: an open end may be joined by the next stroke.
"""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network import Network, Node
from patterndb_sketch.retopo.network.flooding import find_leaps
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.wording import count_places, list_places


def describe_open_ends(before: Network, after: Network, sizes: Sizes) -> tuple[str, ...]:
    """The open ends that an edit left, in words with places; () for none that is new."""
    ends = np.array([n.point for n in _list_new_ends(before, after)]).reshape(-1, 3)
    if not len(ends):
        return ()
    return (
        f"{count_places('an open end', 'open ends', ends)}: nothing to be joined to was within "
        f"the snap radius of {sizes.snap:.3g}",
    )


def describe_leaps(before: Network, after: Network, surface: Surface) -> tuple[str, ...]:
    """Where an edit left curves that leave the surface, likewise."""
    leaps = find_new_leaps(before, after, surface)
    if not len(leaps):
        return ()
    what = "a curve leaves" if len(leaps) == 1 else "curves leave"
    return (
        f"{what} the surface {list_places(leaps)}, for another part of it: redraw it along the "
        "surface, with points nearer to each other",
    )


def _list_new_ends(before: Network, after: Network) -> list[Node]:
    """The open ends of a network that were none before."""
    return [
        node
        for number, node in sorted(after.nodes.items())
        if node.open and not ((former := before.nodes.get(number)) is not None and former.open)
    ]


def find_new_leaps(before: Network, after: Network, surface: Surface) -> Points:
    """(k, 3) where curves that are new, or run elsewhere than before, leave the surface.

    Not those that a draft laid: they were traced on the surface, and the draft is judged by its
    quads. Between sheets closer than its samples the nearest sheet need not be its own.
    """
    found: list[Points] = [np.empty((0, 3))]
    for number, chain in sorted(after.chains.items()):
        if chain.laid:
            continue
        former = before.chains.get(number)
        if former is None or former.points is not chain.points:
            found.append(find_leaps(surface, chain.points, chain.loose))
    leaps = np.concatenate(found)
    if not len(leaps) or not before.chains:
        return leaps
    # A curve that is cut by the edit is another chain: what it did before it still does.
    former = [
        find_leaps(surface, chain.points, chain.loose)
        for number, chain in before.chains.items()
        if number not in after.chains and not chain.laid
    ]
    old = np.concatenate([np.empty((0, 3)), *former])
    away = np.linalg.norm(leaps[:, None] - old, axis=2)
    return leaps[~(away < SAME_LEAP * surface.diagonal).any(axis=1)]


#: Two places where curves leave the surface are one if they are this near, in parts of the
#: diagonal.
SAME_LEAP = 0.002
