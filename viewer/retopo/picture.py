"""The picture of retopology: the surface, quads on it, the network, and what is being done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.network import EVEN, Density
from viewer import style
from viewer.axes import draw_axes, draw_line
from viewer.picture import Frame
from viewer.retopo import paint
from viewer.retopo.marks import (
    BRUSH,
    CURVE,
    EDGE,
    EMPTY_DASH,
    EMPTY_WIDTH,
    FLOW,
    IMAGE,
    INK,
    MARKED,
    PREVIEW,
    REMADE,
    SNAP,
    WRONG,
    choose_side_colour,
    make_chain_curves,
    make_empty_marks,
    make_node_marks,
)
from viewer.retopo.pointing import find_visible
from viewer.retopo.state import RetopoState
from viewer.scene import Scene
from viewer.stage import (
    AWAY,
    MATTE,
    Curves,
    Drawn,
    Faces,
    Layer,
    LayerCache,
    Lift,
    LineLook,
    SmoothFaces,
    make_discs,
    make_rings,
    make_valence_marks,
)

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


def measure_lift(state: RetopoState) -> Lift:
    """Measure how much nearer than they are curves are drawn."""
    own = LIFT * state.surface.diagonal
    if state.quads_shown:
        own += QUAD_LIFT * state.shown.body.edge
    return Lift(LIFT_POINTS, own)


def measure_quad_lift(state: RetopoState) -> Lift:
    """Measure how much nearer than they are quads are drawn."""
    return Lift(0.0, LIFT * state.surface.diagonal + QUAD_LIFT * state.shown.body.edge)


def make_quad_layers(
    state: RetopoState,
    stale: frozenset[int],
    lit: int | None,
    density: NDArray[np.float64] | None,
    radius: float,
) -> list[Layer]:
    """Make quads in the colours of their patches, their edges, and irregular vertices.

    stale: patches that are left out. lit: the one that is lighter. density: (t, 3) at the corners
    of the body's triangles, None where it is not seen. radius: of markers, in points.
    """
    body, lift = state.shown.body, measure_quad_lift(state)
    gone = np.fromiter(stale, np.int64, len(stale))
    kept = ~np.isin(body.owner, gone)
    corners, normals = body.corners[kept], body.normals[kept]
    tints = np.stack(
        [style.parse_colour(choose_side_colour(n)) for n in range(int(body.sides.max()) + 1)]
    )
    tint = tints[body.sides[kept]]
    tint[body.flipped[kept]] = style.parse_colour(WRONG)
    if lit is not None:
        tint = np.where((body.owner[kept] == lit)[:, None], tint + LIGHTER * (1.0 - tint), tint)
    colours = np.repeat(tint[:, None], 3, axis=1).astype(np.float32)
    if density is not None:
        colours = paint.tint(colours, density[kept])
    # The side that looks away from the surface is the front, of flipped quads, too.
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    turned = (own * normals.mean(axis=1)).sum(axis=1) < 0.0
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    faces[turned] = faces[turned, ::-1]
    above = lift.above(0.8)
    # Curves are drawn over the edges along them.
    shown = ~np.isin(body.of, gone) & ~(body.rims & state.curves_shown)
    edges = body.edges[shown].reshape(-1, 3)
    look = LineLook(EDGE, EDGE_WIDTH, above)
    rim = ~np.isin(body.rim, gone)
    at = body.irregular[rim]
    return [
        Faces(
            "quads",
            corners.reshape(-1, 3),
            faces,
            point_colours=colours.reshape(-1, 3),
            normals=normals.reshape(-1, 3),
            lift=lift,
            sheets=True,
        ),
        Curves("edges", edges, (2,) * (len(edges) // 2), look, body.up[shown].reshape(-1, 3)),
        *make_valence_marks(
            "valences",
            body.mesh.vertices[at],
            body.valences[rim],
            radius,
            above.above(2.6),
            body.mesh.normals[at],
        ),
    ]


def make_remade_quads(name: str, quads: Points, lift: Lift) -> list[Layer]:
    """Make quads (q, 4, 3) that would be made, over those that are there."""
    points = quads.reshape(-1, 3)
    faces = np.arange(len(points)).reshape(-1, 4)
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    own = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    up = np.repeat(own, 4, axis=0)
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-300)
    return [
        Faces(name, points, faces, REMADE, normals=up, lift=lift.above(1.0), sheets=True),
        Curves.of(
            f"{name} edges",
            list(edges),
            LineLook(PREVIEW, REMADE_WIDTH, lift.above(2.4)),
            list(np.repeat(up, 2, axis=0).reshape(-1, 2, 3)),
        ),
    ]


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
        self._cache = LayerCache()
        self._surface_paint, self._quad_paint = paint.KeptDensity(), paint.KeptDensity()

    def compose(
        self, state: RetopoState, width: float, height: float, *, axes: bool = False
    ) -> Drawn:
        """The picture of so many points; axes: with those of space in a corner."""
        frame = Frame.of(state.camera, width, height)
        scene, middle = frame.scene, frame.middle
        layers = [*self._make_surface(state), *self._make_network(state), *_make_pointed(state)]
        _line(scene, state, middle)
        if state.tool.mode.gesture == "count":
            _counts(scene, state, middle)
        if axes:
            draw_axes(scene, state.camera.view.axes, state.camera.upright)
        return frame.drawn(layers)

    def _make_surface(self, state: RetopoState) -> list[Layer]:
        """The surface; what is below quads is deeper than it is, lest it should come through, and
        the half that is only an image is darker."""
        look, surface, shown = state.camera.model_look, state.surface, state.shown
        if look == "hidden":
            return []
        smooth = self._cache.get(
            "smooth", (surface,), lambda: SmoothFaces.of(surface.vertices, surface.triangles)
        )
        painted = state.density_shown and bool(state.network.density.strokes)
        density = state.network.density if painted else EVEN
        sunken = state.quads_shown and len(shown.body.owner) > 0

        def make() -> list[Layer]:
            below = np.zeros(len(smooth.faces), np.bool_)
            if sunken:
                under = shown.body.under
                covered = (under >= 0) & ~np.isin(under, np.fromiter(shown.stale(), np.int64))
                below = covered[smooth.place][smooth.faces].all(axis=1)
            colours = self._colour_surface(state, density)
            whole = Faces(
                "surface",
                smooth.points,
                smooth.faces[~below],
                point_colours=None if colours is None else colours[smooth.place],
                normals=smooth.normals,
                faded=look == "through",
            )
            if not sunken:
                return [whole]
            sunk = Lift(0.0, -SINK * shown.body.edge)
            under = replace(whole, name="below quads", faces=smooth.faces[below], lift=sunk)
            return [whole, under]

        inputs = (smooth, shown, look, sunken, density, shown.state.plane)
        return self._cache.get("surface", inputs, make)

    def _colour_surface(self, state: RetopoState, density: Density) -> NDArray[np.float32] | None:
        """Colour the surface's vertices (v, 3); None if all are alike."""
        surface, plane = state.surface, state.shown.state.plane
        if plane is None and density is EVEN:
            return None
        colours = np.tile(style.parse_colour(MATTE).astype(np.float32), (len(surface.vertices), 1))
        if plane is not None:
            colours[plane.heights(surface.vertices) < 0.0] *= np.float32(DARKER)
        if density is not EVEN:
            value = self._surface_paint.at(density, surface.vertices, surface.normals)
            colours = paint.tint(colours, value)
        return colours

    def _make_network(self, state: RetopoState) -> list[Layer]:
        lit = state.tool.patch_under() if state.tool.mode.target == "patch" else None
        shown, scale = state.shown, state.camera.view.scale
        radius = float(np.clip(MARKER[0] * shown.body.edge * scale, *MARKER[1:]))
        layers: list[Layer] = []
        if state.quads_shown and len(shown.body.owner):
            density = state.network.density if state.density_shown else None

            def make() -> list[Layer]:
                corners, normals = shown.body.corners, shown.body.normals
                value = None if density is None else self._quad_paint.at(density, corners, normals)
                return make_quad_layers(state, shown.stale(), lit, value, radius)

            inputs = (shown, state.curves_shown, density, lit, radius)
            layers += self._cache.get("quads", inputs, make)
        if state.curves_shown:
            through, lift = _through(state), measure_lift(state)
            inputs = (shown, state.network, state.quads_shown, through, scale)
            layers += self._cache.get("curves", inputs, lambda: _make_curves(state))
            # Their halves lie as they are seen.
            layers += make_node_marks(
                state.network, state.camera.view, lift.above(1.5), through=through
            )
            look = LineLook(WRONG, EMPTY_WIDTH, lift, EMPTY_DASH / scale)
            layers.append(
                make_empty_marks(state.network, state.editing.list_empty(), look, through=through)
            )
        return layers


