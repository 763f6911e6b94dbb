"""Commands of a viewer: what can be done in its window, one table each.

A window makes its menus, tool bar, shortcuts, tooltips and its list of commands of such a table,
and ``--keys`` presses the same keys without one. One more command is one more entry.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

Held = TypeVar("Held")

#: Keys with a name that is not what they write, as Qt spells them.
QT_NAMES = {
    "Prior": "PgUp",
    "Next": "PgDown",
    "BackSpace": "Backspace",
    "Delete": "Del",
    "Enter": "Return",
    "BackTab": "Shift+Tab",
    "Escape": "Esc",
}

#: Keys that lists, sliders and fields need for themselves: they mean a command only where the
#: picture has the focus.
PICTURE_KEYS = frozenset(
    ("Left", "Right", "Up", "Down", "Prior", "Next", "Home", "End", "Tab", "BackTab")
) | frozenset(("Enter", "BackSpace", "Delete", "Escape"))


@dataclass(frozen=True, slots=True)
class Command(Generic[Held]):
    """Something that can be done.

    name:    that it keeps in preferences ("next-fill"). title: in menus ("Next fill").
    menu:    where it stands ("Fill"). keys: that do it, by the names of
             :mod:`viewer.keymap`, or with "Ctrl+" before what Qt calls them.
    run:     what it does to the state. tip: what happens, a sentence; the title by default.
    checked: is it in force? None for what is done once. enabled: can it be done now?
    group:   of those with one name one is in force, as of tools. bar: is it in the tool bar?
    """

    name: str
    title: str
    menu: str
    keys: tuple[str, ...]
    run: Callable[[Held], object]
    tip: str = ""
    checked: Callable[[Held], bool] | None = None
    enabled: Callable[[Held], bool] | None = None
    group: str = ""
    bar: bool = False


def list_actions(
    commands: Sequence[Command[Held]], taken: Collection[str] = ()
) -> dict[str, Callable[[Held], object]]:
    """List what keys do, by their names; ValueError for a key that two commands have.

    taken: keys that no command may have.
    """
    found: dict[str, Callable[[Held], object]] = {}
    for command in commands:
        for key in command.keys:
            if key in found or key in taken:
                raise ValueError(
                    f"{command.name}: the key {key!r} means something else in the window; taken "
                    f"are {' '.join(sorted({*taken, *(k for c in commands for k in c.keys)}))}"
                )
            found[key] = command.run
    return found


def spell_key(key: str) -> str:
    """Spell a key as Qt does: "U" is "Shift+U", "u" is "U"."""
    if len(key) == 1 and key.isalpha():
        return key.upper() if key.islower() else f"Shift+{key}"
    return QT_NAMES.get(key, key)
