"""Where the sliders stand in the panel."""

from __future__ import annotations

from viewer.panel import MARGIN, PANEL
from viewer.scene import HEIGHT
from viewer.shapes.choice import HOLD, SIGMAS, STIFF
from viewer.slider import Rail, Slider

#: Modes on a page of the panel, from one to the next in points, and the height of the first.
MODES, ROW = 12, 41.0
MODES_TOP = HEIGHT - 232.0

#: Heights of the sliders of what pulls keep.
HOLD_Y, STIFFNESS_Y = 116.0, 66.0

#: A slider of the panel: the number of a mode, or the name of what pulls keep.
Knob = int | str

HOLDING = Slider("weight of held curves", *HOLD, digits=2)
STIFFENING = Slider("keep the present shape", *STIFF, digits=2)


def pages(n_modes: int) -> int:
    """How many pages of modes there are."""
    return -(-n_modes // MODES)


def rails(n_modes: int, page: int, left: float) -> dict[Knob, Rail]:
    """The sliders of a page of the panel; left: of the panel, from the picture's left."""
    start, end = left + MARGIN + 6.0, left + PANEL - MARGIN - 6.0
    found: dict[Knob, Rail] = {}
    for row, mode in enumerate(range(page * MODES, min((page + 1) * MODES, n_modes))):
        slider = Slider(f"{mode + 1}", -SIGMAS, SIGMAS, step=0.01, unit=" σ")
        found[mode] = Rail(slider, start, end, MODES_TOP - row * ROW)
    found["hold"] = Rail(HOLDING, start, end, HOLD_Y)
    found["stiffness"] = Rail(STIFFENING, start, end, STIFFNESS_Y)
    return found
