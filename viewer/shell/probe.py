"""Makes sure that a window can be opened here before it is asked for.

Where a library of X11 or OpenGL lacks, Qt ends the process, and names the wrong one. So a child
process tries first: the worst it can do is die, and the parent says what is missing.
"""

from __future__ import annotations

import ctypes
import functools
import os
import subprocess
import sys

from patterndb.errors import PatternDBError
from patterndb.system.extras import require_extra

#: Seconds a trial may take; a software renderer on a loaded machine needs one or two.
PATIENCE = 60.0

#: Platforms of Qt that draw nothing on a screen and need no display.
SCREENLESS = ("offscreen", "minimal", "vnc")

#: What Qt and OpenGL load on Linux, by the Debian package that brings it.
LIBRARIES = {
    "libxcb-cursor0": "libxcb-cursor.so.0",
    "libxcb-icccm4": "libxcb-icccm.so.4",
    "libxcb-keysyms1": "libxcb-keysyms.so.1",
    "libxcb-image0": "libxcb-image.so.0",
    "libxcb-render-util0": "libxcb-render-util.so.0",
    "libxcb-util1": "libxcb-util.so.1",
    "libxcb-randr0": "libxcb-randr.so.0",
    "libxcb-shape0": "libxcb-shape.so.0",
    "libxcb-xkb1": "libxcb-xkb.so.1",
    "libxkbcommon-x11-0": "libxkbcommon-x11.so.0",
    "libx11-xcb1": "libX11-xcb.so.1",
    "libegl1": "libEGL.so.1",
    "libgl1": "libGL.so.1",
    "libfontconfig1": "libfontconfig.so.1",
    "libglib2.0-0": "libglib-2.0.so.0",
}

#: Brings drivers, which are not found by a library's name.
DRIVERS = "libgl1-mesa-dri"

TRIAL = """
from PySide6.QtGui import QOffscreenSurface, QOpenGLContext
from PySide6.QtWidgets import QApplication
app = QApplication([])
context, surface = QOpenGLContext(), QOffscreenSurface()
surface.create()
print("drawn" if context.create() and context.makeCurrent(surface) else "no OpenGL")
"""


class DisplayError(PatternDBError, RuntimeError):
    """There is no display to open a window on, or no library to draw with."""


def check_display() -> None:
    """Raise DisplayError if no window can be opened here, with what would mend it.

    Costs a child process of about half a second, once, on Linux; elsewhere what Qt needs comes
    with the system. Raises MissingExtraError where Qt or VTK is not installed.
    """
    require_extra("viewer", "a window")
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if not sys.platform.startswith("linux") or platform in SCREENLESS:
        return
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or platform):
        raise DisplayError(
            "there is no display to open a window on (DISPLAY is not set); "
            "draw into a file instead (-o FILE), or run under xvfb-run"
        )
    trouble = try_display()
    if trouble is not None:
        raise DisplayError(trouble)


@functools.cache
def try_display() -> str | None:
    """Try in a child process to open what a window needs; None if that works, else why not."""
    try:
        trial = subprocess.run(
            [sys.executable, "-c", TRIAL], capture_output=True, timeout=PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"no window can be opened here: {error}"
    if trial.returncode == 0 and trial.stdout.strip() == b"drawn":
        return None
    return explain_failure(trial.returncode, trial.stdout + trial.stderr, find_missing_packages())


def find_missing_packages() -> list[str]:
    """Find the Debian packages whose libraries cannot be loaded here."""
    missing: list[str] = []
    for package, library in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(package)
    return missing


def explain_failure(code: int, said: bytes, missing: list[str]) -> str:
    """Explain why a trial failed, and what would mend it, in a message.

    code: that the child ended with. said: by it. missing: packages.
    """
    text = said.decode(errors="replace").strip()
    if missing:
        return (
            "no window can be opened: libraries are missing. Debian and Ubuntu: "
            f"apt-get install {' '.join(missing)}. Pictures (-o FILE) need none of them"
        )
    if "could not connect to display" in text:
        display = os.environ.get("DISPLAY", "")
        return (
            f"no window can be opened: the display {display!r} does not answer; "
            "draw into a file instead (-o FILE), or run under xvfb-run"
        )
    if "no OpenGL" in text:
        return (
            "no window can be opened: OpenGL has no driver. Debian and Ubuntu: "
            f"apt-get install {DRIVERS}. Pictures (-o FILE) need none"
        )
    last = text.splitlines()[-1] if text else f"the trial ended with code {code}"
    return f"no window can be opened: {last}"
