"""What a user can choose for the windows: colours, how a drag turns, and every command's key."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from viewer.shell.actions import ActionTable
from viewer.shell.settings import THEMES, TRACKBALL, TURNTABLE, ShellSettings

TURNINGS = {
    TURNTABLE: "turntable: what is upright stays upright",
    TRACKBALL: "trackball: any way round",
}


class PreferencesDialog(QDialog):
    """Changes settings as soon as they are chosen; the window heeds them when it is closed.

    table: of the window whose keys are shown.
    """

    def __init__(self, parent: QWidget, settings: ShellSettings, table: ActionTable) -> None:
        super().__init__(parent)
        self.setWindowTitle("Preferences")
        # Each is used once; the window would keep them all.
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._settings, self._table = settings, table
        self.theme = QComboBox()
        self.theme.addItems(list(THEMES))
        self.theme.setCurrentText(settings.theme)
        self.theme.currentTextChanged.connect(lambda word: setattr(settings, "theme", word))
        self.turning = QComboBox()
        for word, text in TURNINGS.items():
            self.turning.addItem(text, word)
        self.turning.setCurrentIndex(list(TURNINGS).index(settings.turning))
        self.turning.currentIndexChanged.connect(self._choose_turning)
        self.keys = QTableWidget(0, 3)
        self.keys.setHorizontalHeaderLabels(["menu", "command", "keys"])
        self.keys.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.keys.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.keys.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.keys.verticalHeader().hide()
        self.keys.horizontalHeader().setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        self.keys.itemSelectionChanged.connect(self._show_key)
        self.edit = QKeySequenceEdit()
        self.edit.setMaximumSequenceLength(1)
        use, none, own = (QPushButton(text) for text in ("Use", "No key", "Its own"))
        use.clicked.connect(lambda: self.choose(self.edit.keySequence().toString()))
        none.clicked.connect(lambda: self.choose(""))
        own.clicked.connect(lambda: self.choose(None))
        self.said = QLabel("choose a command, press its new key, and Use")
        self.said.setWordWrap(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.accept)
        form = QFormLayout()
        form.addRow("Colours", self.theme)
        form.addRow("A drag turns as a", self.turning)
        row = QHBoxLayout()
        for widget in (self.edit, use, none, own):
            row.addWidget(widget)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.keys, 1)
        layout.addLayout(row)
        layout.addWidget(self.said)
        layout.addWidget(buttons)
        self.resize(640, 560)
        self._fill()

    def choose(self, keys: str | None) -> None:
        """Give the chosen command a key, "" for none, None for its own."""
        name = self._chosen()
        if name is None:
            self.said.setText("choose a command first")
            return
        if keys is not None:
            keys = QKeySequence(keys).toString()
        other = self._table.choose_shortcut(name, keys)
        if other is not None:
            title = self._table.bound[other].command.title
            self.said.setText(f"{keys} is the key of “{title}”: give that another one first")
            return
        self.said.setText("")
        row = self.keys.currentRow()
        self._fill()
        self.keys.selectRow(row)

    def _choose_turning(self, number: int) -> None:
        self._settings.turning = self.turning.itemData(number)

    def _chosen(self) -> str | None:
        item = self.keys.item(self.keys.currentRow(), 1)
        return None if item is None else str(item.data(Qt.ItemDataRole.UserRole))

    def _show_key(self) -> None:
        name = self._chosen()
        if name is not None:
            keys = self._table.bound[name].action.shortcuts()
            self.edit.setKeySequence(keys[0] if keys else QKeySequence())

    def _fill(self) -> None:
        bound = self._table.bound
        self.keys.setRowCount(len(bound))
        for row, (name, one) in enumerate(bound.items()):
            texts = one.command.menu, one.command.title, ", ".join(self._table.list_keys(one))
            for column, text in enumerate(texts):
                item = QTableWidgetItem(text)
                item.setToolTip(one.command.tip or one.command.title)
                item.setData(Qt.ItemDataRole.UserRole, name)
                self.keys.setItem(row, column, item)
        self.keys.resizeColumnToContents(0)
        self.keys.resizeColumnToContents(2)
