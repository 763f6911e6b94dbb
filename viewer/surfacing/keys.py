"""The keys of the viewer of surfaces: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from patterndb_sketch.surfacing.methods import METHODS
from viewer import keys
from viewer.keymap import Effect, KeyMap
from viewer.surfacing.layout import alpha_of, share_of
from viewer.surfacing.state import SurfacingState

#: (keys, what they do), as the help lists them.
KEY_HELP = (
    ("- +", "alpha: more chords, fewer"),
    ("click", "switch a patch off; on again at its ring"),
    ("x", "the same for the patch at the pointer"),
    ("a", "switch all patches on"),
    ("m", f"next method: {', '.join(METHODS)}"),
    ("n", "next method for the patch at the pointer"),
    ("← →", "stage of the drawing: back, forward"),
    ("Home End", "before the first stage, after the last"),
    ("d", "draw strokes on the surface (drag)"),
    ("Enter", "make the last stroke a curve"),
    ("u", "take back: stroke, curve, click, method"),
    ("w   e", "surface, chords: hide or show"),
    ("r   t", "curves, edges of faces: hide or show"),
    ("c", "patches that are off: hide or show"),
    ("v   z", "view as at first; roll it"),
    ("s   o", "save the picture; the surface as OBJ"),
    ("h ?   q", "this list; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag: turn    right drag: turn, always    middle drag: shift    wheel: zoom"

#: How far the keys - and + move the slider, as a part of it.
SLIDE = 0.04

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in keys.ALIASES.items() if key in {*"+-"} or key == "h"}
    | {"space": "Right", "Return": "Enter", "KP_Enter": "Enter", "BackSpace": "u"}
    | {c.upper(): c for c in "xamnduwertcvzsohq"}
)

ACTIONS: dict[str, Callable[[SurfacingState], None]] = {
    "-": lambda s: slide(s, -SLIDE),
    "+": lambda s: slide(s, SLIDE),
    "x": lambda s: s.toggle_patch(),
    "a": lambda s: s.all_on(),
    "m": lambda s: s.next_method(),
    "n": lambda s: s.next_method_here(),
    "Left": lambda s: s.step(-1),
    "Right": lambda s: s.step(1),
    "Home": lambda s: s.go_to_stage(0),
    "End": lambda s: s.go_to_stage(-1),
    "d": lambda s: s.begin_drawing(),
    "Enter": lambda s: s.add_curves(),
    "u": lambda s: s.undo(),
    "w": lambda s: s.toggle("surface_shown"),
    "e": lambda s: s.toggle("chords_shown"),
    "r": lambda s: s.toggle("curves_shown"),
    "t": lambda s: s.toggle("edges_shown"),
    "c": lambda s: s.toggle("off_shown"),
    "v": lambda s: s.fit(),
    "z": lambda s: s.roll(),
    "h": lambda s: s.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"s": Effect.PICTURE, "o": Effect.OBJ, "q": Effect.QUIT}


def slide(state: SurfacingState, by: float) -> None:
    """Move the slider of alpha by a part of its length."""
    state.change_alpha(alpha_of(share_of(state.settings.alpha) + by))


def _leave(state: SurfacingState) -> bool:
    """Leave drawing or the help; False if there is nothing to leave."""
    left = state.drawing_mode or state.helping
    if left:
        state.helping = False
        state.leave()
    return left


KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, _leave)
