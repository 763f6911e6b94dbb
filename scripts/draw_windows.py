"""Take pictures of all windows on a screen of their own, at three sizes, light and dark.

    python scripts/draw_windows.py FOLDER [--size 1024x700@1] [--window retopo]

Needs xvfb-run. Each window is opened as large as the screen, on something small, with its job done;
the sizes are 1024 x 700, 1600 x 1000, and 3840 x 2160 of which Qt makes 1920 x 1080 at scale 2.
docs/images/windows has those of 1600 x 1000. Look at all of them after a change of the windows.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
# The tests open the same windows.
sys.path.insert(0, str(ROOT))

#: A picture of more bytes is written once more with so many colours.
LARGEST, COLOURS = 300_000, 256

#: Pixels across and down, and how many of them are a logical one.
SIZES = ("1024x700@1", "1600x1000@1", "3840x2160@2")

THEMES = ("light", "dark")

#: Seconds that a window gets to paint what it shows, at most and at least.
PATIENCE, PAUSE = 180.0, 1.5

#: Seconds that it has been done for, and rounds of events in which that is shown: where a
#: processor draws, one may take seconds.
SEEN, ROUNDS = 0.3, 5

#: Corners of a boundary, and of a patch, in parts of the picture's lesser side.
SQUARE = ((-0.24, -0.24), (0.26, -0.22), (0.23, 0.24), (-0.22, 0.21))


def run_on_screen(folder: Path, size: str, windows: list[str]) -> None:
    """Take the pictures of one size in a process with a screen of that size."""
    pixels, _, scale = size.partition("@")
    environment = {
        name: value for name, value in os.environ.items() if name != "QT_QPA_PLATFORM"
    } | {"QT_SCALE_FACTOR": scale}
    chosen = [word for name in windows for word in ("--window", name)]
    subprocess.run(
        ["xvfb-run", "-a", "-s", f"-screen 0 {pixels}x24", sys.executable, __file__, str(folder),
         "--size", size, "--here", *chosen],
        env=environment, check=True,
    )  # fmt: skip


def take_pictures(folder: Path, size: str, windows: list[str]) -> None:
    """Take the pictures of one size on the screen that there is."""
    from tests.support.display.six_windows import MAKERS
    from viewer.shell.application import start_application
    from viewer.shell.docks import ThumbnailList
    from viewer.shell.settings import ShellSettings

    with tempfile.TemporaryDirectory() as kept:
        for theme in THEMES:
            settings = ShellSettings(Path(kept) / f"{theme}.ini")
            settings.theme = theme
            app = start_application(settings)
            for name in windows or MAKERS:
                window: Any = MAKERS[name](settings, Path(kept))
                window.setGeometry(app.primaryScreen().geometry())
                window.show()
                window.picture.setFocus()
                wait(app, lambda: True)
                do_job(name, window)
                state = window.saver.state
                lists = window.findChildren(ThumbnailList)
                window.refresh()
                wait(
                    app,
                    lambda state=state, lists=lists: (
                        not is_busy(state) and not any(one.is_painting for one in lists)
                    ),
                )
                for _ in range(ROUNDS):
                    window._poll()
                    window.refresh()
                    app.processEvents()
                wait(app, lambda lists=lists: not any(one.is_painting for one in lists))
                path = folder / f"{name}-{size.partition('@')[0]}-{theme}.png"
                picture = window.screen().grabWindow(window.winId()).toImage()
                # As small as PNG gets.
                if not picture.save(str(path), quality=0):
                    raise OSError(f"{path} cannot be written")
                if path.stat().st_size > LARGEST:
                    with Image.open(path) as full:
                        full.convert("RGB").quantize(COLOURS).save(path, optimize=True)
                print(path, flush=True)
                window.quit_now()
                window.deleteLater()


def wait(app: Any, done: Callable[[], bool]) -> None:
    """Let the window paint what it shows, until that has been all for a while."""
    begun, since = time.monotonic(), None
    while True:
        # One round may paint for longer than the while: what holds is asked after it.
        app.processEvents()
        now = time.monotonic()
        since = (since or now) if done() else None
        if since is not None and now > max(begun + PAUSE, since + SEEN):
            return
        if now > begun + PATIENCE:
            raise TimeoutError(f"nothing is done after {PATIENCE:.0f} s")
        time.sleep(0.01)


def is_busy(state: Any) -> bool:
    """Is something being made in the background?"""
    if hasattr(state, "finder"):
        return state.finder.searching or state.finder.placed is None
    editing = getattr(state, "editing", None)
    return bool(
        getattr(editing, "waiting", False)
        or getattr(editing, "making", False)
        or getattr(editing, "listing", False)
    )


def do_job(name: str, window: Any) -> None:
    """Do what a window is for, by its state: the hands are the tests'."""
    state, side = window.saver.state, min(window.picture.room)
    corners = [(x * side, y * side) for x, y in SQUARE]

    def drag(*places: tuple[float, float]) -> None:
        state.move(*places[0])
        state.press(*places[0])
        for place in places[1:]:
            state.move(*place)
        state.release(*places[-1])

    if name == "browse":
        window.saver.play(("Right", "Right", "]", "l"))
    elif name == "explore":
        window.saver.obey("b")
        for corner in corners:
            drag(corner)
        window.saver.play(("Enter", "Right"))
    elif name == "retopo":
        window.saver.obey("d")
        for number in range(4):
            a, b = corners[number - 1], corners[number]
            drag(*(((1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1])
                   for t in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)))  # fmt: skip
            state.settle()
    elif name == "surface":
        window.saver.obey("d")
        drag((-0.1 * side, 0.1 * side), (-0.2 * side, 0.16 * side), (-0.25 * side, 0.1 * side))
    elif name == "features":
        window.saver.obey("c")
        for x in (-0.7, 0.0, 0.7):
            drag(tuple(state.camera.view.seen((x, 0.02, -0.02))[:2].tolist()))
        window.saver.play(("Enter", "r"))
    else:
        window.saver.play(("n", "g"))
    window.show_change()


def main() -> None:
    """Take the pictures that are asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", choices=SIZES, action="append")
    parser.add_argument("--window", action="append", default=[])
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for size in options.size or SIZES:
        if options.here:
            take_pictures(options.folder, size, options.window)
        else:
            run_on_screen(options.folder, size, options.window)


if __name__ == "__main__":
    main()
