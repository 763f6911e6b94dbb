"""Modes: what the mouse does, a tool of the editor each.

Modes come from the table of tools (:mod:`patterndb_sketch.retopo.table`): from the arguments that
a tool must have follows what the mouse gives it, and what else a tool may be told are options of
its mode. Its key, and how it is best used, is in its entry's ``control``; a tool that says
nothing there gets a mode all the same, without a key of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from patterndb_sketch.retopo.arguments import (
    REQUIRED,
    Flag,
    Kind,
    Number,
    PointList,
    Vector,
    Word,
    WordOrNumber,
)
from patterndb_sketch.retopo.table import TOOLS
from patterndb_sketch.retopo.tool import SNAP, Gesture, Target, Tool

#: Values of an option, in the order in which it goes through them.
Values = tuple[object, ...]


@dataclass(frozen=True, slots=True)
class ToolOption:
    """name: of the tool's argument. values: that it goes through; the first is the default.
    number: are they numbers, which are less or more? typed: reads a value that is typed instead;
    None where it is one of the values. help: what it means."""

    name: str
    values: Values
    number: bool = False
    typed: Kind | None = None
    help: str = ""

    def read(self, text: str) -> object:
        """Read what was typed, "" for the default; InvalidRetopoError for what it may not be."""
        assert self.typed is not None
        words = text.replace(",", " ").split()
        if not words:
            return self.values[0]
        given: list[object] = []
        for word in words:
            try:
                given.append(float(word))
            except ValueError:
                given.append(word)
        found = given if isinstance(self.typed, Vector) or len(given) > 1 else given[0]
        self.typed.read(self.name, found)
        return found

    def spell(self, value: object) -> str:
        """Spell a value as it is typed; "" for the default."""
        if value == self.values[0]:
            return ""
        numbers = value if isinstance(value, list) else [value]
        return " ".join(f"{number:g}" for number in numbers)


@dataclass(frozen=True, slots=True)
class ToolMode:
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
    options: tuple[ToolOption, ...]


#: Arguments that a brush is given as, the width being all of it.
BRUSHES = ("width", "radius")


def list_modes(tools: Mapping[str, Tool] = TOOLS) -> tuple[ToolMode, ...]:
    """List the modes of a table of tools, in its order."""
    made = [make_mode(tool) for tool in tools.values() if tool.control.mode]
    return tuple(mode for mode in made if mode is not None)


def make_mode(tool: Tool) -> ToolMode | None:
    """Make the mode of a tool; None if no gesture gives what it must have."""
    control = tool.control
    found = find_gesture(tool)
    if found is None:
        return None
    gesture, places = found
    gesture = control.gesture or gesture
    if gesture == "corner":
        places = ("at", "wedge")
    elif gesture == "within":
        places = ("points", "clear")
    elif gesture == "scribble":
        places = ("points", "at")
    given_as = next((name for name in BRUSHES if name in tool.arguments), "")
    brush = control.brush or ("brush" if given_as else "")
    usual: Target = "ends" if gesture == "stroke" else "chain" if gesture == "click" else "none"
    return ToolMode(
        tool.name,
        control.title or tool.name.replace("_", " "),
        control.key,
        gesture,
        places,
        control.target or usual,
        control.hint or tool.help,
        "edge" if gesture == "count" else brush,
        given_as,
        SNAP in tool.arguments,
        control.fixed,
        tuple(option for option in list_options(tool) if option.name not in places),
    )


def find_gesture(tool: Tool) -> tuple[Gesture, tuple[str, ...]] | None:
    """Find what the mouse can give a tool, from what it must have, and the names of what takes
    it."""
    control = tool.control
    needed = {n: a.kind for n, a in tool.arguments.items() if a.default is REQUIRED}
    if control.gesture is not None:
        return control.gesture, tuple(needed)
    kinds = [type(kind) for kind in needed.values()]
    if not kinds:
        return "act", ()
    if kinds == [PointList]:
        return "stroke", tuple(needed)
    if kinds == [Vector]:
        return "click", tuple(needed)
    if kinds == [Vector, Vector]:
        return "drag", tuple(needed)
    return None


def list_options(tool: Tool) -> list[ToolOption]:
    """List what a tool may be told beside what gestures give: words, flags, numbers and vectors."""
    found: list[ToolOption] = []
    for name, argument in tool.arguments.items():
        default = argument.default
        said = default is REQUIRED or name in BRUSHES or name in dict(tool.control.fixed)
        if said or not argument.option:
            continue
        kind = argument.kind
        if isinstance(kind, Flag):
            found.append(
                ToolOption(
                    name,
                    (default, *(v for v in (True, False) if v is not default)),
                    help=argument.help,
                )
            )
        elif isinstance(kind, Word | WordOrNumber):
            found.append(
                ToolOption(
                    name, (default, *(v for v in kind.words if v != default)), help=argument.help
                )
            )
        elif isinstance(kind, Number) and kind.whole and isinstance(default, int):
            numbers = range(int(kind.low), int(min(kind.high, kind.low + 62)) + 1)
            found.append(
                ToolOption(
                    name, (default, *(n for n in numbers if n != default)), True, help=argument.help
                )
            )
        elif isinstance(kind, Number | Vector):
            found.append(ToolOption(name, (default,), typed=kind, help=argument.help))
    return found
