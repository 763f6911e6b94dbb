"""Modes: what the mouse does, a tool of the editor each.

Modes come from the editor's table: from the arguments that a tool must have follows what the
mouse gives it, and what else a tool may be told are options of its mode. What is known of a
tool beyond that, its key and how it is best used, is in KNOWN; a tool that is not there gets a
mode all the same, without a key of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from patterndb_sketch.retopo.arguments import REQUIRED, Flag, Line, Number, Vector, Word
from patterndb_sketch.retopo.editor import TOOLS
from patterndb_sketch.retopo.tool import Tool

#: What the mouse gives a tool.
#: stroke: a line drawn on the surface. click: a point. drag: two points, pressed and released.
#: plane: a straight line across the view. scribble: a line, or a curve by a click. corner: a
#: point, or a wedge dragged to one. within: a line, or by a click a point of a patch. count: the
#: wheel changes the curve under the pointer. act: nothing; it is done when it is chosen.
Gesture = Literal[
    "stroke", "click", "drag", "plane", "scribble", "corner", "within", "count", "act"
]

#: What of the network is shown to be meant: where ends snap to, a curve, a corner, or a patch.
Target = Literal["ends", "chain", "corner", "patch", "none"]

#: Values of an option, in the order in which it goes through them.
Values = tuple[object, ...]


@dataclass(frozen=True, slots=True)
class Option:
    """name: of the tool's argument. values: that it goes through; the first is the default.
    number: are they numbers, which are less or more?"""

    name: str
    values: Values
    number: bool = False


@dataclass(frozen=True, slots=True)
class Mode:
    """A tool as the mouse has it.

    tool:    its name in calls. title: in lists. key: that chooses it, "" for none.
    gesture: what the mouse gives it. places: names of the arguments that take it.
    target:  what is shown to be meant. hint: what to do, in a line.
    brush:   the size, a field of ``Sizes``, that brush keys change here, "" for none; given_as:
             the argument that takes it, "" if it is changed for all tools.
    snaps:   may it be told within which radius it finds what is near?
    fixed:   arguments that are always so. options: what else the tool may be told.
    """

    tool: str
    title: str
    key: str
    gesture: Gesture
    places: tuple[str, ...]
    target: Target
    hint: str
    brush: str
    given_as: str
    snaps: bool
    fixed: tuple[tuple[str, object], ...]
    options: tuple[Option, ...]


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a tool beyond the table; "" where nothing is."""

    key: str
    title: str = ""
    hint: str = ""
    gesture: Gesture | None = None
    target: Target | None = None
    brush: str = ""
    fixed: tuple[tuple[str, object], ...] = ()


KNOWN: Mapping[str, Known] = {
    "stroke": Known("d", "draw", "draw a curve on the surface; its ends snap", brush="snap"),
    "spine": Known("i", "spine", "draw the midline of a patch    [ ]: its width", brush="spine"),
    "autocomplete": Known(
        "a",
        "complete",
        "point beside a patch; click: take it    - +: larger, smaller",
        target="none",
        brush="autocompletion",
    ),
    "cylinder": Known("c", "cylinder", "draw from one closed loop to another", brush="snap"),
    "loop": Known("l", "loop", "drag a line across a part: it is cut there", "plane", "none"),
    "erase": Known("e", "erase", "scribble over curves, or click one", "scribble", "chain"),
    "pull": Known("g", "pull", "drag a corner, an end or a curve", target="corner", brush="snap"),
    "redraw": Known("r", "redraw", "draw a part of a curve anew, from it back to it", brush="snap"),
    "align": Known("z", "align", "click a curve: it moves to ridges or valleys", target="chain"),
    "smooth": Known("f", "smooth", "click a curve: it becomes smooth", target="chain"),
    "corner": Known(
        "j",
        "corner",
        "click: add or delete a corner    drag from a wedge to its corner: switch it",
        "corner",
        "corner",
        brush="snap",
    ),
    "patch": Known(
        "P", "patch", "click in a loop: it becomes a patch    .: or none", target="patch"
    ),
    "symmetry": Known("M", "mirror", "work on one half, and get both"),
    "knot": Known(
        "k", "knot", "click a tangle: it becomes one corner", target="none", brush="snap"
    ),
    "flow": Known("w", "flow", "draw where edges are to flow    click: clear", "within", "patch"),
    "subdivide": Known(
        "t", "count", "wheel over a curve: edges; with Shift: of its strip", "count", "chain"
    ),
    "choose": Known(
        "y",
        "fill",
        "click a patch: its next fill    n b: next, before",
        target="patch",
        fixed=(("by", 1),),
    ),
    "insertloop": Known(
        "4", "add loop", "click an edge: a loop is added along its strip of quads", target="none"
    ),
    "movepair": Known("5", "move pair", "drag irregular vertices within a patch", target="patch"),
    "brush": Known("6", "brush", "drag the vertices of quads", target="none", brush="brush"),
    "relax": Known("7", "relax", "click: vertices are evened out", target="none", brush="brush"),
}

