"""The main window of all viewers: menus, docks, messages, files, and how it is closed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QFocusEvent,
    QKeyEvent,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QFileDialog,
    QFrame,
    QLabel,
    QLineEdit,
    QMainWindow,
    QMessageBox,
    QPlainTextEdit,
    QScrollArea,
    QTextEdit,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from patterndb.errors import PatternDBError
from viewer.commands import Command
from viewer.facts import FactSheet
from viewer.keymap import Effect
from viewer.picture import WINDOW
from viewer.saver import Saver, SaveWay
from viewer.shell.actions import ActionTable
from viewer.shell.application import is_dark, use_theme
from viewer.shell.docks import DOCK_WIDTH, TOOL_BUTTONS, Dock, FactsDock
from viewer.shell.palette import CommandPalette
from viewer.shell.preferences import PreferencesDialog
from viewer.shell.scene import SceneView
from viewer.shell.settings import TURNTABLE, ShellSettings

#: Milliseconds between two looks at what has been made in the background.
PATIENCE = 40

#: Makes what a window shows of a file.
Opener = Callable[[Path], Saver]

#: How what to begin with is written over a picture, whose ground is light in dark windows too.
BEGINNING = (
    "color: #1f2733; background: rgba(255, 255, 255, 215); border-radius: 6px; padding: 10px 16px"
)

#: Part of a picture's width that it takes at most, and of its height that is above it.
WIDEST, ABOVE = 0.8, 0.12


class NotedPicture(QWidget):
    """A picture with a note over its lower edge, and what to begin with near its upper one.

    Both come and go while the pointer draws: the picture must not be moved by that.
    """

    def __init__(self, picture: QWidget, note: QLabel, beginning: QLabel) -> None:
        super().__init__()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(picture)
        self._note, self._beginning = note, beginning
        for label in (note, beginning):
            label.setParent(self)
            label.setWordWrap(True)
        note.setAutoFillBackground(True)
        beginning.setStyleSheet(BEGINNING)
        beginning.setAlignment(Qt.AlignmentFlag.AlignCenter)
        # Files are dropped on the window, and clicks are for the picture.
        beginning.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def place_notes(self) -> None:
        """Put the notes where they belong, as high as their texts."""
        note, beginning = self._note, self._beginning
        height = max(note.heightForWidth(self.width()), note.minimumSizeHint().height())
        note.setGeometry(0, self.height() - height, self.width(), height)
        width = min(round(WIDEST * self.width()), 30 + max(
            beginning.fontMetrics().horizontalAdvance(line) + 32
            for line in beginning.text().split("\n")
        ))  # fmt: skip
        beginning.setGeometry(
            (self.width() - width) // 2, round(ABOVE * self.height()),
            width, beginning.heightForWidth(width),
        )  # fmt: skip
        for label in (beginning, note):
            label.raise_()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the notes where they are."""
        super().resizeEvent(event)
        self.place_notes()


def list_takers(panel: QWidget) -> list[QWidget]:
    """List what of a panel takes the focus of the keyboard."""
    # Not by walking along the chain of focus: with that, menus were deleted in random use.
    return [
        one
        for one in panel.findChildren(QWidget)
        if one.focusPolicy() & Qt.FocusPolicy.TabFocus
        and one.focusProxy() is None
        and one.isEnabled()
        and one.isVisibleTo(panel)
    ]


#: What number fields take: all other characters are keys of commands there, too.
NUMERALS = frozenset("0123456789.,+- ")


def takes_text(widget: QWidget, text: str) -> bool:
    """Does a widget that has the focus take a character as text, so that it is no command's key?"""
    if isinstance(widget, QAbstractSpinBox) or isinstance(widget.parent(), QAbstractSpinBox):
        return text in NUMERALS
    return isinstance(widget, QLineEdit | QTextEdit | QPlainTextEdit) or text == " "


