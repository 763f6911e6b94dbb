"""What the viewer of feature curves says beside its picture: what to do now, and facts."""

from __future__ import annotations

from patterndb_sketch.features.edits import DrawnCurve
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.features.sliders import name_axis
from viewer.features.state import FeatureState

HINTS = {
    0: "click along a feature of the model    Esc: leave",
    1: "click on along the feature    ⌫: take back    Esc: drop",
    2: "click on, or Enter: finish    ⌫: take back    Esc: drop",
    3: "click on, the first point: close it    Enter: finish    ⌫: take back    Esc: drop",
}
CLOSING = "click: close the curve here    ⌫: take back    Esc: drop"


def tell_hint(state: FeatureState) -> str:
    """Tell what is to be done now, in a line."""
    if state.editing.clicks is not None:
        return CLOSING if state.closing else HINTS[min(len(state.editing.clicks), max(HINTS))]
    under = state.under()
    if under is not None and under.pin is not None:
        return "drag the pin    D: take it away"
    if state.editing.curve is not None:
        return "drag the curve: a pin holds it there    Del: delete    E: name    C: draw another"
    if state.editing.edits.curves:
        return "click a curve to choose it, or drag it: a pin holds it there    C: draw another"
    return "C: draw a curve"


def describe_features(sheet: FactSheet, state: FeatureState) -> None:
    """Write what there is to say of the curve that is drawn or selected."""
    settings = state.editing.shown_settings
    sheet.fact("curves", f"{len(state.editing.edits.curves)}")
    chosen = name_axis(settings) or "  ".join(f"{c:.2g}" for c in settings.axis)
    sheet.fact("axis", chosen + ("" if settings.alpha < 1.0 else ", counts where alpha is below 1"))
    sheet.fact("degree", str(settings.degree))
    _facts(sheet, state)


def _facts(sheet: FactSheet, state: FeatureState) -> None:
    curve = state.editing.preview if state.editing.clicks is not None else state.editing.curve
    if curve is None:
        sheet.paragraph(
            "the sliders are those of the next curve"
            if state.editing.clicks is None
            else "the curve snaps after two clicks",
            style.FAINT_TEXT,
        )
        return
    _curve(sheet, state, curve)


def _curve(sheet: FactSheet, state: FeatureState, curve: DrawnCurve) -> None:
    look, snap = state.editing.look(curve), state.editing.snap_of(curve)
    sheet.heading(curve.name)
    if look is not None:
        sheet.fact("length", f"{look.spline.length:.4g}")
        count = format_count(len(look.spline.control), "control point")
        sheet.fact("spline", f"{count}, closed" if look.spline.closed else count)
    if snap is not None:
        found = snap.curve
        text = f"{len(snap.ribs):,}"
        text += f", {len(found.repaired)} mended" if found.repaired else ""
        text += f", {len(found.failed)} failed" if found.failed else ""
        sheet.fact("ribs", text)
        if found.ended:
            sheet.fact("at an end", f"{len(found.ended)}: it may be farther off")
    elif state.editing.making:
        sheet.fact("ribs", "working …")
    notes = () if look is None or look.found is None else look.found.notes
    for note in notes:
        sheet.paragraph(note, style.FAINT_TEXT)
    if state.editing.trouble(curve):
        sheet.paragraph(state.editing.trouble(curve), style.MESSAGE)
