"""The picture of retopology: the surface, quads on it, the network, and what is being done."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.filling.surface import FilledSurface
from patterndb_sketch.retopo.network import EVEN
from viewer import style
from viewer.axes import draw_axes, draw_line
from viewer.camera import View
from viewer.picture import Drawn, Frame
from viewer.retopo import paint
from viewer.retopo.marks import (
    AWAY,
    BRUSH,
    CURVE,
    EDGE,
    FLOW,
    IMAGE,
    INK,
    MARKED,
    PREVIEW,
    REMADE,
    SNAP,
    WRONG,
    choose_side_colour,
    cut_runs,
    make_empty_marks,
    make_node_marks,
    make_valence_marks,
    project_chains,
)
from viewer.retopo.pointing import find_visible
from viewer.retopo.state import RetopoState
from viewer.scene import Scene
from viewer.skin import MATTE, Shading, Skin, shade_model
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons

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


def measure_lift(state: RetopoState) -> float:
    """Measure how much nearer than they are curves are drawn, in points."""
    own = LIFT_POINTS + LIFT * state.surface.diagonal * state.camera.view.scale
    if state.quads_shown:
        own += QUAD_LIFT * state.shown.body.edge * state.camera.view.scale
    return own


def draw_quads(
    state: RetopoState,
    body: FilledSurface,
    stale: frozenset[int],
    lit: int | None,
    density: NDArray[np.float64] | None,
) -> list[Triangles]:
    """Draw quads in the colours of their patches, their edges, and irregular vertices.

    density: (t, 3) at the corners of the body's triangles, None where it is not seen.
    """
    view = state.camera.view
    gone = np.fromiter(stale, np.int64, len(stale))
    kept = ~np.isin(body.owner, gone)
    corners, normals = body.corners[kept], body.normals[kept]
    lift = LIFT * state.surface.diagonal + QUAD_LIFT * body.edge
    # What faces away is behind the surface, not before it: sheets may be thin.
    away = normals.mean(axis=1) @ view.axes[2] < 0.0
    raised = corners + np.where(away, -lift, lift)[:, None, None] * view.axes[2]
    seen, bright = shade_model(Skin(raised, normals), view, (0.0, 0.0), through=False)
    tints = np.stack(
        [style.parse_colour(choose_side_colour(n)) for n in range(int(body.sides.max()) + 1)]
    )
    tint = tints[body.sides[kept]]
    tint[body.flipped[kept]] = style.parse_colour(WRONG)
    if lit is not None:
        tint = np.where((body.owner[kept] == lit)[:, None], tint + LIGHTER * (1.0 - tint), tint)
    colours = np.minimum(bright / style.parse_colour(MATTE) * tint[:, None], 1.0)
    colours = colours.astype(np.float32)
    if density is not None:
        colours = paint.tint(colours, density[kept])
    parts: list[Triangles] = [(seen, colours)]
    above = lift * view.scale + 0.8
    own = ~np.isin(body.of, gone) & (body.up.mean(axis=1) @ view.axes[2] > AWAY)
    # Curves are drawn over the edges along them.
    own &= ~(body.rims & state.curves_shown)
    lines = view.seen(body.edges[own])
    parts.append(make_ribbons(list(lines), EDGE, EDGE_WIDTH, above))
    radius = float(np.clip(MARKER[0] * body.edge * view.scale, *MARKER[1:]))
    facing = body.mesh.normals[body.irregular] @ view.axes[2] > AWAY
    facing &= ~np.isin(body.rim, gone)
    for valence in np.unique(body.valences[facing]).tolist():
        here = body.irregular[facing & (body.valences == valence)]
        places = view.seen(body.mesh.vertices[here])
        parts += make_valence_marks(places, valence, radius, above + 2.6)
    return parts


def draw_remade_quads(quads: Points, view: View, lift: float) -> list[Triangles]:
    """Draw quads (q, 4, 3) that would be made, over those that are there."""
    seen = view.seen(quads)
    around = np.roll(seen, -1, axis=1)
    # Those that are seen from behind are on the far side.
    turned = (seen[..., 0] * around[..., 1] - around[..., 0] * seen[..., 1]).sum(axis=1)
    seen = seen[turned > 0.0]
    above = np.array([0.0, 0.0, lift + 1.0])
    faces = (seen + above)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    colours = np.broadcast_to(style.parse_colour(REMADE), faces.shape).astype(np.float32)
    edges = np.stack([seen, np.roll(seen, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return [(faces, colours), make_ribbons(list(edges), PREVIEW, REMADE_WIDTH, lift + 2.4)]


#: The surface below quads is drawn deeper by this part of an edge.
SINK = 1.0

#: How bright the half is that is only an image of the other.
DARKER = 0.84

#: Widths in points: of curves, what is being drawn, and what would be.
CURVE_WIDTH, INK_WIDTH, PREVIEW_WIDTH = 3.0, 3.4, 3.0

#: Likewise of the image of what is drawn, or would be, beyond the plane of symmetry; of strands.
IMAGE_WIDTH, STRAND_WIDTH = 2.2, 2.4

#: Radii in points: of the ring around what is snapped to.
RING = (6.0, 9.0)

#: Points of a brush's circle, and of a dash.
CIRCLE, DASH = 72, 6.0


class RetopoPainter:
    """Composes pictures; what stays the same while only the pointer moves is kept."""

    def __init__(self) -> None:
        self._shading = Shading()
        self._key: tuple[object, ...] = ()
        self._kept: list[Triangles] = []
        self._sunk: tuple[object, ...] = ()
        self._made = NOTHING
        self._surface_paint, self._quad_paint = paint.KeptDensity(), paint.KeptDensity()

    def compose(
        self, state: RetopoState, width: float, height: float, *, axes: bool = False
    ) -> Drawn:
        """The picture of so many points; axes: with those of space in a corner."""
        frame = Frame.of(state.camera, width, height)
        scene, middle = frame.scene, frame.middle
        model = self._surface(state, middle)
        solid = frame.solid([*self._network(state), *_pointed(state)], model)
        _line(scene, state, middle)
        if state.tool.mode.gesture == "count":
            _counts(scene, state, middle)
        if axes:
            draw_axes(scene, state.camera.view.axes, state.camera.upright)
        return frame.drawn(solid)

    def _surface(self, state: RetopoState, middle: tuple[float, float]) -> Triangles:
        """The surface; what is below quads is deeper than it is, lest it should come through, and
        the half that is only an image is darker."""
        seen, colours = self._shading.model(
            state.skin, state.camera.view, state.camera.model_look, middle
        )
        shown, plane, quads = state.shown, state.shown.state.plane, state.quads_shown
        painted = state.density_shown and bool(state.network.density.strokes)
        sunken = quads and len(shown.body.owner) > 0
        if not len(seen) or not (sunken or painted or plane is not None):
            return seen, colours
        density = state.network.density if painted else EVEN
        key = (seen, shown, quads, density)
        if len(self._sunk) != len(key) or any(
            a is not b for a, b in zip(key, self._sunk, strict=True)
        ):
            self._sunk = key
            deeper, darker = seen, colours
            if sunken:
                under = shown.body.under
                gone = np.fromiter(shown.stale(), np.int64)
                below = ((under >= 0) & ~np.isin(under, gone))[state.surface.triangles]
                deeper = seen.copy()
                deeper[..., 2] -= SINK * shown.body.edge * state.camera.view.scale * below
            if plane is not None:
                beyond = (plane.heights(state.surface.vertices) < 0.0)[state.surface.triangles]
                darker = np.where(beyond[..., None], np.float32(DARKER) * colours, colours)
            if painted:
                surface = state.surface
                value = self._surface_paint.at(density, surface.vertices, surface.normals)
                darker = paint.tint(darker, value[surface.triangles])
            self._made = deeper, darker
        return self._made

    def _network(self, state: RetopoState) -> list[Triangles]:
        lit = state.tool.patch_under() if state.tool.mode.target == "patch" else None
        shown = state.shown
        key = (
            shown,
            state.camera.view,
            state.camera.model_look,
            state.quads_shown,
            state.curves_shown,
            state.density_shown,
            lit,
        )
        if self._key != key:
            self._key = key
            parts: list[Triangles] = []
            if state.quads_shown and len(shown.body.owner):
                body, density = shown.body, None
                if state.density_shown:
                    density = self._quad_paint.at(state.network.density, body.corners, body.normals)
                parts += draw_quads(state, body, shown.stale(), lit, density)
            if state.curves_shown:
                parts += _curves(state)
                lift, through = measure_lift(state), _through(state)
                parts.append(
                    make_empty_marks(
                        state.network,
                        state.editing.list_empty(),
                        state.camera.view,
                        lift,
                        through=through,
                    )
                )
            self._kept = parts
        return self._kept


def _through(state: RetopoState) -> bool:
    return state.camera.model_look != "solid"


def _curves(state: RetopoState) -> list[Triangles]:
    """The network: its curves, corners and ends, and the lines that quads follow."""
    network, view = state.network, state.camera.view
    through, lift = _through(state), measure_lift(state)
    plain = [chain for chain in network.chains.values() if not chain.marked]
    marked = [chain for chain in network.chains.values() if chain.marked]
    parts = [
        make_ribbons(project_chains(plain, view, through=through), CURVE, CURVE_WIDTH, lift),
        make_ribbons(project_chains(marked, view, through=through), MARKED, CURVE_WIDTH, lift),
    ]
    plane = state.shown.state.plane
    if plane is not None:
        images: list[Points] = []
        for chain in plain:
            facing = plane.mirror_directions(chain.normals) @ view.axes[2] > AWAY
            line = plane.mirror(chain.round)
            facing = np.concatenate([facing, facing[:1]]) if chain.is_closed_loop else facing
            images += cut_runs(view.seen(line), facing | through)
        parts.append(make_ribbons(images, IMAGE, 0.8 * CURVE_WIDTH, lift))
    flows = [flow.points for patch in network.patches.values() for flow in filling_of(patch).flows]
    for line in flows:
        up = state.surface.nearest(line).normals @ view.axes[2] > AWAY
        for part in cut_runs(view.seen(line), up | through):
            parts.append(make_ribbons(dash_line(part, DASH), FLOW, 2.4, lift + 0.5))
    return parts + make_node_marks(network, view, lift + 1.5, through=through)


def _pointed(state: RetopoState) -> list[Triangles]:
    """What is under the pointer, what is drawn, and what would be made."""
    view, lift = state.camera.view, measure_lift(state)
    parts: list[Triangles] = []
    lit = state.tool.patch_under() if state.tool.mode.target == "patch" else None
    patch = None if lit is None else state.network.patches.get(lit)
    if patch is not None and state.quads_shown:
        around = [state.network.chains[half >> 1] for half in patch.loop]
        lines = project_chains(around, view, through=_through(state))
        parts.append(make_ribbons(lines, style.SELECTED, CURVE_WIDTH + 1.6, lift + 0.8))
    meant = [state.network.chains[chain] for chain in state.tool.chains_meant()]
    if meant:
        lines = project_chains(meant, view, through=True)
        colour = style.SELECTED
        parts.append(make_ribbons(lines, colour, CURVE_WIDTH + 2.2, lift + 0.8))
    if state.quads_shown:
        parts += _strips(state, view, lift)
    preview, mirror = state.tool.preview, state.tool.mirror
    if preview is not None:
        for curve in preview.curves:
            parts.append(
                make_ribbons([view.seen(curve)], style.PAPER, PREVIEW_WIDTH + 2.2, lift + 1.0)
            )
            parts.append(make_ribbons([view.seen(curve)], PREVIEW, PREVIEW_WIDTH, lift + 2.4))
            if (image := mirror(curve)) is not None:
                parts.append(make_ribbons([view.seen(image)], PREVIEW, IMAGE_WIDTH, lift + 2.0))
        if preview.quads is not None:
            parts += draw_remade_quads(preview.quads, view, lift)
            if (image := mirror(preview.quads)) is not None:
                # Turned over, as the quads of the image are.
                parts += draw_remade_quads(image[:, ::-1], view, lift)
        if preview.corners is not None:
            places = view.seen(preview.corners)
            parts.append(make_discs(places, style.PAPER, 5.4, lift + 4.0))
            parts.append(make_discs(places, PREVIEW, 4.2, lift + 4.5))
    if len(state.tool.line) > 1 and state.tool.holding and state.tool.mode.gesture != "corner":
        colour = FLOW if state.tool.mode.gesture == "within" else INK
        line = np.stack(state.tool.line)
        parts.append(make_ribbons([view.seen(line)], colour, INK_WIDTH, lift + 2.0))
        if (image := mirror(line)) is not None:
            parts.append(make_ribbons([view.seen(image)], colour, IMAGE_WIDTH, lift + 1.6))
    snaps = state.tool.snaps()
    if snaps:
        parts.append(make_discs(view.seen(np.stack(snaps)), SNAP, RING[1], lift + 5.0, RING[0]))
    middle, brush = state.tool.brush_at, state.tool.brush
    if brush > 0.0 and middle is not None:
        x, y = np.cos(t := np.linspace(0.0, 2.0 * np.pi, CIRCLE)), np.sin(t)
        # A circle that faces the viewer: on the surface it would hide behind what is round.
        at = view.seen(middle)
        ring = at + brush * view.scale * np.stack([x, y, 0.0 * x], axis=1)
        ring[:, 2] = at[2] + brush * view.scale
        parts.append(make_ribbons(dash_line(ring, 4.0), BRUSH, 1.4, lift))
    return parts


def _strips(state: RetopoState, view: View, lift: float) -> list[Triangles]:
    """The strands of quads through the pointer, each in a colour of its own."""
    parts: list[Triangles] = []
    for line, colour in zip(state.tool.strips_under(), style.STRANDS, strict=False):
        up = state.surface.nearest(line).normals @ view.axes[2] > AWAY
        for run in cut_runs(view.seen(line), up | _through(state)):
            parts.append(make_ribbons([run], style.PAPER, STRAND_WIDTH + 2.0, lift + 0.6))
            parts.append(make_ribbons([run], colour, STRAND_WIDTH, lift + 1.2))
    return parts


def _line(scene: Scene, state: RetopoState, middle: tuple[float, float]) -> None:
    """The straight line that is dragged across the view."""
    ends = state.tool.plane_line
    if ends is None:
        return
    a, b = (np.array(end) + np.array(middle) for end in ends)
    for width, colour in ((2.6, style.PAPER), (1.2, INK)):
        draw_line(scene, a, b, width, colour)
    for end in (a, b):
        scene.polygons((end + style.make_circle() * 5.0)[None], face=INK)


def _counts(scene: Scene, state: RetopoState, middle: tuple[float, float]) -> None:
    """How many edges every curve has, at its middle; those that are pinned in bold."""
    view, network = state.camera.view, state.network
    chains = [chain for chain in network.chains.values() if chain.count]
    if not chains:
        return
    lines = [chain.round for chain in chains]
    places = np.stack([line[len(line) // 2] for line in lines])
    up = np.stack([chain.normals[len(chain.normals) // 2] for chain in chains])
    shown = np.ones(len(chains), np.bool_)
    if not _through(state):
        shown = (up @ view.axes[2] > AWAY) & find_visible(view, state.surface, places)
    meant = set(state.tool.chains_meant())
    seen = view.seen(places)[:, :2] + np.array(middle)
    inside = (seen > 0.0).all(axis=1) & (seen[:, 0] < 2.0 * middle[0] - 12.0)
    for k in np.flatnonzero(shown & inside).tolist():
        chain, (x, y) = chains[k], seen[k].tolist()
        rim = style.SELECTED if chain.id in meant else CURVE if chain.pinned else "#b9c1cb"
        border = 1.6 if chain.pinned else 1.0
        scene.number(x, y, chain.count, 11.0, rim, border, bold=chain.pinned)
