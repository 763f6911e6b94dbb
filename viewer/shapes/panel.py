"""What the viewer of shape models says beside its picture: the shape, its modes, what is held."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from viewer import style
from viewer.card import plural
from viewer.panel import MARGIN, PANEL, Writer, begin_panel
from viewer.scene import Scene
from viewer.shapes.choice import KEEP
from viewer.shapes.layout import HOLD_Y, MODES, pages
from viewer.shapes.state import ShapesState
from viewer.slider import KNOB, LABEL_UP, Rail

#: The marks of the limits of pulls: half their height and width, in points; and of the knob of a
#: mode that is at one, or beyond.
TICK = (6.0, 0.9)
LIMIT = "#d55e00"
BEYOND = style.MESSAGE
TICKS = "#8792a0"

#: The mark of the mode that arrow keys change, left of its slider.
CHOSEN = 4.5


def panel(scene: Scene, state: ShapesState) -> None:
    """Write the panel."""
    writer = begin_panel(scene, names=84.0)
    _facts(writer, state)
    left = scene.width - PANEL
    rails, value, hot = state.rails, state.value, state.knob_under()
    limits, (low, high) = state.limits, state.box
    for knob, rail in rails.items():
        if isinstance(knob, int):
            _limits(scene, rail, (float(low[knob]), float(high[knob])))
            rail.paint(scene, value[knob], hot=knob == hot, mark=0.0)
            _mode(scene, state, knob, rail)
            _mark(scene, rail, value[knob], int(limits[knob]))
        else:
            default = 1.0 if knob == "hold" else KEEP
            enabled = knob != "hold" or bool(state.choice.held)
            rail.paint(scene, value[knob], hot=knob == hot, mark=default, enabled=enabled)
    count = state.shapes.n_modes
    if pages(count) > 1:
        first = state.page * MODES
        text = f"modes {first + 1}–{min(first + MODES, count)} of {count}    ,  ."
        y = HOLD_Y + LABEL_UP + 24.0
        grey = style.FAINT_TEXT
        scene.text(left + PANEL - MARGIN, y, text, 11.0, colour=grey, align="right")


def _facts(writer: Writer, state: ShapesState) -> None:
    shapes = state.shapes
    writer.heading(state.choice.origin, 18.0)
    writer.fact("model", f"{plural(len(shapes.names), 'shape')}, {plural(shapes.n_modes, 'mode')}")
    writer.fact("mesh", f"{len(shapes.mean):,} vertices, {len(shapes.quads):,} quads")
    name, apart = state.nearest
    writer.fact("nearest", name + (f", {apart:.3g} units off" if apart > 1e-9 else ""))
    what = "one vertex" if state.bending else "whole curve"
    way = "on the screen" if state.axis is None else f"along {'xyz'[state.axis]}"
    writer.fact("pulls", f"{what}, {way}")
    held = sorted(name.replace("_", " ") for name in state.choice.held)
    writer.fact("held", ", ".join(held) if 0 < len(held) < 3 else plural(len(held), "curve"))
    writer.fact("ghost", state.ghost_name or "none")


def _mode(scene: Scene, state: ShapesState, mode: int, rail: Rail) -> None:
    """The share of the variance beside the mode's number, and the mark of the chosen one."""
    share = f"{100.0 * state.shapes.shares[mode]:.3g} %"
    grey = style.FAINT_TEXT
    scene.text(rail.left + 22.0, rail.y + LABEL_UP, share, 10.5, colour=grey, align="left")
    if mode == state.chosen:
        x, y = rail.left - 16.0, rail.y
        arrow = np.array([[0.0, CHOSEN], [1.4 * CHOSEN, 0.0], [0.0, -CHOSEN]])
        scene.polygons(_at(arrow, x - CHOSEN, y), face=style.BOUNDARY)


def _limits(scene: Scene, rail: Rail, box: tuple[float, float]) -> None:
    """Ticks at the least and the greatest coefficient of the training shapes."""
    height, width = TICK
    for at in box:
        x = rail.knob(at)
        tick = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * (width, height)
        scene.polygons(_at(tick, x, rail.y), face=TICKS)


def _mark(scene: Scene, rail: Rail, value: float, limit: int) -> None:
    """Another knob at a limit of pulls, or beyond."""
    if limit:
        x = rail.knob(value)
        face = BEYOND if abs(limit) > 1 else LIMIT
        scene.polygons(_at(style.circle() * KNOB, x, rail.y), face=face)
        scene.polygons(_at(style.circle() * 0.42 * KNOB, x, rail.y), face=style.PAPER)


def _at(corners: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
    """(1, c, 2) a polygon elsewhere."""
    return corners[None] + np.array([x, y])