class KeyHandler(QObject):
    """Has keys mean commands whatever widget of a window has the focus.

    Combo boxes, lists and number fields take letters for themselves, and keep the focus after they
    were used. Here letters are left to commands where no text is written; and a combo box, slider
    or button that was used with the mouse gives the focus back to the picture, so that arrows,
    Escape and Delete are for it again.
    """

    def __init__(self, window: QMainWindow, picture: QWidget) -> None:
        super().__init__(window)
        self._window, self._picture = window, picture
        self._widget: QWidget | None = None
        self._by_mouse = False
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        app.focusChanged.connect(self._watch)

    def _watch(self, before: QWidget | None, now: QWidget | None) -> None:
        """Watch the widget that has the focus, and no other."""
        if self._widget is not None:
            with suppress(RuntimeError):  # one that is gone
                self._widget.removeEventFilter(self)
            self._widget = None
        if now is None or now is self._picture or now.window() is not self._window:
            return
        self._by_mouse = False
        self._widget = now
        now.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """See what the widget is used with."""
        kind = event.type()
        if kind is QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            keys = Qt.KeyboardModifier
            plain = not event.modifiers() & (
                keys.ControlModifier | keys.AltModifier | keys.MetaModifier
            )
            text = event.text()
            if plain and text.isprintable() and text and isinstance(watched, QWidget):
                # Not handed on, the key is looked for among those of commands.
                event.ignore()
                return not takes_text(watched, text)
        elif kind is QEvent.Type.KeyPress:
            self._by_mouse = False
        elif kind is QEvent.Type.MouseButtonPress:
            self._by_mouse = True
        elif kind is QEvent.Type.MouseButtonRelease:
            if isinstance(watched, QAbstractSlider | QAbstractButton):
                self._give_back()
        elif kind is QEvent.Type.FocusIn and isinstance(event, QFocusEvent):
            popup = event.reason() is Qt.FocusReason.PopupFocusReason
            if popup and self._by_mouse and isinstance(watched, QComboBox):
                self._give_back()
        return False

    def _give_back(self) -> None:
        # Once the widget has done what it does.
        QTimer.singleShot(0, self._picture.setFocus)


