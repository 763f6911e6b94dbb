"""Finding a command by a few letters of its name, and the list of all keys."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QDialog,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from viewer.shell.actions import ActionTable, BoundCommand

#: Keys that walk through the list while letters are typed.
WALKING = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


def match_commands(wanted: str, commands: Sequence[BoundCommand]) -> list[BoundCommand]:
    """Match commands with all words of a text, those first whose title begins with it."""
    words = wanted.lower().split()

    def said(one: BoundCommand) -> str:
        command = one.command
        return f"{command.title} {command.menu} {command.tip}".lower()

    found = [one for one in commands if all(word in said(one) for word in words)]
    first = " ".join(words)
    return sorted(
        found,
        key=lambda one: (
            not one.command.title.lower().startswith(first),
            not all(word in one.command.title.lower() for word in words),
        ),
    )


class CommandPalette(QDialog):
    """A field for letters, and the commands that match them; Enter does the one that is chosen."""

    def __init__(self, parent: QWidget, table: ActionTable) -> None:
        super().__init__(parent)
        self.setWindowTitle("Find a command")
        # Each is used once; the window would keep them all.
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._table = table
        self.field = QLineEdit(placeholderText="what do you want to do?")
        self.list = QListWidget()
        self.list.setUniformItemSizes(True)
        layout = QVBoxLayout(self)
        layout.addWidget(self.field)
        layout.addWidget(self.list)
        self.resize(520, 420)
        self.field.installEventFilter(self)
        self.field.textChanged.connect(self._fill)
        self.field.returnPressed.connect(self._do)
        self.list.itemActivated.connect(self._do)
        self._fill("")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Walk through the list with the keys for that while the field has the focus."""
        pressed = watched is self.field and event.type() == QEvent.Type.KeyPress
        if pressed and isinstance(event, QKeyEvent) and event.key() in WALKING:
            self.list.keyPressEvent(event)
            return True
        return super().eventFilter(watched, event)

    def _fill(self, wanted: str) -> None:
        self.list.clear()
        for one in match_commands(wanted, list(self._table.bound.values())):
            keys = ", ".join(self._table.list_keys(one))
            text = f"{one.command.menu}:  {one.command.title}" + (f"    {keys}" if keys else "")
            item = QListWidgetItem(text)
            item.setToolTip(one.command.tip or one.command.title)
            item.setData(Qt.ItemDataRole.UserRole, one.command.name)
            if not one.action.isEnabled():
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEnabled)
            self.list.addItem(item)
            # The first that can be done.
            if self.list.currentRow() < 0 and one.action.isEnabled():
                self.list.setCurrentItem(item)

    def _do(self) -> None:
        item = self.list.currentItem()
        if item is None or not item.flags() & Qt.ItemFlag.ItemIsEnabled:
            return
        self.accept()
        self._table.bound[item.data(Qt.ItemDataRole.UserRole)].action.trigger()
