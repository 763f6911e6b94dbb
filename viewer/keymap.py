"""Keys of a viewer: names, what they do to its state, and what the window has to do then."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Generic, Protocol, TypeVar

from viewer.commands import Command, list_actions

#: Keys by X's names for what they write.
X_NAMES = {
    "bracketleft": "[",
    "bracketright": "]",
    "comma": ",",
    "period": ".",
    "plus": "+",
    "minus": "-",
    "KP_Add": "+",
    "KP_Subtract": "-",
    "Return": "Enter",
    "KP_Enter": "Enter",
    "ISO_Left_Tab": "BackTab",
    "Page_Up": "Prior",
    "Page_Down": "Next",
}


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


class KeyMap(Generic[State]):
    """The keys of a viewer's commands, as they are pressed without a window.

    effects: keys that ask something of the window alone. Raises ValueError for a key that means
    two things.
    """

    def __init__(self, commands: Sequence[Command[State]], effects: Mapping[str, Effect]) -> None:
        self.actions = list_actions(commands, effects)
        self.effects = effects

    def press(self, state: State, key: str) -> Effect:
        """Obey a key, by its X name or as it is written ("bracketleft" or "[").

        Returns what the window has to do; unknown keys do nothing.
        """
        key = self._find(key)
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
            if self._find(key) not in {*self.actions, *self.effects}:
                raise ValueError(f"there is no key {key!r}; F1 lists them in the window")
        return pressed

    def _find(self, key: str) -> str:
        """The name of a key in commands; a capital that means nothing is a small letter."""
        key = X_NAMES.get(key, key)
        known = key in self.actions or key in self.effects
        return key if known or len(key) > 1 else key.lower()
