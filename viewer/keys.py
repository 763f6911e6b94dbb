"""The pattern browser's keys: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer.browser_state import BrowserState
from viewer.keymap import Effect, KeyMap

#: (keys, what they do), as the help lists them.
KEY_HELP = (
    ("← →   Home End", "previous, next; first, last pattern"),
    ("p n", "previous, next page"),
    (", .", "fewer, more sides"),
    ("- +", "fewer, more irregular vertices; below 0: all"),
    ("v", "valences: any, 3–5, 3–6, 3–4, 4–5"),
    ("c", "convex patterns only"),
    ("[ ]", "choose a polychord"),
    ("↓ ↑", "make it narrower, wider"),
    ("r", "widths back to 1"),
    ("m", "mirror image"),
    ("t", "polychord tints"),
    ("l", "labels of sides and polychords"),
    ("i", "facts of the pattern"),
    ("s", "save a screenshot"),
    ("h ?", "this list"),
    ("q", "quit"),
)


#: Other names of keys: X's, and capitals.
ALIASES = {
    "bracketleft": "[",
    "bracketright": "]",
    "comma": ",",
    "period": ".",
    "<": ",",
    ">": ".",
    "=": "+",
    "_": "-",
    "less": ",",
    "greater": ".",
    "plus": "+",
    "equal": "+",
    "KP_Add": "+",
    "minus": "-",
    "underscore": "-",
    "KP_Subtract": "-",
    "question": "h",
    "?": "h",
    "Next": "n",
    "Prior": "p",
    "space": "n",
    "Escape": "q",
} | {c.upper(): c for c in "npvcrmtlishq"}

ACTIONS: dict[str, Callable[[BrowserState], None]] = {
    "Left": lambda b: b.step(-1),
    "Right": lambda b: b.step(1),
    "Home": lambda b: b.select(0),
    "End": lambda b: b.select(len(b.rows) - 1),
    "n": lambda b: b.turn_page(1),
    "p": lambda b: b.turn_page(-1),
    ",": lambda b: b.change_class(-1),
    ".": lambda b: b.change_class(1),
    "+": lambda b: b.change_irregular(1),
    "-": lambda b: b.change_irregular(-1),
    "v": lambda b: b.change_valences(),
    "c": lambda b: b.toggle_convex(),
    "[": lambda b: b.choose_chord(-1),
    "]": lambda b: b.choose_chord(1),
    "Up": lambda b: b.change_width(1),
    "Down": lambda b: b.change_width(-1),
    "r": lambda b: b.reset_widths(),
    "m": lambda b: b.toggle("mirrored"),
    "t": lambda b: b.toggle("tinted"),
    "l": lambda b: b.toggle("labelled"),
    "i": lambda b: b.toggle("inspecting"),
    "h": lambda b: b.toggle("helping"),
}


KEYS = KeyMap(ALIASES, ACTIONS, {"s": Effect.PICTURE, "q": Effect.QUIT})
