"""What the viewer of feature curves says beside its picture: curves, sliders, facts."""

from __future__ import annotations

import numpy as np

from viewer import style
from viewer.card import format_count
from viewer.facts import FactWriter
from viewer.features.edits import DrawnCurve, choose_curve_colour
from viewer.features.layout import (
    AXES,
    CHOICES,
    DEGREE,
    FACTS,
    FIRST_ROW,
    HALF_CHOICE,
    ROW,
    ROWS,
    choose_rows,
    get_slider_value,
    name_axis,
    place_rails,
)
from viewer.features.state import FeatureState
from viewer.panel import LETTER, MARGIN, PANEL, begin_panel, draw_hint
from viewer.scene import HIGHLIGHT, HIGHLIGHT_LINE, Scene
from viewer.slider import ENDS_DOWN

HINTS = {
    0: "click along a feature of the model    Esc: leave",
    1: "click on along the feature    ⌫: take back    Esc: drop",
    2: "click on, or Enter: finish    ⌫: take back    Esc: drop",
    3: "click on, the first point: close it    Enter: finish    ⌫: take back    Esc: drop",
}
CLOSING = "click: close the curve here    ⌫: take back    Esc: drop"
NAMING = "type a name    Enter: keep it    Esc: leave it as it was"

#: After a name that is typed. (VTK takes "|" for the border of two columns.)
CURSOR = "\N{LEFT ONE EIGHTH BLOCK}"

#: Letters of a curve's name that the list has room for.
LONGEST = 24


def draw_panel(scene: Scene, state: FeatureState) -> None:
    """Write the panel, and above the picture what is to be done now."""
    left = scene.width - PANEL
    writer = begin_panel(scene, names=84.0)
    writer.heading(_fitted(state.title or "Feature curves", writer.room, 17.0), 17.0)
    _list(scene, state, left)
    settings = state.editing.shown_settings
    for name, rail in place_rails(left).items():
        rail.paint(scene, get_slider_value(settings, name), hot=state.sliding == name)
        if name == "angle" and settings.alpha == 1.0:
            y, grey = rail.y - ENDS_DOWN, style.FAINT_TEXT
            scene.text(
                left + MARGIN, y, "counts where alpha is below 1", 10.5, colour=grey, align="left"
            )
    _choices(scene, state, left)
    writer.y = FACTS
    _facts(writer, state)
    if state.message:
        writer.skip(0.4)
        writer.paragraph(state.message, style.MESSAGE)
    if not state.editing.helping and tell_hint(state):
        draw_hint(scene, tell_hint(state))


def tell_hint(state: FeatureState) -> str:
    """Tell what is to be done now, in a line; "" for nothing in particular."""
    if state.editing.typed is not None:
        return NAMING
    if state.editing.clicks is not None:
        return CLOSING if state.closing else HINTS[min(len(state.editing.clicks), max(HINTS))]
    return "" if state.editing.edits.curves else "press c to draw a curve along a feature"


def describe_features(writer: FactWriter, state: FeatureState) -> None:
    """Write what there is to say of the curve that is drawn or selected."""
    settings = state.editing.shown_settings
    writer.fact("curves", f"{len(state.editing.edits.curves)}")
    chosen = name_axis(settings) or "  ".join(f"{c:.2g}" for c in settings.axis)
    writer.fact(
        "axis", chosen + ("" if settings.alpha < 1.0 else ", counts where alpha is below 1")
    )
    writer.fact("degree", str(settings.degree))
    _facts(writer, state)


