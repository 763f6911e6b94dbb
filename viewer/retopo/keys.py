"""The keys of the window of retopology: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from patterndb_sketch.retopo.table import TOOLS
from viewer.keymap import ALIASES, Effect, KeyMap
from viewer.retopo.modes import list_modes
from viewer.retopo.state import RetopoState

#: (keys, what they do), as the help lists them. Those of the tools are in the panel.
KEY_HELP = (
    ("a tool's key", "take the tool with that key in the list"),
    ("Tab", "the next tool of the list"),
    ("[ ]", "brush smaller, larger; for counts: edges"),
    ("- +", "less, more: completions, divisions, edges"),
    (".", "the tool's option, as the panel shows it"),
    ("n b", "next fill of the patch at the pointer; before"),
    ("Ctrl wheel", "edges of the curve at the pointer"),
    ("Shift wheel", "edges of all curves of its strip of quads"),
    ("Enter", "the same as a click"),
    ("Del   E", "erase the curve at the pointer; all open ends"),
    ("C", "choose all counts anew but pinned ones"),
    ("u   U", "undo; redo"),
    ("m   x", "surface, see-through or not; quads, curves"),
    ("1 2 3   v", "along the axes; as at first"),
    ("Z   F", "which axis is upright; roll the view"),
    ("s   o", "save the session; the quads as OBJ"),
    ("S   p", "save what was done as a script; the picture"),
    ("R", "open what a crash left, as told at the start"),
    ("h ?   Esc   q", "this list; leave, drop what waits; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "left: draw    right drag: turn    middle drag: shift    wheel: zoom"

#: Keys of tools that the table has.
MODE_KEYS = {mode.key: mode.tool for mode in list_modes() if mode.key}

#: Other names of keys: X's, and capitals that mean nothing else.
ALIASES = (
    {name: key for name, key in ALIASES.items() if key in {*"+-[]."} or key == "h"}
    | {"Return": "Enter", "KP_Enter": "Enter", "ISO_Left_Tab": "BackTab", "space": "."}
    | {f"KP_{i}": str(i) for i in (1, 2, 3)}
    | {
        k.upper(): k
        for k in [*MODE_KEYS, *"nbmxvopqh"]
        if k.upper() not in {*"ECUZFSR", *MODE_KEYS}
    }
)


def _taking(tool: str) -> Callable[[RetopoState], None]:
    return lambda s: s.choose_mode(tool)


ACTIONS: dict[str, Callable[[RetopoState], None]] = {
    **{key: _taking(tool) for key, tool in MODE_KEYS.items()},
    "Tab": lambda s: s.next_mode(1),
    "BackTab": lambda s: s.next_mode(-1),
    "[": lambda s: s.wider(-1),
    "]": lambda s: s.wider(1),
    "-": lambda s: s.more(-1),
    "+": lambda s: s.more(1),
    ".": lambda s: s.next_option(),
    "n": lambda s: s.next_fill(1),
    "b": lambda s: s.next_fill(-1),
    "Enter": lambda s: s.accept(),
    "Delete": lambda s: s.erase_under(),
    "E": lambda s: s.editing.do("erase", open=True),
    "C": lambda s: s.editing.do("recount"),
    "u": lambda s: s.editing.undo(),
    "U": lambda s: s.editing.redo(),
    "m": lambda s: s.camera.next_model_look(),
    "x": lambda s: s.next_seen(),
    "1": lambda s: s.camera.look_along((1.0, 0.0, 0.0)),
    "2": lambda s: s.camera.look_along((0.0, 1.0, 0.0)),
    "3": lambda s: s.camera.look_along((0.0, 0.0, 1.0)),
    "v": lambda s: s.camera.fit(),
    "Z": lambda s: s.camera.next_upright(),
    "F": lambda s: s.camera.roll(),
    "s": lambda s: s.editing.save_session(),
    "o": lambda s: s.editing.save_mesh(),
    "S": lambda s: s.editing.save_script(),
    "R": lambda s: s.editing.recover(),
    "h": lambda s: s.toggle("helping"),
}

#: What the window does itself.
EFFECTS = {"p": Effect.PICTURE, "q": Effect.QUIT}

#: Keys that a tool may not have.
RESERVED = frozenset(ACTIONS) - frozenset(MODE_KEYS) | frozenset(EFFECTS)

for _tool in TOOLS.values():
    if _tool.control.key in RESERVED:
        raise ValueError(
            f"{_tool.name}: the key {_tool.control.key!r} means something else in the window; "
            f"taken are {' '.join(sorted(RESERVED))}, and the keys of other tools"
        )

KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, lambda s: s.leave())
