"""Quads as they are drawn: in the colours of their patches, and those that would be made."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.retopo.body import Body
from viewer.retopo.marks import AWAY, shapes
from viewer.retopo.palette import (
    EDGE,
    PREVIEW,
    REMADE,
    WRONG,
    side_colour,
    valence_colour,
)
from viewer.retopo.state import RetopoState
from viewer.ribbons import Triangles, ribbons
from viewer.shading import MATTE, shaded
from viewer.skin import Skin
from viewer.view import View

#: How much nearer than it is the network is drawn: as a part of the surface's diagonal, as the
#: released program of Takayama et al. 2013 has it, and in points. Drawing only.
LIFT, LIFT_POINTS = 0.0005, 2.0

#: Flat quads cut through what is round: they are nearer by this part of an edge, too.
QUAD_LIFT = 0.1

#: Width in points of the edges of quads that would be made.
REMADE_WIDTH = 1.6

#: Width in points of the edges of quads that there are.
EDGE_WIDTH = 1.0

#: Radius of an irregular vertex's marker, in edges, least and most, in points.
MARKER = (0.17, 2.6, 6.0)

#: Quads under the pointer are lighter by this part of white.
LIGHTER = 0.25


def lift_of(state: RetopoState) -> float:
    """How much nearer than they are curves are drawn, in points."""
    own = LIFT_POINTS + LIFT * state.ground.diagonal * state.view.scale
    if state.quads_shown:
        own += QUAD_LIFT * state.shown.body.edge * state.view.scale
    return own


def drawn_quads(
    state: RetopoState, body: Body, stale: frozenset[int], lit: int | None
) -> list[Triangles]:
    """Quads in the colours of their patches, their edges, and irregular vertices."""
    view = state.view
    gone = np.fromiter(stale, np.int64, len(stale))
    kept = ~np.isin(body.owner, gone)
    corners, normals = body.skin.corners[kept], body.skin.normals[kept]
    lift = LIFT * state.ground.diagonal + QUAD_LIFT * body.edge
    # What faces away is behind the surface, not before it: sheets may be thin.
    away = normals.mean(axis=1) @ view.axes[2] < 0.0
    raised = corners + np.where(away, -lift, lift)[:, None, None] * view.axes[2]
    seen, bright = shaded(Skin(raised, normals), view, (0.0, 0.0), through=False)
    tints = np.stack([style.rgb(side_colour(n)) for n in range(int(body.sides.max()) + 1)])
    tint = tints[body.sides[kept]]
    tint[body.flipped[kept]] = style.rgb(WRONG)
    if lit is not None:
        tint = np.where((body.owner[kept] == lit)[:, None], tint + LIGHTER * (1.0 - tint), tint)
    colours = bright / style.rgb(MATTE) * tint[:, None]
    parts: list[Triangles] = [(seen, np.minimum(colours, 1.0).astype(np.float32))]
    above = lift * view.scale + 0.8
    own = ~np.isin(body.of, gone) & (body.up.mean(axis=1) @ view.axes[2] > AWAY)
    lines = view.seen(body.edges[own])
    parts.append(ribbons(list(lines), EDGE, EDGE_WIDTH, above))
    radius = float(np.clip(MARKER[0] * body.edge * view.scale, *MARKER[1:]))
    facing = body.mesh.normals[body.irregular] @ view.axes[2] > AWAY
    facing &= ~np.isin(body.rim, gone)
    for valence in np.unique(body.valences[facing]).tolist():
        here = body.irregular[facing & (body.valences == valence)]
        places = view.seen(body.mesh.vertices[here])
        shape = style.valence_shape(int(np.clip(valence, 2, 7)))
        if valence >= 7 or valence < 3:
            shape = style.circle()
        colour = valence_colour(valence)
        parts.append(shapes(places, shape * (radius + 1.1), style.PAPER, above + 2.6))
        parts.append(shapes(places, shape * radius, colour, above + 3.0))
    return parts


def remade_quads(quads: Points, view: View, lift: float) -> list[Triangles]:
    """Quads (q, 4, 3) that would be made, over those that are there."""
    seen = view.seen(quads)
    around = np.roll(seen, -1, axis=1)
    # Those that are seen from behind are on the far side.
    turned = (seen[..., 0] * around[..., 1] - around[..., 0] * seen[..., 1]).sum(axis=1)
    seen = seen[turned > 0.0]
    above = np.array([0.0, 0.0, lift + 1.0])
    faces = (seen + above)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    colours = np.broadcast_to(style.rgb(REMADE), faces.shape).astype(np.float32)
    edges = np.stack([seen, np.roll(seen, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return [(faces, colours), ribbons(list(edges), PREVIEW, REMADE_WIDTH, lift + 2.4)]