def _list(scene: Scene, state: FeatureState, left: float) -> None:
    curves = state.editing.edits.curves
    drawn = state.editing.preview if state.editing.clicks is not None else None
    if drawn is not None:
        curves = (*curves, drawn)
    picked = state.editing.curve if state.editing.clicks is None else drawn
    shown = choose_rows(len(curves), None if picked is None else curves.index(picked))
    under = state.under()
    for row, i in enumerate(shown):
        curve, y = curves[i], FIRST_ROW - ROW * row
        colour, bold = style.TEXT, False
        if curve is picked:
            scene.box(
                left + MARGIN / 2.0, y - ROW / 2.0 + 1.0, PANEL - MARGIN, ROW - 2.0,
                HIGHLIGHT, HIGHLIGHT_LINE,
            )  # fmt: skip
            bold = True
        elif under is not None and under.key == curve.key:
            colour, bold = style.SELECTED, True
        dash = np.array([[0.0, -2.2], [20.0, -2.2], [20.0, 2.2], [0.0, 2.2]])
        scene.polygons(
            (dash + np.array([left + MARGIN, y]))[None], face=choose_curve_colour(curve.key)
        )
        naming = curve.key == state.editing.selected and state.editing.typed is not None
        name = f"{state.editing.typed}{CURSOR}" if naming else _short(curve.name)
        at = left + MARGIN + 30.0
        scene.text(at, y - 4.5, name, 12.5, colour=colour, bold=bold, align="left")
        right = scene.width - MARGIN
        text = format_count(len(curve.constraints), "pin") if curve.constraints else ""
        text = "drawing" if curve is drawn else text
        text = "failed" if state.editing.trouble(curve) else text
        scene.text(right, y - 4.5, text, 11.5, colour=style.FAINT_TEXT, align="right")
    hidden = len(curves) - len(shown)
    if hidden:
        y = FIRST_ROW - ROW * ROWS
        text = f"{hidden} more    Tab"
        scene.text(left + MARGIN + 30.0, y, text, 11.0, colour=style.FAINT_TEXT, align="left")
    if not curves:
        text = "no curve yet"
        scene.text(
            left + MARGIN, FIRST_ROW - 4.5, text, 12.5, colour=style.FAINT_TEXT, align="left"
        )


def _choices(scene: Scene, state: FeatureState, left: float) -> None:
    """The axis, and the degree between its two buttons."""
    settings = state.editing.shown_settings
    y = CHOICES - 4.5
    grey = style.FAINT_TEXT
    scene.text(left + MARGIN, y, "axis", 13.0, bold=True, align="left")
    chosen = name_axis(settings)
    for axis, at in AXES.items():
        on = axis == chosen
        _button(scene, left + at, axis, on)
    if chosen is None:
        # Another direction: none of the three is chosen.
        text = "  ".join(f"{c:.2g}" for c in settings.axis)
        scene.text(left + MARGIN, y - 20.0, text, 11.0, colour=grey, align="left")
    middle = left + (DEGREE[-1] + DEGREE[1]) / 2.0
    scene.text(left + DEGREE[-1] - 22.0, y, "degree", 13.0, bold=True, align="right")
    scene.text(middle, y, str(settings.degree), 13.0)
    _button(scene, left + DEGREE[-1], "\N{MINUS SIGN}", False)
    _button(scene, left + DEGREE[1], "+", False)


def _button(scene: Scene, x: float, text: str, on: bool) -> None:
    half = HALF_CHOICE
    box = (x - half[0], CHOICES - half[1], 2.0 * half[0], 2.0 * half[1])
    scene.box(*box, HIGHLIGHT if on else style.PAPER, HIGHLIGHT_LINE if on else "#d3d9e1")
    scene.text(x, CHOICES - 4.5, text, 13.0, bold=on)


def _facts(writer: FactWriter, state: FeatureState) -> None:
    curve = state.editing.preview if state.editing.clicks is not None else state.editing.curve
    if curve is None:
        writer.paragraph(
            "the sliders are those of the next curve"
            if state.editing.clicks is None
            else "the curve snaps after two clicks",
            style.FAINT_TEXT,
        )
        return
    _curve(writer, state, curve)


def _curve(writer: FactWriter, state: FeatureState, curve: DrawnCurve) -> None:
    look, snap = state.editing.look(curve), state.editing.snap_of(curve)
    writer.heading(_short(curve.name))
    if look is not None:
        writer.fact("length", f"{look.spline.length:.4g}")
        count = format_count(len(look.spline.control), "control point")
        writer.fact("spline", f"{count}, closed" if look.spline.closed else count)
    if snap is not None:
        found = snap.curve
        text = f"{len(snap.ribs):,}"
        text += f", {len(found.repaired)} mended" if found.repaired else ""
        text += f", {len(found.failed)} failed" if found.failed else ""
        writer.fact("ribs", text)
        if found.ended:
            writer.fact("at an end", f"{len(found.ended)}: it may be farther off")
    elif state.editing.making:
        writer.fact("ribs", "working …")
    notes = () if look is None or look.found is None else look.found.notes
    for note in notes:
        writer.paragraph(note, style.FAINT_TEXT)
    if state.editing.trouble(curve):
        writer.paragraph(state.editing.trouble(curve), style.MESSAGE)


def _short(name: str) -> str:
    return name if len(name) <= LONGEST else name[: LONGEST - 1] + "…"


def _fitted(text: str, room: float, size: float) -> str:
    most = int(room / (LETTER * 1.12 * size))
    return text if len(text) <= most else text[: most - 1] + "…"