class ShellWindow(QMainWindow):
    """Shows what a saver draws, and has its commands in menus.

    title: of the window. opener: makes another saver of a file that is opened or dropped; None
    where no file can be. A viewer with docks of its own says so in a class of its own.
    """

    def __init__(
        self,
        saver: Saver,
        title: str,
        settings: ShellSettings,
        opener: Opener | None = None,
    ) -> None:
        super().__init__()
        self.saver, self.settings = saver, settings
        self.state: Any = saver.state
        self._title, self._opener = title, opener
        self._quitting = self._refreshing = False
        self._told: str | None = None
        self._failed = ""
        self.picture = self.make_picture()
        self.hint_label, self.message_label, self.first_label = QLabel(), QLabel(), QLabel()
        self._middle = self._make_middle()
        self.setCentralWidget(self._middle)
        self.table = ActionTable(self, self.picture, saver.kind, settings, self.run_command)
        self.table.add_commands(saver.commands)
        self.table.add_commands(self._list_window_commands())
        self.table.make_menus()
        self._keys = KeyHandler(self, self.picture.focusProxy() or self.picture)
        self.facts = FactsDock(self)
        self.docks: list[Dock] = [self.facts, *self.make_docks()]
        self.arrange_docks()
        self.tool_bar = self._make_tool_bar()
        self._finish_menus()
        self.setAcceptDrops(True)
        self.statusBar().addWidget(self.hint_label, 1)
        self._restore_layout()
        self._heed_settings()
        self._clock = QTimer(self)
        self._clock.timeout.connect(self._poll)
        self._clock.start(PATIENCE)
        self.refresh()

    # What a viewer has of its own

    def make_picture(self) -> Any:
        """Make the widget in the middle: a SceneView, or one with its ``room``, ``set_ground``,
        ``ask_picture`` and ``show_picture``."""
        view = SceneView(self, self.state)
        view.changed.connect(self.show_change)
        view.asked.connect(self.refresh)
        return view

    def make_docks(self) -> list[Dock]:
        """Make the docks beside the facts."""
        return []

    def arrange_docks(self) -> None:
        """Put the docks where they are at first."""
        for dock in self.docks:
            self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
        # Two under each other; the others behind the first, lest all be low.
        for dock in self.docks[2:]:
            self.tabifyDockWidget(self.facts, dock)
        self.facts.raise_()
        self.resizeDocks(self.docks, [DOCK_WIDTH] * len(self.docks), Qt.Orientation.Horizontal)

    def refresh_docks(self) -> None:
        """Have the docks show the state as it is now."""

    # What is shown

    def change(self, do: Callable[[], object]) -> None:
        """Do what a widget of a dock asks for; nothing while docks show what there is."""
        if not self._refreshing:
            self.state.message = ""
            do()
            self.show_change()

    def show_change(self) -> None:
        """Something has changed: show it with the next picture; what can be done now is known
        at once, as the next key may come before that."""
        self.table.refresh(self.state)
        self.picture.ask_picture()

    def refresh(self) -> None:
        """Show the state as it is now, in the picture and beside it."""
        self.draw_picture()
        sheet = FactSheet()
        self.saver.describe(sheet)
        self.facts.show_facts(sheet)
        self._refreshing = True
        try:
            self.refresh_docks()
        finally:
            self._refreshing = False
        self.table.refresh(self.state)
        self._tell()
        unsaved = bool(self.saver.would_lose())
        self.setWindowTitle(f"{self._title}[*]")
        self.setWindowModified(unsaved)

    def draw_picture(self) -> None:
        """Draw the picture."""
        self.picture.show_picture(self.saver.draw_live(*self.picture.room))

    def _tell(self) -> None:
        hint, message = self.saver.hint(), self._failed or self.state.message
        self.hint_label.setText(hint)
        self.hint_label.setToolTip(hint)
        self.message_label.setText(message)
        self.message_label.setVisible(bool(message))
        first = self.saver.first_hint()
        if first and self._opener is not None:
            first += f"\nOr drop {self.saver.opens} here, or press Ctrl+O."
        self.first_label.setText(first)
        self.first_label.setVisible(bool(first))
        self._middle.place_notes()

    def tell_error(self, error: BaseException) -> None:
        """Tell of an error that is none of the user's; the window goes on."""
        self._failed = (
            f"an error in the program: {type(error).__name__}: {error}. "
            "The terminal has more of it; save your work"
        )
        self._tell()

    def _poll(self) -> None:
        said = self.state.message
        self.saver.keep()
        if self.state.poll() or self.state.message != said:
            self.show_change()

    # Commands

    def run_command(self, command: Command[Any]) -> None:
        """Obey a command, and show what came of it."""
        self._failed = ""
        self.saver.known.refused = None
        refused = self.saver.refuse(command)
        state = self.state
        state.message = refused
        if not refused:
            try:
                command.run(state)
            except (PatternDBError, OSError) as error:
                state.message = str(error)
        self.show_change()
        if self.saver.known.refused is not None:
            self._settle_refused(lambda: self.run_command(command))

    def _settle_refused(
        self, again: Callable[[], object], save_as: Callable[[], object] | None = None
    ) -> None:
        """Ask what to do about a file that somebody else has changed since it was opened or saved
        here, and do it. again: saves once more. save_as: saves to another file, by default the
        refused save after it was moved there."""
        saver = self.saver
        refused, saver.known.refused = saver.known.refused, None
        if refused is None:
            return
        reload = saver.reload(refused.path)
        box = QMessageBox(self)
        box.setIcon(QMessageBox.Icon.Warning)
        box.setWindowTitle(self._title)
        box.setText(f"{refused.path.name} has changed since it was opened or saved here.")
        box.setInformativeText(
            f"Another window or program wrote {refused.path}. Nothing was saved."
        )
        roles = QMessageBox.ButtonRole
        buttons: dict[object, Callable[[], object]] = {}

        def add(
            title: str, tip: str, role: QMessageBox.ButtonRole, do: Callable[[], object]
        ) -> None:
            button = box.addButton(title, role)
            button.setToolTip(tip)
            buttons[button] = do

        def overwrite() -> None:
            saver.known.note(refused.path)
            again()

        def move() -> None:
            name, _ = QFileDialog.getSaveFileName(
                self, "Save as", str(refused.path), f"*{refused.path.suffix}"
            )
            if name and refused.move is not None:
                path = Path(name)
                path = path if path.suffix else path.with_suffix(refused.path.suffix)
                saver.known.forget(path)
                refused.move(path)
                again()

        if reload is not None:
            add("&Reload", "Show what the file holds; what was done here is lost",
                roles.DestructiveRole, reload)  # fmt: skip
        if save_as is not None or refused.move is not None:
            add("Save &as…", "Save to another file", roles.AcceptRole, save_as or move)
        add("&Overwrite", "Replace what the other wrote", roles.DestructiveRole, overwrite)
        cancel = box.addButton(QMessageBox.StandardButton.Cancel)
        box.setDefaultButton(cancel)
        box.exec()
        do = buttons.get(box.clickedButton())
        if do is None:
            return
        try:
            do()
        except (PatternDBError, OSError) as error:
            self.state.message = str(error)
        self.show_change()

    def _list_window_commands(self) -> list[Command[Any]]:
        """What every window can do, whatever it shows."""
        key = {effect: key for key, effect in self.saver.keys.effects.items()}.get
        picture, own = key(Effect.PICTURE), key(Effect.OBJ)
        found: list[Command[Any]] = []
        if self._opener is not None:
            found.append(Command("open", "Open…", "File", ("Ctrl+O",),
                                 lambda _: self.open_file_dialog(), "Open a file"))  # fmt: skip
        taken = any("Ctrl+S" in one.keys for one in self.saver.commands)
        for number, way in enumerate(self.saver.save_ways()):
            save, save_as = (partial(self._save_number, number, ask=ask) for ask in (False, True))
            if number == 0:
                keys = () if taken else ("Ctrl+S",) if own is None else (own, "Ctrl+S")
                found.append(Command(way.name, way.title, "File", keys, lambda _, do=save: do()))
                found.append(Command(f"{way.name}-as", f"{way.title} as…", "File",
                                     ("Ctrl+Shift+S",), lambda _, do=save_as: do()))  # fmt: skip
            else:
                title = f"{way.title}…"
                found.append(Command(way.name, title, "File", (), lambda _, do=save_as: do()))
        return [
            *found,
            Command("save-picture", "Save picture…", "File", () if picture is None else (picture,),
                    lambda _: self.save_picture_dialog(), "Write the picture to a PNG"),
            Command("close", "Close", "File", (key(Effect.QUIT, "q"), "Ctrl+Q"),
                    lambda _: self.close()),
            Command("preferences", "Preferences…", "Edit", ("Ctrl+,",),
                    lambda _: self.open_preferences(),
                    "Choose colours, how a drag turns, and every command's key"),
            Command("next-panel", "Next panel", "View", ("F6",), lambda _: self.walk_panels(1),
                    "Go on with the keyboard in the next panel; after the last in the picture"),
            Command("previous-panel", "Previous panel", "View", ("Shift+F6",),
                    lambda _: self.walk_panels(-1),
                    "Go on with the keyboard in the panel before, or in the picture"),
            Command("find-command", "Find a command…", "Help", ("Ctrl+P",),
                    lambda _: self.open_palette(), "Find a command by a few letters of its name"),
            Command("list-keys", "Commands and keys", "Help", ("h", "F1", "?"),
                    lambda _: self.open_palette(), "List all commands with their keys"),
        ]  # fmt: skip

    def open_palette(self) -> None:
        """Show all commands, and find one by its letters."""
        CommandPalette(self, self.table).open()

    def open_preferences(self) -> None:
        """Choose colours, how a drag turns, and keys."""
        dialog = PreferencesDialog(self, self.settings, self.table)
        dialog.finished.connect(lambda _: self._heed_settings())
        dialog.open()

    def walk_panels(self, step: int) -> None:
        """Give the focus of the keyboard to the next panel that is shown, or to the picture."""
        picture = self.picture.focusProxy() or self.picture
        found: list[tuple[QWidget, list[QWidget]]] = [(self._middle, [picture])]
        for panel in self.docks:
            # One that lies behind another is shown, too.
            takers = [] if panel.isHidden() else list_takers(panel)
            found += [(panel, takers)] if takers else []
        focus = QApplication.focusWidget()
        at = [
            k for k, (one, _) in enumerate(found) if focus is not None and one.isAncestorOf(focus)
        ]
        panel, takers = found[((at or [0])[0] + step) % len(found)]
        panel.raise_()
        # A control rather than the area that it is scrolled in.
        taker = next((one for one in takers if not isinstance(one, QScrollArea)), takers[0])
        taker.setFocus(Qt.FocusReason.TabFocusReason)

    # Files

    def open_file_dialog(self) -> None:
        """Ask for a file, and open it."""
        name, _ = QFileDialog.getOpenFileName(self, "Open", str(Path.cwd()))
        if name:
            self.open_file(Path(name))

    def open_file(self, path: Path) -> bool:
        """Show a file instead of what is shown; False if it cannot be, or was not wished."""
        if self._opener is None or not self.may_lose_work():
            return False
        try:
            found = self._opener(path)
        except (PatternDBError, OSError, ValueError) as error:
            self.state.message = str(error)
            self.show_change()
            return False
        self.adopt_saver(found, path.name)
        self.settings.add_recent_file(found.kind, path)
        self._fill_recent()
        return True

    def adopt_saver(self, saver: Saver, title: str) -> None:
        """Show another state from now on."""
        before, self.saver, self.state = self.saver, saver, saver.state
        self._title = title
        self.picture.state = saver.state
        self._heed_settings()
        self.refresh()
        before.dismiss()

    def _save_number(self, number: int, *, ask: bool = False) -> bool:
        return self.save_by(self.saver.save_ways()[number], ask=ask)

    def save_by(self, way: SaveWay, *, ask: bool = False) -> bool:
        """Save something where it is known to go, or where the user says; False if it was not.

        ask: in any case.
        """
        path = None if ask else way.known()
        if path is None:
            suggested = way.suggest()
            name, _ = QFileDialog.getSaveFileName(self, way.title, str(suggested), f"*{way.suffix}")
            if not name:
                return False
            path = Path(name)
            if not path.suffix:
                path = path.with_suffix(way.suffix)
            # Whoever chose it has agreed to replace it.
            self.saver.known.forget(path)
        return self._save_to(way, path)

    def _save_to(self, way: SaveWay, path: Path) -> bool:
        """Save something to a file; False if it was not."""
        state = self.state
        try:
            state.message = way.write(path)
        except (PatternDBError, OSError) as error:
            state.message = f"not saved: {error}"
        if self.saver.known.refused is not None or state.message.startswith("not saved:"):
            self.show_change()
            saved: list[bool] = []
            self._settle_refused(
                lambda: saved.append(self._save_to(way, path)),
                lambda: saved.append(self.save_by(way, ask=True)),
            )
            return saved == [True]
        if path.exists():
            self.settings.add_recent_file(self.saver.kind, path)
            self._fill_recent()
        self.show_change()
        return True

    def save_picture_dialog(self) -> None:
        """Ask where, and write the picture to a PNG."""
        suggested = self.saver.picture_path()
        name, _ = QFileDialog.getSaveFileName(self, "Save picture", str(suggested), "*.png")
        if not name:
            return
        path = Path(name).with_suffix(".png")
        try:
            self.state.message = self.saver.save_picture(path)
        except OSError as error:
            self.state.message = f"not saved: {error}"
        self.show_change()

    def _fill_recent(self) -> None:
        self._recent.clear()
        for path in self.settings.recent_files(self.saver.kind):
            action = self._recent.addAction(path.name, partial(self.open_file, path))
            action.setToolTip(str(path))
        self._recent.setEnabled(self._opener is not None and not self._recent.isEmpty())

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """A file may be dropped where one can be opened."""
        if self._opener is not None and event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first file that is dropped."""
        paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
        if paths:
            event.acceptProposedAction()
            # The program that it comes from waits until this returns.
            QTimer.singleShot(0, partial(self.open_file, paths[0]))

    # Closing

    def may_lose_work(self) -> bool:
        """Ask what to do with work that is not saved: True if it is saved, or may be lost."""
        lost = self.saver.would_lose()
        if not lost:
            return True
        kinds = QMessageBox.StandardButton
        ways = self.saver.save_ways()
        buttons = kinds.Discard | kinds.Cancel | (kinds.Save if ways else kinds.NoButton)
        answer = QMessageBox.question(self, self._title, lost, buttons, kinds.Cancel)
        if answer == kinds.Save:
            # A disk may be full: then the work is still there, and nothing is closed.
            return self.save_by(ways[0]) and not self.saver.would_lose()
        return answer == kinds.Discard

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about work that is not saved, and remember the layout."""
        if not self._quitting and not self.may_lose_work():
            event.ignore()
            return
        self._clock.stop()
        self.settings.keep_layout(self.saver.kind, self.saveGeometry(), self.saveState())
        self.settings.flush()
        self.picture.close()
        event.accept()

    def quit_now(self) -> None:
        """Close without asking, as after Ctrl-C: what can be recovered is kept by its owner."""
        self._quitting = True
        self.close()

    # What a user has chosen

    def offer_lost_work(self) -> None:
        """Offer what a crash left, if there is something."""
        lost = self.saver.find_lost_work()
        if lost is None:
            return
        box = QMessageBox(self)
        box.setWindowTitle(self._title)
        box.setText(lost.what)
        yes = box.addButton("Open it", QMessageBox.ButtonRole.AcceptRole)
        no = box.addButton("Delete it", QMessageBox.ButtonRole.DestructiveRole)
        box.addButton("Decide later", QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(yes)
        box.exec()
        if box.clickedButton() is yes:
            lost.open()
        elif box.clickedButton() is no:
            lost.discard()
        self.show_change()

    def _heed_settings(self) -> None:
        app = QApplication.instance()
        if isinstance(app, QApplication):
            use_theme(app, self.settings.theme)
            self._heed_colours()
        camera = getattr(self.state, "camera", None)
        if camera is not None:
            camera.turntable = self.settings.turning == TURNTABLE

    def _heed_colours(self) -> None:
        app = QApplication.instance()
        if isinstance(app, QApplication):
            self.picture.set_ground(dark=is_dark(app))
            self.show_change()

    def changeEvent(self, event: QEvent) -> None:
        """The system may go dark while the window is open."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "table"):
            self._heed_colours()

    def _restore_layout(self) -> None:
        geometry, state = self.settings.layout(self.saver.kind)
        if geometry.isEmpty():
            self.resize(QSize(*WINDOW).boundedTo(self.screen().availableSize() * 0.94))
        else:
            self.restoreGeometry(geometry)
            self.restoreState(state)

    # How it is put together

    def _make_middle(self) -> NotedPicture:
        # A long line is cut rather than the window made wider; the tooltip has all of it.
        self.hint_label.setMinimumWidth(1)
        self.message_label.setMargin(6)
        self.message_label.setFrameShape(QFrame.Shape.StyledPanel)
        self.message_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        bold = self.message_label.font()
        bold.setBold(True)
        self.message_label.setFont(bold)
        return NotedPicture(self.picture, self.message_label, self.first_label)

    def _make_tool_bar(self) -> QToolBar:
        bar = QToolBar("Tool bar", self)
        bar.setObjectName("tools")
        bar.setStyleSheet(TOOL_BUTTONS)
        bar.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        for one in self.table.bound.values():
            if one.command.bar:
                bar.addAction(one.action)
        self.addToolBar(bar)
        return bar

    def _finish_menus(self) -> None:
        """Put in what is no command: recent files, and which docks are shown."""
        file = self.table.menu("File")
        self._recent = file.addMenu("Open recent")
        self._recent.setToolTipsVisible(True)
        self._fill_recent()
        view = self.table.menu("View")
        view.addSeparator()
        for dock in self.docks:
            view.addAction(dock.toggleViewAction())
        view.addAction(self.tool_bar.toggleViewAction())
