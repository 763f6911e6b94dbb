"""A window's commands as Qt's actions: menus, tool bar, shortcuts and palette come of one table."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QWidget

from viewer.commands import PICTURE_KEYS, Command, spell_key
from viewer.shell.settings import ShellSettings

#: Menus that come first and last; those of a table stand between.
FIRST_MENUS, LAST_MENUS = ("File", "Edit"), ("View", "Help")

#: Commands of these menus are done again while their key is held down; others are not.
NO_REPEAT_MENUS = ("File", "Help")


@dataclass(frozen=True, slots=True, eq=False)
class BoundCommand:
    """A command with its action. own: the keys that it has by itself, as Qt spells them."""

    command: Command[Any]
    action: QAction
    own: tuple[str, ...]


class ActionTable:
    """The actions of a window, by their commands' names.

    window: that they belong to. picture: the widget that single keys which other widgets need
    are for. kind: of window, in the settings. run: runs a command and shows what came of it.
    """

    def __init__(
        self,
        window: QMainWindow,
        picture: QWidget,
        kind: str,
        settings: ShellSettings,
        run: Callable[[Command[Any]], None],
    ) -> None:
        # The widget that has the focus where the picture is made of several.
        self._window, self._picture = window, picture.focusProxy() or picture
        self._kind, self._settings, self._run = kind, settings, run
        self._groups: dict[str, QActionGroup] = {}
        self._menus: dict[str, QMenu] = {}
        self.bound: dict[str, BoundCommand] = {}

    def add_commands(self, commands: Iterable[Command[Any]]) -> None:
        """Make an action of every command; ValueError for a name or a key that is taken."""
        for command in commands:
            if command.name in self.bound:
                raise ValueError(f"there are two commands {command.name!r}")
            action = QAction(command.title, self._window)
            action.setObjectName(command.name)
            action.setCheckable(command.checked is not None)
            changes = command.checked is None and command.menu not in NO_REPEAT_MENUS
            action.setAutoRepeat(changes)
            if command.group:
                group = self._groups.get(command.group)
                if group is None:
                    group = self._groups[command.group] = QActionGroup(self._window)
                group.addAction(action)
            action.triggered.connect(lambda _=False, one=command: self._run(one))
            own = tuple(spell_key(key) for key in command.keys)
            self.bound[command.name] = BoundCommand(command, action, own)
        self.spell_shortcuts()

    def make_menus(self) -> None:
        """Put the actions into the menu bar."""
        named = dict.fromkeys(one.command.menu for one in self.bound.values())
        between = [n for n in named if n not in (*FIRST_MENUS, *LAST_MENUS)]
        for name in (*FIRST_MENUS, *between, *LAST_MENUS):
            menu = self._menus[name] = self._window.menuBar().addMenu(f"&{name}")
            menu.setToolTipsVisible(True)
            for one in self.bound.values():
                if one.command.menu == name:
                    menu.addAction(one.action)

    def menu(self, name: str) -> QMenu:
        """A menu by its title."""
        return self._menus[name]

    def spell_shortcuts(self) -> None:
        """Give every action its keys: those that were chosen, or else its own."""
        chosen = self._settings.shortcuts(self._kind)
        taken = {keys for keys in chosen.values() if keys}
        for name, one in self.bound.items():
            keys = list(one.own) if name not in chosen else [chosen[name]] if chosen[name] else []
            if name not in chosen:
                # Somebody else was given them.
                keys = [key for key in keys if key not in taken]
            one.action.setShortcuts([QKeySequence(key) for key in keys])
            alone = any(key in PICTURE_KEYS for key in one.command.keys) and name not in chosen
            context = Qt.ShortcutContext
            one.action.setShortcutContext(
                context.WidgetShortcut if alone else context.WindowShortcut
            )
            if alone:
                self._picture.addAction(one.action)
            else:
                # Those that are in no menu just now have their keys, too.
                self._window.addAction(one.action)
            one.action.setToolTip(describe_action(one))

    def choose_shortcut(self, name: str, keys: str | None) -> str | None:
        """Give a command another key, "" for none, None for its own again.

        Returns the name of the command that has the key already, and changes nothing then.
        """
        if keys:
            for other, one in self.bound.items():
                if other != name and keys in self.list_keys(one):
                    return other
        self._settings.choose_shortcut(self._kind, name, keys)
        self.spell_shortcuts()
        return None

    def list_keys(self, one: BoundCommand) -> list[str]:
        """The keys of a command as they are now."""
        return [keys.toString() for keys in one.action.shortcuts()]

    def refresh(self, state: Any) -> None:
        """Have every action say what is in force, and what can be done now."""
        for one in self.bound.values():
            command, action = one.command, one.action
            if command.enabled is not None:
                can = bool(command.enabled(state))
                if action.isEnabled() != can:
                    action.setEnabled(can)
            if command.checked is not None:
                on = bool(command.checked(state))
                if action.isChecked() != on:
                    action.setChecked(on)


def describe_action(one: BoundCommand) -> str:
    """Describe a command in its tooltip: what happens, and its keys."""
    keys = ", ".join(
        sequence.toString(QKeySequence.SequenceFormat.NativeText)
        for sequence in one.action.shortcuts()
    )
    tip = one.command.tip or one.command.title
    return f"{tip} ({keys})" if keys else tip
