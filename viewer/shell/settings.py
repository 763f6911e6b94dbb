"""What a user has chosen for all windows, and what a window remembers: in the user's own folder."""

from __future__ import annotations

from pathlib import Path

import platformdirs
from PySide6.QtCore import QByteArray, QSettings

#: How a drag turns what is seen.
TURNTABLE, TRACKBALL = "turntable", "trackball"

#: Colours of the windows: those of the system, light or dark.
THEMES = ("system", "light", "dark")

#: Files that "Open recent" offers at most.
RECENT = 10


class ShellSettings:
    """Reads and writes the settings, which are one INI file.

    path: the file; by default ``windows.ini`` in the user's folder for settings of patterndb.
    """

    def __init__(self, path: Path | None = None) -> None:
        if path is None:
            folder = platformdirs.user_config_path("patterndb", appauthor=False)
            path = folder / "windows.ini"
        self._kept = QSettings(str(path), QSettings.Format.IniFormat)

    @property
    def theme(self) -> str:
        """One of THEMES."""
        return self._word("theme", THEMES)

    @theme.setter
    def theme(self, theme: str) -> None:
        self._kept.setValue("theme", theme)

    @property
    def turning(self) -> str:
        """TURNTABLE, where what is upright stays so, or TRACKBALL."""
        return self._word("turning", (TURNTABLE, TRACKBALL))

    @turning.setter
    def turning(self, turning: str) -> None:
        self._kept.setValue("turning", turning)

    def _word(self, name: str, words: tuple[str, ...]) -> str:
        found = str(self._kept.value(name, words[0]))
        # The file may have been edited by hand.
        return found if found in words else words[0]

    def shortcuts(self, window: str) -> dict[str, str]:
        """The keys that were chosen for commands of a window, by the commands' names."""
        self._kept.beginGroup(f"keys/{window}")
        found = {name: str(self._kept.value(name)) for name in self._kept.childKeys()}
        self._kept.endGroup()
        return found

    def choose_shortcut(self, window: str, command: str, keys: str | None) -> None:
        """Keep the key of a command, "" for none; None goes back to its own."""
        name = f"keys/{window}/{command}"
        if keys is None:
            self._kept.remove(name)
        else:
            self._kept.setValue(name, keys)

    def recent_files(self, window: str) -> list[Path]:
        """The files that were opened or saved last, those first that are newest."""
        found = self._kept.value(f"recent/{window}", [])
        # One file alone is read back as a text.
        names = [found] if isinstance(found, str) else found or []
        return [Path(name) for name in names if Path(name).exists()]  # type: ignore[union-attr]

    def add_recent_file(self, window: str, path: Path) -> None:
        """Note that a file was opened or saved."""
        path = path.absolute()
        others = [one for one in self.recent_files(window) if one != path]
        self._kept.setValue(f"recent/{window}", [str(p) for p in [path, *others][:RECENT]])

    def layout(self, window: str) -> tuple[QByteArray, QByteArray]:
        """The geometry of a window and the state of its docks, empty if not known."""
        found = [self._kept.value(f"layout/{window}/{name}") for name in ("geometry", "state")]
        one, two = (kept if isinstance(kept, QByteArray) else QByteArray() for kept in found)
        return one, two

    def keep_layout(self, window: str, geometry: QByteArray, state: QByteArray) -> None:
        """Keep the geometry of a window and the state of its docks."""
        self._kept.setValue(f"layout/{window}/geometry", geometry)
        self._kept.setValue(f"layout/{window}/state", state)

    def flush(self) -> None:
        """Write what was changed."""
        self._kept.sync()
