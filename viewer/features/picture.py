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
from viewer.painting import make_bars
from viewer.picture import Frame
from viewer.stage import Curves, Drawn, Faces, Layer, LayerCache, Lift, LineLook, Marks, make_discs
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
GLINT = (-1.6, 1.7)

RIB_COLOUR, MENDED, FAILED = "#5b708c", "#d9730d", "#c0183c"
INK = "#1f2733"

#: Length of a dash, in points.
DASH = 6.0


class FeaturePainter:
    """Composes pictures; what stays the same while only curves change is kept."""

    def __init__(self) -> None:
        self._cache = LayerCache()

    def compose(self, state: FeatureState, width: float, height: float) -> Drawn:
        """The picture of so many points."""
        frame = Frame.of(state.camera, width, height)
        look, model = state.camera.model_look, state.editing.model
        layers: list[Layer] = []
        if look != "hidden":
            layers.append(
                self._cache.get(
                    "model",
                    (model, look),
                    lambda: Faces(
                        "model", model.vertices, model.triangles, faded=look == "through"
                    ),
                )
            )
        layers += _make_curves(state)
        settings = state.editing.shown_settings
        chosen = (name_axis(settings) or "") if settings.alpha < 1.0 else ""
        draw_axes(frame.scene, state.camera.view.axes, chosen)
        return frame.drawn(layers)


def _make_curves(state: FeatureState) -> list[Layer]:
    """Make curves with their clicks and pins; the selected one with its ribs."""
    layers: list[Layer] = []
    under = state.under()
    picked = state.editing.preview if state.editing.clicks is not None else state.editing.curve
    if state.editing.ribs_shown and picked is not None:
        layers += _make_ribs(state, picked)
    drawn = [(curve, state.editing.look(curve)) for curve in state.editing.edits.curves]
    if state.editing.preview is not None and state.editing.clicks is not None:
        drawn.append((state.editing.preview, state.editing.look(state.editing.preview)))
    lift = measure_lift(state)
    for number, (curve, look) in enumerate(drawn):
        if look is None:
            continue
        lit = curve is picked
        near = under is not None and under.key == curve.key
        colour, width = choose_curve_colour(curve.key), SELECTED if lit else CURVE
        if lit or near:
            rim = LineLook(style.PAPER if lit else style.SELECTED, RIM, lift)
            layers.append(Curves.of(f"rim {number}", [look.line], rim))
        above = lift.above(RIM / 2.0)
        band = LineLook(colour, width, above)
        layers.append(Curves.of(f"curve {number}", [look.line], band))
        ends = look.line[[0, -1]]
        layers.append(make_discs(f"ends {number}", ends, colour, width / 2.0, above))
        layers += _make_pins(state, curve, lift, number)
    sketched = state.editing.sketched()
    if sketched is not None:
        look = LineLook(INK, SKETCHED, lift, DASH / state.camera.view.scale)
        layers.append(Curves.of("sketched", [sketched], look))
    clicks = np.zeros((0, 3))
    colour = INK
    if state.editing.clicks is not None and state.editing.clicks:
        clicks = np.stack(state.editing.clicks)
    elif state.editing.clicks is None and picked is not None:
        clicks, colour = picked.clicked, choose_curve_colour(picked.key)
    layers.append(make_discs("click rims", clicks, colour, CLICKED + 1.4, lift.above(6.0)))
    layers.append(make_discs("clicks", clicks, style.PAPER, CLICKED, lift.above(6.4)))
    if state.closing:
        layers.append(
            make_discs("closing", clicks[:1], style.SELECTED, CLICKED + 1.4, lift.above(6.8))
        )
    return layers


def measure_lift(state: FeatureState) -> Lift:
    """Measure how much nearer than they are curves are drawn."""
    return Lift(LIFT, LIFT_SHARE * state.editing.model.diagonal)


def _make_pins(state: FeatureState, curve: DrawnCurve, lift: Lift, number: int) -> list[Layer]:
    """Make a pin for every sample that is held: a foot, a stem, and a head with a rim."""
    if not curve.constraints:
        return []
    under, view = state.under(), state.camera.view
    feet = np.stack([np.asarray(at, np.float64) for _, at in curve.constraints])
    heads = feet + np.array(PIN) @ view.axes[:2] / view.scale
    stems = [np.stack([foot, head]) for foot, head in zip(feet, heads, strict=True)]
    lift = lift.above(6.0)
    name, colour = f"pins {number}", choose_curve_colour(curve.key)
    glint = style.make_circle() * 0.3 * HEAD + GLINT
    layers: list[Layer] = [
        make_discs(f"{name} feet", feet, INK, FOOT, lift),
        Curves.of(f"{name} stems", stems, LineLook(INK, 1.8, lift)),
        make_discs(f"{name} rims", heads, INK, HEAD + 1.2, lift.above(1.0)),
        make_discs(f"{name} heads", heads, colour, HEAD, lift.above(1.5)),
        Marks(f"{name} glints", heads, glint, style.PAPER, lift.above(2.0)),
    ]
    numbers = [sample for sample, _ in curve.constraints]
    if under is not None and under.key == curve.key and under.pin in numbers:
        at = heads[numbers.index(under.pin)][None]
        layers.append(make_discs(f"{name} halo", at, style.SELECTED, HEAD + 4.4, lift.above(0.5)))
    return layers


def _make_ribs(state: FeatureState, curve: DrawnCurve) -> list[Layer]:
    """Make the ribs that a curve was found across, thin; and a cross where there is none."""
    snap = state.editing.snap_of(curve)
    if snap is None:
        return []
    whole = measure_lift(state)
    lift = Lift(0.45 * whole.points, 0.45 * whole.space)
    plain: list[Points] = []
    mended: list[Points] = []
    for rib in snap.ribs:
        if rib is None:
            continue
        at = np.linspace(0, len(rib.points) - 1, RIB_SAMPLES).round().astype(np.int64)
        (mended if rib.repaired else plain).append(rib.points[at])
    failed = snap.origins[list(snap.curve.failed)]
    arm = make_bars(MARK * np.array([[-1.0, -1.0]]), MARK * np.array([[1.0, 1.0]]), 2.2)[0]
    above = whole.above(3.0)
    return [
        Curves.of("ribs", plain, LineLook(RIB_COLOUR, RIB, lift)),
        Curves.of("mended ribs", mended, LineLook(MENDED, RIB, lift.above(0.4))),
        Marks("failed one way", failed, arm, FAILED, above),
        Marks("failed other way", failed, arm * (-1.0, 1.0), FAILED, above),
        make_discs("samples", snap.curve.samples, style.PAPER, 0.9, whole.above(1.4)),
    ]