def _through(state: RetopoState) -> bool:
    return state.camera.model_look != "solid"


def _make_curves(state: RetopoState) -> list[Layer]:
    """Make the network's curves, their images, and the lines that quads follow."""
    network, through, lift = state.network, _through(state), measure_lift(state)
    plain = [chain for chain in network.chains.values() if not chain.marked]
    marked = [chain for chain in network.chains.values() if chain.marked]
    own = make_chain_curves("curves", plain, LineLook(CURVE, CURVE_WIDTH, lift), through=through)
    layers: list[Layer] = [
        own,
        make_chain_curves("marked", marked, LineLook(MARKED, CURVE_WIDTH, lift), through=through),
    ]
    plane = state.shown.state.plane
    if plane is not None and len(own.points):
        up = None if own.normals is None else plane.mirror_directions(own.normals)
        look = LineLook(IMAGE, 0.8 * CURVE_WIDTH, lift)
        layers.append(Curves("images", plane.mirror(own.points), own.sizes, look, up))
    flows = [flow.points for patch in network.patches.values() for flow in filling_of(patch).flows]
    look = LineLook(FLOW, 2.4, lift.above(0.5), DASH / state.camera.view.scale)
    layers.append(_make_laid("flows", state, flows, look))
    return layers


def _make_laid(name: str, state: RetopoState, lines: Sequence[Points], look: LineLook) -> Curves:
    """Make curves of lines (k, 3) on the surface; what faces away is left out."""
    normals = None
    if not _through(state):
        normals = [state.surface.nearest(line).normals for line in lines]
    return Curves.of(name, lines, look, normals)


