"""The network of curves on a surface: a halfedge structure of chains.

A :class:`Network` has nodes, chains (polylines between nodes) and patches (loops that are filled).
It is immutable: an edit is a function from network to network, undoing is to keep the old one,
and :func:`are_equal` compares two bit for bit. Ids of nodes, chains and patches come from one
counter and are never used twice.

Half-chains are numbers: ``2 * chain`` forward, ``2 * chain + 1`` backward, ``half ^ 1`` the other
way. What lies on the left of a half-chain belongs to it. ``Node.ends`` are the half-chains that
leave a node, counter-clockwise; wedge i, between end i and the next, is a corner of the face in
it if ``Node.corner_flags[i]``. A half-chain that arrives as the other way of end j is followed,
around the face on its left, by end j - 1 (:func:`find_successor`, :func:`walk_face`).

Places on chains are in samples: 3.25 is a quarter of the way from sample 3 to sample 4.

What a curve is joined to is an End:

- ``Free()``: nothing, an open end;
- ``AtNode(node, smooth=False)``: a node that is there;
- ``AtChain(chain, place)``: the inside of a chain, which is cut there (a T-junction).

Single edits are functions: :func:`add_chain`, :func:`add_loop`, :func:`cut_chain`,
:func:`set_count`, :func:`set_choice`. A tool that makes several takes a
:class:`NetworkBuilder`, in which chains that were cut may still be named by their old ids and
places::

    builder = NetworkBuilder(network)
    left = builder.add_chain(points, normals, AtChain(5, 12.0), Free())
    right = builder.add_chain(others, normals, AtChain(5, 30.0), AtNode(node))
    builder.flag(2 * left, False)       # the wedge on its left is passed straight
    network = builder.finish()        # patches are found again, only where something changed

A network stays a drawing on its surface: both ends of a new chain go into one face, whatever
directions say, and :func:`count_genus` is never above the surface's :func:`count_handles`. What
could only be drawn through another curve is refused. A network that knows its surface
(``Network.surface``, set by tools that are given one) also sees the ends of limbs as patches.

Patches whose loops and corners an edit does not change keep their ids and choices.
``tools.stroke.insert`` is for curves that may cross others; it ends in the same calls.
:func:`take_samples` gives all points of all chains as flat arrays, :func:`find_nearest_place` and
:func:`find_nearest_node` find what is near; :func:`check_network` raises if an invariant does not
hold.

A network also keeps how dense its quads shall be (:mod:`.density`): brush strokes, by which the
lengths of chains are measured where counts are chosen and chains divided.

Read :mod:`.structure`, :mod:`.faces`, :mod:`.samples`; then how a network is built:
:mod:`.attaching`, :mod:`.builder`, :mod:`.edits`; how a curve is inserted that may cross others:
:mod:`.crossings`, :mod:`.insertion`, :mod:`.joining`; which loops are patches: :mod:`.flooding`,
:mod:`.patches`; and what always holds: :mod:`.invariants`.
"""

from patterndb_sketch.retopo.network.attaching import Gap
from patterndb_sketch.retopo.network.builder import AtChain, AtNode, Free, NetworkBuilder
from patterndb_sketch.retopo.network.density import EVEN, Density, Paint
from patterndb_sketch.retopo.network.edits import (
    Edit,
    add_borders,
    add_chain,
    add_loop,
    cut_chain,
    set_choice,
    set_count,
)
from patterndb_sketch.retopo.network.faces import (
    count_genus,
    count_handles,
    find_successor,
    has_dead_end,
    walk_face,
)
from patterndb_sketch.retopo.network.invariants import BrokenNetworkError, are_equal, check_network
from patterndb_sketch.retopo.network.patches import (
    find_patches,
    is_end,
    measure_enclosed,
    remove_patch,
    trace_outline,
)
from patterndb_sketch.retopo.network.samples import (
    Samples,
    find_nearest_node,
    find_nearest_place,
    take_samples,
)
from patterndb_sketch.retopo.network.structure import (
    BORDER,
    FACE,
    NONE,
    SYMMETRY,
    Chain,
    HalfChain,
    Network,
    Node,
    Patch,
)

__all__ = [
    "BORDER",
    "EVEN",
    "FACE",
    "NONE",
    "SYMMETRY",
    "AtChain",
    "AtNode",
    "BrokenNetworkError",
    "Chain",
    "Density",
    "Edit",
    "Free",
    "Gap",
    "HalfChain",
    "Network",
    "NetworkBuilder",
    "Node",
    "Paint",
    "Patch",
    "Samples",
    "add_borders",
    "add_chain",
    "add_loop",
    "are_equal",
    "check_network",
    "count_genus",
    "count_handles",
    "cut_chain",
    "find_nearest_node",
    "find_nearest_place",
    "find_patches",
    "find_successor",
    "has_dead_end",
    "is_end",
    "measure_enclosed",
    "remove_patch",
    "set_choice",
    "set_count",
    "take_samples",
    "trace_outline",
    "walk_face",
]
