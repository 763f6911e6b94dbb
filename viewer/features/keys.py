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
    "c": lambda s: s.editing.begin_curve(),
    "Enter": lambda s: s.editing.finish_curve(),
    "BackSpace": lambda s: s.editing.take_back(),
    "d": lambda s: s.unpin(),
    "Tab": lambda s: s.editing.select_next(1),
    "BackTab": lambda s: s.editing.select_next(-1),
    "Delete": lambda s: s.editing.delete(),
    "e": lambda s: s.editing.begin_name(),
    "a": lambda s: s.editing.snap_again(),
    "-": lambda s: s.editing.slide("alpha", -SLIDE),
    "+": lambda s: s.editing.slide("alpha", SLIDE),
    ",": lambda s: s.editing.slide("stiffness", -SLIDE),
    ".": lambda s: s.editing.slide("stiffness", SLIDE),
    "[": lambda s: s.editing.slide("angle", -SLIDE),
    "]": lambda s: s.editing.slide("angle", SLIDE),
    "x": lambda s: s.editing.choose_axis("x"),
    "y": lambda s: s.editing.choose_axis("y"),
    "z": lambda s: s.editing.choose_axis("z"),
    "Up": lambda s: s.editing.change_degree(1),
    "Down": lambda s: s.editing.change_degree(-1),
    "u": lambda s: s.editing.take_back(),
    "U": lambda s: s.editing.redo(),
    "r": lambda s: s.editing.toggle("ribs_shown"),
    "m": lambda s: s.camera.next_model_look(),
    "1": lambda s: s.camera.look_along((-1.0, 0.0, 0.0)),
    "2": lambda s: s.camera.look_along((0.0, -1.0, 0.0)),
    "3": lambda s: s.camera.look_along((0.0, 0.0, 1.0)),
    "v": lambda s: s.camera.fit(),
    "g": lambda s: s.camera.next_upright(),
    "f": lambda s: s.camera.roll(),
    "s": lambda s: s.editing.save_session(),
    "n": lambda s: s.editing.save_network(),
    "o": lambda s: s.editing.save_lines(),
    "h": lambda s: s.editing.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"p": Effect.PICTURE, "q": Effect.QUIT}

KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, lambda s: s.editing.leave())