def _make_pointed(state: RetopoState) -> list[Layer]:
    """Make what is under the pointer, what is drawn, and what would be made."""
    view, lift, tool = state.camera.view, measure_lift(state), state.tool
    layers: list[Layer] = []
    lit = tool.patch_under() if tool.mode.target == "patch" else None
    patch = None if lit is None else state.network.patches.get(lit)
    if patch is not None and state.quads_shown:
        around = [state.network.chains[half >> 1] for half in patch.loop]
        look = LineLook(style.SELECTED, CURVE_WIDTH + 1.6, lift.above(0.8))
        layers.append(make_chain_curves("patch", around, look, through=_through(state)))
    meant = [state.network.chains[chain] for chain in tool.chains_meant()]
    look = LineLook(style.SELECTED, CURVE_WIDTH + 2.2, lift.above(0.8))
    layers.append(make_chain_curves("meant", meant, look, through=True))
    if state.quads_shown:
        for line, colour in zip(tool.strips_under(), style.STRANDS, strict=False):
            rim = LineLook(style.PAPER, STRAND_WIDTH + 2.0, lift.above(0.6))
            look = LineLook(colour, STRAND_WIDTH, lift.above(1.2 + STRAND_WIDTH))
            layers.append(_make_laid(f"strip rim {colour}", state, [line], rim))
            layers.append(_make_laid(f"strip {colour}", state, [line], look))
    layers += _make_preview(state)
    if len(tool.line) > 1 and tool.holding and tool.mode.gesture != "corner":
        colour = FLOW if tool.mode.gesture == "within" else INK
        line = np.stack(tool.line)
        layers.append(Curves.of("drawn", [line], LineLook(colour, INK_WIDTH, lift.above(2.0))))
        if (image := tool.mirror(line)) is not None:
            look = LineLook(colour, IMAGE_WIDTH, lift.above(1.6))
            layers.append(Curves.of("drawn image", [image], look))
    snaps = tool.snaps()
    if snaps:
        layers.append(make_rings("snaps", np.stack(snaps), SNAP, RING, lift.above(5.0)))
    middle, brush = tool.brush_at, tool.brush
    if brush > 0.0 and middle is not None:
        x, y = np.cos(t := np.linspace(0.0, 2.0 * np.pi, CIRCLE)), np.sin(t)
        # A circle that faces the viewer: on the surface it would hide behind what is round.
        ring = middle + brush * np.stack([x, y], axis=1) @ view.axes[:2]
        look = LineLook(BRUSH, 1.4, Lift(lift.points, lift.space + brush), 4.0 / view.scale)
        layers.append(Curves.of("brush", [ring], look))
    return layers


def _make_preview(state: RetopoState) -> list[Layer]:
    """Make what would be made."""
    preview, mirror, lift = state.tool.preview, state.tool.mirror, measure_lift(state)
    if preview is None:
        return []
    layers: list[Layer] = []
    images = [image for curve in preview.curves if (image := mirror(curve)) is not None]
    for name, lines, colour, width, raised in (
        ("preview rim", preview.curves, style.PAPER, PREVIEW_WIDTH + 2.2, 1.0),
        ("preview image", images, PREVIEW, IMAGE_WIDTH, 4.0),
        ("preview", preview.curves, PREVIEW, PREVIEW_WIDTH, 4.4),
    ):
        layers.append(Curves.of(name, lines, LineLook(colour, width, lift.above(raised))))
    if preview.quads is not None:
        layers += make_remade_quads("remade", preview.quads, lift)
        if (image := mirror(preview.quads)) is not None:
            # Turned over, as the quads of the image are.
            layers += make_remade_quads("remade image", image[:, ::-1], lift)
    if preview.corners is not None:
        at = preview.corners
        layers.append(make_discs("corner rims", at, style.PAPER, 5.4, lift.above(4.0)))
        layers.append(make_discs("corners made", at, PREVIEW, 4.2, lift.above(4.5)))
    return layers


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
