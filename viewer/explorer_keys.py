"""The fill explorer's keys: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer import keys
from viewer.explorer_state import ExplorerState
from viewer.keymap import Effect, KeyMap
from viewer.pen import Mode

#: (keys, what they do), as the help lists them; a lone head begins a group.
KEY_HELP = (
    ("← →", "previous, next fill"),
    ("Home End", "first, last fill so far"),
    ("m", "look for twice as many"),
    ("o", "order of the fills"),
    ("r", "relaxed or strict corners"),
    ("b", "draw a boundary: click its corners;"),
    ("", "click the last again, or Enter, to close"),
    ("⌫", "take the last corner back"),
    ("- +", "edges of the side at the pointer"),
    ("[ ]", "edges of all sides"),
    ("c", "corner at the pointer: convex, reflex"),
    ("k", "fill the boundary's other side"),
    ("s   l", "draw a stroke; a loop (drag)"),
    ("x", "forget the last stroke"),
    (", .", "tolerance of strokes, in edges"),
    ("f", "strands follow strokes, or not"),
    ("n", "show the fill, or the boundary alone"),
    ("v   u", "view back to the middle; roll it"),
    ("w   p", "save the fill as OBJ; the picture"),
    ("h ?   q", "this list; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag: turn    right drag: turn, always    middle drag: shift    wheel: zoom"

#: By how much the keys [ and ] scale edge counts.
FINER = 1.25

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in keys.ALIASES.items() if key in {*"[],.+-"} or key == "h"}
    | {
        "space": "Right",
        "Return": "Enter",
        "KP_Enter": "Enter",
        "Delete": "BackSpace",
        "Page_Down": "Next",
        "Page_Up": "Prior",
    }
    | {c.upper(): c for c in "morbcksxlfnvuwphq"}
)

ACTIONS: dict[str, Callable[[ExplorerState], None]] = {
    "Left": lambda e: e.step(-1),
    "Right": lambda e: e.step(1),
    "Prior": lambda e: e.step(-10),
    "Next": lambda e: e.step(10),
    "Home": lambda e: e.look_at(0),
    "End": lambda e: e.look_at(-1),
    "m": lambda e: e.more(),
    "o": lambda e: e.change_order(),
    "r": lambda e: e.toggle_strict(),
    "b": lambda e: _enter(e, Mode.CORNERS),
    "Enter": lambda e: e.close_boundary(),
    "BackSpace": lambda e: e.undo_corner(),
    "-": lambda e: e.change_length(-1),
    "+": lambda e: e.change_length(1),
    "[": lambda e: e.scale_lengths(1.0 / FINER),
    "]": lambda e: e.scale_lengths(FINER),
    "c": lambda e: e.toggle_corner(),
    "k": lambda e: e.reverse(),
    "s": lambda e: _enter(e, Mode.STROKE),
    "l": lambda e: _enter(e, Mode.LOOP),
    "x": lambda e: e.drop_stroke(),
    ",": lambda e: e.change_tolerance(-1),
    ".": lambda e: e.change_tolerance(1),
    "f": lambda e: e.toggle("following"),
    "n": lambda e: e.toggle("hiding"),
    "v": lambda e: e.fit(),
    "u": lambda e: e.roll(),
    "h": lambda e: e.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"w": Effect.OBJ, "p": Effect.PICTURE, "q": Effect.QUIT}


def _enter(state: ExplorerState, mode: Mode) -> None:
    """The key that entered a mode leaves it, too."""
    if state.mode is mode:
        state.leave()
    else:
        state.begin(mode)


def _leave(state: ExplorerState) -> bool:
    """Leave a mode or the help; False if there is none to leave."""
    left = state.mode is not Mode.LOOK or state.helping
    if left:
        state.helping = False
        state.leave()
    return left


KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, _leave)
