"""Keys of a viewer: names, what they do to its state, and what the window has to do then."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Generic, Protocol, TypeVar

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


class Effect(Enum):
    """What the window has to do after a key."""

    NOTHING = "nothing"
    REDRAW = "redraw"
    PICTURE = "picture"
    OBJ = "OBJ"
    QUIT = "quit"


class Spoken(Protocol):
    """A state that tells the user something."""

    @property
    def message(self) -> str: ...

    @message.setter
    def message(self, text: str) -> None: ...


State = TypeVar("State", bound=Spoken)


@dataclass(frozen=True, slots=True)
class KeyMap(Generic[State]):
    """The keys of a viewer.

    aliases: other names of keys: X's, and capitals. actions: what keys do to the state.
    effects: keys that ask something of the window alone. leave: what Escape does: it leaves a
    mode or the help and returns True, or False if there is nothing to leave, and quits; None
    where Escape is a key like others.
    """

    aliases: Mapping[str, str]
    actions: Mapping[str, Callable[[State], object]]
    effects: Mapping[str, Effect]
    leave: Callable[[State], bool] | None = None

    def press(self, state: State, key: str) -> Effect:
        """Obey a key, by its X name or as it is written ("bracketleft" or "[").

        Returns what the window has to do; unknown keys do nothing.
        """
        key = self.aliases.get(key, key)
        if key == "Escape" and self.leave is not None:
            return Effect.REDRAW if self.leave(state) else Effect.QUIT
        if key in self.effects:
            return self.effects[key]
        action = self.actions.get(key)
        if action is None:
            return Effect.NOTHING
        state.message = ""
        action(state)
        return Effect.REDRAW

    def check(self, text: str) -> list[str]:
        """The keys named in a text, with spaces between; ValueError if there is no such key."""
        pressed = text.split()
        for key in pressed:
            name = self.aliases.get(key, key)
            escape = name == "Escape" and self.leave is not None
            if name not in self.actions and name not in self.effects and not escape:
                raise ValueError(f"there is no key {key!r}; the key h lists them")
        return pressed

    def writes(self, character: str) -> bool:
        """Is this what a key writes, rather than nothing or a control character?

        "<" and the like have names of their own on every keyboard layout.
        """
        return character in self.aliases or character in self.actions or character in self.effects
