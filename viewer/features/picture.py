"""The picture of feature curves: the model, bands along curves, pins and ribs."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.edits import DrawnCurve
from viewer import style
from viewer.axes import draw_axes
from viewer.features.pointing import PIN
from viewer.features.sliders import name_axis
from viewer.features.state import FeatureState
from viewer.picture import Drawn, Frame
from viewer.skin import Shading
from viewer.solid import Triangles, dash_line, make_discs, make_ribbons
from viewer.style import choose_curve_colour

# Colours of curves: strong enough to stand out from a grey model.


#: Widths of lines in points: of curves, of the selected one and what is around it, of ribs.
CURVE, SELECTED, RIM, RIB, SKETCHED = 3.4, 4.6, 8.2, 1.1, 2.0

#: How much nearer than the surface lines are drawn: in points, and as a share of the model's
#: diagonal, as a spline cuts through bulges of the surface it is fitted to.
LIFT, LIFT_SHARE = 4.0, 0.0025

#: Radii in points: of clicked points, of the heads of pins, and of marks of ribs that failed.
CLICKED, HEAD, FOOT, MARK = 3.4, 5.6, 2.6, 4.5

#: Samples that a rib is drawn with.
RIB_SAMPLES = 49

#: Where the light is on the head of a pin, from its middle in points.
GLINT = (-1.6, 1.7, 0.0)

RIB_COLOUR, MENDED, FAILED = "#5b708c", "#d9730d", "#c0183c"
INK = "#1f2733"

#: Length of a dash, in points.
DASH = 6.0


class FeaturePainter:
    """Composes pictures; what stays the same while only curves change is kept."""

    def __init__(self) -> None:
        self._shading = Shading()

    def compose(self, state: FeatureState, width: float, height: float) -> Drawn:
        """The picture of so many points."""
        frame = Frame.of(state.camera, width, height)
        model = self._shading.model(
            state.skin, state.camera.view, state.camera.model_look, frame.middle
        )
        solid = frame.solid(_curves(state), model)
        settings = state.editing.shown_settings
        chosen = (name_axis(settings) or "") if settings.alpha < 1.0 else ""
        draw_axes(frame.scene, state.camera.view.axes, chosen)
        return frame.drawn(solid)


def _curves(state: FeatureState) -> list[Triangles]:
    """Curves with their clicks and pins; the selected one last, with its ribs."""
    parts: list[Triangles] = []
    under = state.under()
    picked = state.editing.preview if state.editing.clicks is not None else state.editing.curve
    if state.editing.ribs_shown and picked is not None:
        parts += _ribs(state, picked)
    drawn = [(curve, state.editing.look(curve)) for curve in state.editing.edits.curves]
    if state.editing.preview is not None and state.editing.clicks is not None:
        drawn.append((state.editing.preview, state.editing.look(state.editing.preview)))
    lift = measure_lift(state)
    for curve, look in drawn:
        if look is None:
            continue
        lit = curve is picked
        near = under is not None and under.key == curve.key
        line = state.camera.view.seen(look.line)
        if lit or near:
            rim = style.PAPER if lit else style.SELECTED
            parts.append(make_ribbons([line], rim, RIM, lift - RIM / 4.0 - 0.5))
        width = SELECTED if lit else CURVE
        parts.append(make_ribbons([line], choose_curve_colour(curve.key), width, lift))
        parts += _ends(line, curve, width, lift)
        parts += _pins(state, curve, lift)
    sketched = state.editing.sketched()
    if sketched is not None:
        dashes = dash_line(state.camera.view.seen(sketched), DASH)
        parts.append(make_ribbons(dashes, INK, SKETCHED, lift))
    clicks = np.zeros((0, 3))
    colour = INK
    if state.editing.clicks is not None and state.editing.clicks:
        clicks = np.stack(state.editing.clicks)
    elif state.editing.clicks is None and picked is not None:
        clicks, colour = picked.clicked, choose_curve_colour(picked.key)
    seen = state.camera.view.seen(clicks)
    parts.append(make_discs(seen, colour, CLICKED + 1.4, lift + 2.0))
    parts.append(make_discs(seen, style.PAPER, CLICKED, lift + 2.4))
    if state.closing:
        parts.append(make_discs(seen[:1], style.SELECTED, CLICKED + 1.4, lift + 2.8))
    return parts


def measure_lift(state: FeatureState) -> float:
    """Measure how much nearer than they are curves are drawn, in points."""
    return LIFT + LIFT_SHARE * state.editing.model.diagonal * state.camera.view.scale


def _ends(line: Points, curve: DrawnCurve, width: float, lift: float) -> list[Triangles]:
    """Round ends."""
    return [make_discs(line[[0, -1]], choose_curve_colour(curve.key), width / 2.0, lift)]


def _pins(state: FeatureState, curve: DrawnCurve, lift: float) -> list[Triangles]:
    """A pin for every sample that is held: a foot, a stem, and a head with a rim."""
    if not curve.constraints:
        return []
    under = state.under()
    feet = state.camera.view.seen(
        np.stack([np.asarray(at, np.float64) for _, at in curve.constraints])
    )
    heads = feet + np.array([*PIN, 0.0])
    stems = [np.stack([foot, head]) for foot, head in zip(feet, heads, strict=True)]
    lift += 3.0
    parts = [
        make_discs(feet, INK, FOOT, lift),
        make_ribbons(stems, INK, 1.8, lift),
        make_discs(heads, INK, HEAD + 1.2, lift + 1.0),
        make_discs(heads, choose_curve_colour(curve.key), HEAD, lift + 1.5),
        make_discs(heads + np.array(GLINT), style.PAPER, 0.3 * HEAD, lift + 2.0),
    ]
    numbers = [number for number, _ in curve.constraints]
    if under is not None and under.key == curve.key and under.pin in numbers:
        at = heads[numbers.index(under.pin)][None]
        parts.append(make_discs(at, style.SELECTED, HEAD + 4.4, lift + 0.5))
    return parts


def _ribs(state: FeatureState, curve: DrawnCurve) -> list[Triangles]:
    """The ribs that a curve was found across, thin; and a cross where there is none."""
    snap = state.editing.snap_of(curve)
    if snap is None:
        return []
    view, lift = state.camera.view, 0.45 * measure_lift(state)
    plain: list[Points] = []
    mended: list[Points] = []
    for rib in snap.ribs:
        if rib is None:
            continue
        at = np.linspace(0, len(rib.points) - 1, RIB_SAMPLES).round().astype(np.int64)
        (mended if rib.repaired else plain).append(view.seen(rib.points[at]))
    failed = view.seen(snap.origins[list(snap.curve.failed)])
    arms = MARK * np.array(
        [[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]], [[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]]
    )
    crosses = (failed[:, None, None] + arms).reshape(-1, 2, 3)
    found = view.seen(snap.curve.samples)
    return [
        make_ribbons(plain, RIB_COLOUR, RIB, lift),
        make_ribbons(mended, MENDED, RIB, lift + 0.4),
        make_ribbons(list(crosses), FAILED, 2.2, measure_lift(state) + 3.0),
        make_discs(found, style.PAPER, 0.9, measure_lift(state) + 1.4),
    ]