#: Tools that are no modes: keys change sizes, and in the mode of counts choose all anew.
NO_MODES = ("sizes", "recount")

#: Arguments that gestures or keys set, and which are no options.
SET = ("points", "at", "to", "wedge", "open", "choice", "clear", "by", "count", "free", "number")

#: Arguments that a brush is given as, the width being all of it.
BRUSHES = ("width", "radius")

#: The argument that says within which radius a tool finds what is near.
SNAP = "snap"


def modes(tools: Mapping[str, Tool] = TOOLS) -> tuple[Mode, ...]:
    """The modes of a table of tools, in its order."""
    made = [mode_of(tool) for name, tool in tools.items() if name not in NO_MODES]
    return tuple(mode for mode in made if mode is not None)


def mode_of(tool: Tool) -> Mode | None:
    """The mode of a tool; None if no gesture gives what it must have."""
    known = KNOWN.get(tool.name, Known(""))
    found = gesture_of(tool)
    if found is None:
        return None
    gesture, places = found
    gesture = known.gesture or gesture
    if gesture == "corner":
        places = ("at", "wedge")
    elif gesture == "within":
        places = ("points", "clear")
    elif gesture == "scribble":
        places = ("points", "at")
    given_as = next((name for name in BRUSHES if name in tool.arguments), "")
    brush = known.brush or ("brush" if given_as else "")
    usual: Target = "ends" if gesture == "stroke" else "chain" if gesture == "click" else "none"
    return Mode(
        tool.name,
        known.title or tool.name.replace("_", " "),
        known.key,
        gesture,
        places,
        known.target or usual,
        known.hint or tool.help,
        "edge" if gesture == "count" else brush,
        given_as,
        SNAP in tool.arguments,
        known.fixed,
        tuple(options(tool)),
    )


def gesture_of(tool: Tool) -> tuple[Gesture, tuple[str, ...]] | None:
    """What the mouse can give a tool, from what it must have, and the names of what takes it."""
    known = KNOWN.get(tool.name)
    needed = {n: a.kind for n, a in tool.arguments.items() if a.default is REQUIRED}
    if known is not None and known.gesture is not None:
        return known.gesture, tuple(needed)
    kinds = [type(kind) for kind in needed.values()]
    if not kinds:
        return "act", ()
    if kinds == [Line]:
        return "stroke", tuple(needed)
    if kinds == [Vector]:
        return "click", tuple(needed)
    if kinds == [Vector, Vector]:
        return "drag", tuple(needed)
    return None


def options(tool: Tool) -> list[Option]:
    """What a tool may be told beside what gestures give: words, flags, and whole numbers."""
    found: list[Option] = []
    for name, argument in tool.arguments.items():
        default = argument.default
        if name in SET or default is REQUIRED:
            continue
        kind = argument.kind
        if isinstance(kind, Flag):
            found.append(Option(name, (default, *(v for v in (True, False) if v is not default))))
        elif isinstance(kind, Word):
            found.append(Option(name, (default, *(v for v in kind.words if v != default))))
        elif isinstance(kind, Number) and kind.whole and isinstance(default, int):
            numbers = range(int(kind.low), int(min(kind.high, kind.low + 62)) + 1)
            found.append(Option(name, (default, *(n for n in numbers if n != default)), True))
    return found
