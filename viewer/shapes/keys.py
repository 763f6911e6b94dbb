"""The keys of the viewer of shape models: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer import keys
from viewer.keymap import Effect, KeyMap
from viewer.shapes.state import ShapesState

#: (keys, what they do), as the help lists them.
KEY_HELP = (
    ("drag", "pull a curve: the shape follows"),
    ("click   c", "hold the curve at the pointer, or let it go"),
    ("a", "let all curves go"),
    ("m", "pull the whole curve, or one vertex of it"),
    ("x  y  z", "pull along an axis; again: on the screen"),
    ("↑ ↓", "choose a mode"),
    ("← →", "less, more of that mode"),
    (", .", "previous, next page of modes"),
    ("0", "the mean shape"),
    ("b n", "previous, next training shape"),
    ("r", "a random shape"),
    ("u   U", "take back; do again"),
    ("g", "ghost: none, mean, training shape"),
    ("w   e", "curves, edges of faces: hide or show"),
    ("1 2 3   v", "view along x, y, z; as at first"),
    ("p   o", "save the picture; the shape as OBJ"),
    ("Esc", "drop a pull; close this list; quit"),
    ("h ?   q", "this list; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag: turn    right drag: turn, always    middle drag: shift    wheel: zoom"

#: Standard deviations that an arrow key changes a mode by.
NUDGE = 0.1

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in keys.ALIASES.items() if key in {",", ".", "h"}}
    | {"Prior": ",", "Next": ".", "Home": "0", "BackSpace": "u", "space": "n"}
    | {f"KP_{i}": str(i) for i in range(4)}
    | {c.upper(): c for c in "camxyzbnrgwevpohq"}
)

Action = Callable[[ShapesState], None]


def _idle(action: Action) -> Action:
    """An action that waits until nothing is dragged: what is, goes on from where it began."""

    def press(state: ShapesState) -> None:
        if state.dragging:
            state.message = "let go first, or press Esc"
        else:
            action(state)

    return press


ACTIONS: dict[str, Action] = {
    "c": _idle(lambda s: s.hold_here()),
    "a": _idle(lambda s: s.let_go()),
    "m": lambda s: s.toggle_bending(),
    "x": lambda s: s.choose_axis(0),
    "y": lambda s: s.choose_axis(1),
    "z": lambda s: s.choose_axis(2),
    "Up": _idle(lambda s: s.choose_mode(-1)),
    "Down": _idle(lambda s: s.choose_mode(1)),
    "Left": _idle(lambda s: s.nudge(s.chosen, -NUDGE)),
    "Right": _idle(lambda s: s.nudge(s.chosen, NUDGE)),
    ",": _idle(lambda s: s.turn_page(-1)),
    ".": _idle(lambda s: s.turn_page(1)),
    "0": _idle(lambda s: s.reset()),
    "b": _idle(lambda s: s.step(-1)),
    "n": _idle(lambda s: s.step(1)),
    "r": _idle(lambda s: s.sample()),
    "u": _idle(lambda s: s.undo()),
    "U": _idle(lambda s: s.redo()),
    "g": lambda s: s.next_ghost(),
    "w": lambda s: s.toggle("curves_shown"),
    "e": lambda s: s.toggle("edges_shown"),
    "v": _idle(lambda s: s.look(0)),
    "1": _idle(lambda s: s.look(1)),
    "2": _idle(lambda s: s.look(2)),
    "3": _idle(lambda s: s.look(3)),
    "h": lambda s: s.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"p": Effect.PICTURE, "o": Effect.OBJ, "q": Effect.QUIT}

KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, lambda s: s.leave())
