"""When two fills are the same, and when vertex numbers alone tell a fill's quads apart.

Reducing a fill gives back its pattern and widths, so different fits are different fills,
with one exception: where a polychord that crosses itself is wider than 1, its copies
never collapse, and two patterns, or one in two ways, may expand to the same fill.
"""

from __future__ import annotations

import hashlib

import numpy as np

from patterndb.core.code import rooted_code
from patterndb.core.halfedge import Int32Array
from query.fill import Fill
from query.weld import weld_quads


def is_mesh(quads: Int32Array) -> bool:
    """Has every quad of (q, 4) four vertices, and do no two edges join the same two?

    Collapsing may draw two edges of a pattern together until they share both ends; only
    where a polychord across them is wider than 1 does such a pattern expand to a mesh.
    """
    corners = np.sort(quads, axis=1)
    # Two edges between the same vertices have two half-edges that run the same way.
    heads = np.roll(quads, -1, axis=1)
    edges = np.sort((quads.astype(np.int64) << 32 | heads).ravel())
    return bool((corners[:, 1:] != corners[:, :-1]).all() and (edges[1:] != edges[:-1]).all())


def fill_key(fill: Fill, closed: bool) -> bytes:
    """:func:`quads_key` of a fill."""
    twin, _ = weld_quads(fill.quads, fill.n_vertices, fill.perimeter)
    return quads_key(fill.quads, twin, closed)


def quads_key(quads: Int32Array, twin: Int32Array, closed: bool) -> bytes:
    """Equal exactly for equal fills of one boundary.

    quads: (q, 4), twin: (4q,) their half-edges. A digest of the code as read from boundary
    vertex 0. A closed side has no first vertex: there it is the smallest code from any.
    """
    border = np.flatnonzero(twin < 0)
    starts = border if closed else border[quads.ravel()[border] == 0]
    q = len(quads)
    # Wider than the codes of patterns, which name at most 16,383 quads.
    code = np.zeros(4 * q, np.int32)
    number, entry, order = (np.empty(q, np.int32) for _ in range(3))
    for at, start in enumerate(starts.tolist()):
        rooted_code(
            twin,
            q,
            start,
            False,
            code,  # pyright: ignore[reportArgumentType]
            number,
            entry,
            order,
            at > 0,
        )
    return hashlib.blake2b(code.tobytes(), digest_size=16).digest()
