"""The keys of the viewer of feature curves: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer.features.state import FeatureState
from viewer.keymap import ALIASES, Effect, KeyMap

#: (keys, what they do), as the help lists them.
KEY_HELP = (
    ("c", "draw a curve: click points on the model"),
    ("Enter  ⌫", "finish it; take the last click back"),
    ("drag", "pull a curve: a pin holds it where it is dropped"),
    ("d", "take the pin at the pointer away"),
    ("click  Tab", "select a curve; the next one"),
    ("Del  e", "delete the selected curve; name it"),
    ("a", "snap it again, from where it is now"),
    ("- +   , .", "alpha; stiffness: less, more"),
    ("[ ]", "isophote angle: less, more"),
    ("x y z", "the axis that the angle is measured from"),
    ("↓ ↑", "degree of the spline: less, more"),
    ("u   U", "take back; do again"),
    ("r   m", "ribs; model solid, see-through, hidden"),
    ("1 2 3   v", "from the front, the side, above; as at first"),
    ("g   f", "which axis is upright; roll the view"),
    ("s", "save the session"),
    ("o   n", "save curves as OBJ; as a network of JSON"),
    ("p", "save the picture"),
    ("h ?   Esc   q", "this list; leave; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag beside curves: turn    right drag: turn    middle drag: shift    wheel: zoom"

#: How far keys move a slider, as a part of it.
SLIDE = 0.04

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in ALIASES.items() if key in {*"+-,.[]"} or key == "h"}
    | {"Return": "Enter", "KP_Enter": "Enter", "space": "Tab", "ISO_Left_Tab": "BackTab"}
    | {c.upper(): c for c in "cdeaxyzrmvgfsonphq"}
    | {f"KP_{i}": str(i) for i in (1, 2, 3)}
)

ACTIONS: dict[str, Callable[[FeatureState], None]] = {
    "c": lambda s: s.begin_curve(),
    "Enter": lambda s: s.finish_curve(),
    "BackSpace": lambda s: s.take_back(),
    "d": lambda s: s.unpin(),
    "Tab": lambda s: s.select_next(1),
    "BackTab": lambda s: s.select_next(-1),
    "Delete": lambda s: s.delete(),
    "e": lambda s: s.begin_name(),
    "a": lambda s: s.snap_again(),
    "-": lambda s: s.slide("alpha", -SLIDE),
    "+": lambda s: s.slide("alpha", SLIDE),
    ",": lambda s: s.slide("stiffness", -SLIDE),
    ".": lambda s: s.slide("stiffness", SLIDE),
    "[": lambda s: s.slide("angle", -SLIDE),
    "]": lambda s: s.slide("angle", SLIDE),
    "x": lambda s: s.choose_axis("x"),
    "y": lambda s: s.choose_axis("y"),
    "z": lambda s: s.choose_axis("z"),
    "Up": lambda s: s.change_degree(1),
    "Down": lambda s: s.change_degree(-1),
    "u": lambda s: s.take_back(),
    "U": lambda s: s.redo(),
    "r": lambda s: s.toggle("ribs_shown"),
    "m": lambda s: s.next_model_look(),
    "1": lambda s: s.look_along((-1.0, 0.0, 0.0)),
    "2": lambda s: s.look_along((0.0, -1.0, 0.0)),
    "3": lambda s: s.look_along((0.0, 0.0, 1.0)),
    "v": lambda s: s.fit(),
    "g": lambda s: s.next_upright(),
    "f": lambda s: s.roll(),
    "s": lambda s: s.save_session(),
    "n": lambda s: s.save_network(),
    "o": lambda s: s.save_lines(),
    "h": lambda s: s.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"p": Effect.PICTURE, "q": Effect.QUIT}

KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, lambda s: s.leave())
