"""How fast the windows answer, on the screen that DISPLAY names.

    xvfb-run -a -s "-screen 0 1600x1000x24" python benchmarks/windows.py --triangles 100000

Of each window, at 1400 x 900: from its making to its first picture, with what it shows in memory;
from a move of the pointer with the button down, or what a window has in place of that, to the
picture that shows it; from what ends a job (the last corner, the button that comes up) to the
picture with its result; and the processor's time for a picture while the view is turned. All events
go the way of the pointer's; a picture is there when Qt has shown it. Medians, and the slowest in
brackets. Retopology and feature curves are on a hilly sheet of so many triangles.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
# The tests open the same windows.
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
from PySide6.QtCore import QEvent, QPointF, Qt  # noqa: E402
from PySide6.QtGui import QMouseEvent  # noqa: E402
from PySide6.QtWidgets import QApplication  # noqa: E402

from benchmarks.retopo_response import SIDE, hills  # noqa: E402
from tests.support.display.six_windows import MAKERS, make_features, make_retopo  # noqa: E402
from viewer.shell.application import start_application  # noqa: E402
from viewer.shell.settings import ShellSettings  # noqa: E402

SIZE = (1400, 900)

#: Seconds that anything may take.
LIMIT = 120.0

#: Pictures of which the processor's time is taken.
FRAMES = 40

Place = tuple[float, float]
LEFT, RIGHT, NONE = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton, Qt.MouseButton.NoButton


class TimedWindow:
    """A window, and hands that take times.

    make: makes it; it is shown, and its first picture waited for.
    """

    def __init__(self, make: Callable[[], Any]) -> None:
        self._frames = 0
        begun = time.perf_counter()
        self.window = make()
        shown = getattr(self.window.picture, "frameSwapped", None)
        if shown is None:
            # Small pictures are Qt's own: one is there when its pane has been painted.
            self.window.picture.pane.installEventFilter(self._make_filter())
        else:
            shown.connect(self._count)
        self.window.resize(*SIZE)
        self.window.show()
        self.window.activateWindow()
        self.wait(lambda: self._frames > 0)
        self.first = time.perf_counter() - begun
        self.rest()

    def _make_filter(self) -> Any:
        from PySide6.QtCore import QObject

        count = self._count

        class Painted(QObject):
            """Counts paintings."""

            def eventFilter(self, _watched: QObject, event: QEvent) -> bool:  # noqa: N802
                if event.type() == QEvent.Type.Paint:
                    count()
                return False

        self._filter = Painted()
        return self._filter

    def _count(self) -> None:
        self._frames += 1

    @property
    def state(self) -> Any:
        """What is shown."""
        return self.window.saver.state

    def wait(self, done: Callable[[], object]) -> None:
        """Let events come until something holds."""
        limit = time.perf_counter() + LIMIT
        while not done():
            QApplication.processEvents()
            if time.perf_counter() > limit:
                raise TimeoutError(f"not done in {LIMIT:.0f} s: {self.state.message}")

    def rest(self, seconds: float = 0.15) -> None:
        """Let what is on its way be done."""
        until = time.perf_counter() + seconds
        self.wait(lambda: time.perf_counter() > until)

    def send(self, kind: QEvent.Type, at: Place, button: Any = LEFT) -> None:
        """Send an event of the pointer at a place in points from the middle."""
        view = self.window.picture
        width, height = view.room
        place = QPointF(at[0] + width / 2.0, height / 2.0 - at[1])
        down = NONE if kind == QEvent.Type.MouseButtonRelease else button
        which = NONE if kind == QEvent.Type.MouseMove else button
        event = QMouseEvent(
            kind, place, view.mapToGlobal(place), which, down, Qt.KeyboardModifier.NoModifier
        )
        QApplication.sendEvent(view, event)

    def press(self, at: Place, button: Any = LEFT) -> None:
        self.send(QEvent.Type.MouseMove, at, NONE)
        self.send(QEvent.Type.MouseButtonPress, at, button)

    def move(self, at: Place, button: Any = LEFT) -> None:
        self.send(QEvent.Type.MouseMove, at, button)

    def release(self, at: Place, button: Any = LEFT) -> None:
        self.send(QEvent.Type.MouseButtonRelease, at, button)

    def click(self, at: Place) -> None:
        self.press(at)
        self.release(at)

    def do(self, name: str) -> None:
        """Obey a command."""
        self.window.table.bound[name].action.trigger()

    def until_shown(self, act: Callable[[], object], done: Callable[[], object]) -> float:
        """Seconds of an act, until it is done and a picture was shown after that."""
        self.rest()
        begun = time.perf_counter()
        act()
        self.wait(done)
        # The picture that shows it is one that is begun after it is known.
        self.window.show_change()
        count = self._frames
        self.wait(lambda: self._frames > count)
        return time.perf_counter() - begun

    def until_seen(self, act: Callable[[], object]) -> float:
        """Seconds of an act that changes the picture at once, until it was shown."""
        self.rest()
        count = self._frames
        begun = time.perf_counter()
        act()
        self.wait(lambda: self._frames > count)
        return time.perf_counter() - begun

    def turn(self) -> float:
        """Seconds of the processor for a picture while the view turns."""
        self.press((150.0, 150.0), RIGHT)
        self.rest()
        begun = time.process_time()
        for number in range(FRAMES):
            count = self._frames
            self.move((150.0 + 3.0 * number, 150.0 + number), RIGHT)
            self.wait(lambda count=count: self._frames > count)
        took = time.process_time() - begun
        self.release((150.0, 150.0), RIGHT)
        return took / FRAMES


def bow(count: int = 12) -> list[Place]:
    """Places along a short stroke."""
    t = np.linspace(0.0, 1.0, count)
    return list(zip((-60.0 + 90.0 * t).tolist(), (40.0 * np.sin(2.0 * t)).tolist(), strict=True))


def draw_ink(one: TimedWindow, times: int) -> list[float]:
    """Times from a move of the pointer to the ink that shows it."""
    places = bow(times + 1)
    one.press(places[0])
    found = [one.until_seen(lambda place=place: one.move(place)) for place in places[1:]]
    one.do("leave")
    one.release(places[-1])
    one.rest()
    return found


def time_browser(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """In place of ink, another pattern that is selected; in place of a fill, one widened."""
    step = [one.until_seen(lambda: one.do("next")) for _ in range(times)]
    one.do("chord-after")
    return step, [one.until_seen(lambda: one.do("wider")) for _ in range(min(times, 8))]


def time_explorer(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """From the last corner to the first fill."""
    fills: list[float] = []
    for number in range(times):
        one.do("draw-boundary")
        for x, y in ((-200, -150), (200 + 5 * number, -150), (200, 150), (-200, 140)):
            one.click((float(x), float(y)))
        fills.append(
            one.until_shown(
                lambda: one.do("close-boundary"), lambda: one.state.finder.placed is not None
            )
        )
        one.wait(lambda: not one.state.finder.searching)
    one.do("draw-stroke")
    return draw_ink(one, times), fills


def time_retopo(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """From the release that closes a patch to its quads."""
    one.do("tool-stroke")
    inks = draw_ink(one, times)
    corners = [(-150.0, -120.0), (150.0, -120.0), (150.0, 120.0), (-150.0, 120.0)]

    def draw(a: Place, b: Place) -> None:
        places = np.linspace(a, b, 20).tolist()
        one.press(tuple(places[0]))
        for place in places[1:]:
            one.move(tuple(place))

    for number in range(3):
        draw(corners[number], corners[number + 1])
        one.release(corners[number + 1])
        one.wait(lambda: not one.state.editing.waiting)
    fills: list[float] = []
    for _ in range(times):
        draw(corners[3], corners[0])
        fills.append(
            one.until_shown(
                lambda: one.release(corners[0]),
                lambda: not one.state.editing.waiting and len(one.state.shown.body.mesh.quads),
            )
        )
        one.do("undo")
        one.wait(lambda: not one.state.editing.waiting)
    return inks, fills


def time_surfacing(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """From a click that switches a patch off, or on, to the surface without it, or with it."""
    one.do("draw-strokes")
    inks = draw_ink(one, times)
    fills: list[float] = []
    for _ in range(times):
        made = one.state.surfaces.made
        fills.append(
            one.until_shown(
                lambda: one.click((-60.0, 60.0)),
                lambda made=made: one.state.surfaces.made is not made,
            )
        )
    return inks, fills


def time_features(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """In place of ink, a pin that follows the pointer; from the last click to the curve."""
    fills: list[float] = []
    for number in range(times):
        one.do("draw-curve")
        y = -100.0 + 9.0 * number
        one.click((-120.0, y))
        one.click((0.0, y + 10.0))
        fills.append(
            one.until_shown(
                lambda y=y: (one.click((120.0, y)), one.do("finish-curve")),
                lambda: not one.state.editing.making,
            )
        )
    curve = one.state.editing.curve
    at = one.state.camera.view.seen(one.state.editing.look(curve).line[60])[:2]
    one.press(tuple(at.tolist()))
    moved = [
        one.until_seen(lambda n=n: one.move((float(at[0]) + 2.0 * n, float(at[1]) + 5.0 + n)))
        for n in range(1, times + 1)
    ]
    one.release((float(at[0]), float(at[1])))
    return moved, fills


def time_shapes(one: TimedWindow, times: int) -> tuple[list[float], list[float]]:
    """In place of ink, the shape that follows the pull; from its end to the picture."""
    lines = [line.name for line in one.state.skin.lines]
    seen = one.state.sight.lines[lines.index("roof_rail")]
    x, y = seen[len(seen) // 2, :2].tolist()
    moved: list[float] = []
    ended: list[float] = []
    for _ in range(max(1, times // 5)):
        one.press((x, y))
        one.move((x, y + 12.0))
        moved += [
            one.until_seen(lambda n=n: one.move((x, y + 12.0 + 3.0 * n))) for n in range(1, 6)
        ]
        ended.append(one.until_seen(lambda: one.release((x, y + 27.0))))
        one.do("undo")
    return moved, ended


TIMERS = {
    "browse": time_browser,
    "explore": time_explorer,
    "retopo": time_retopo,
    "surface": time_surfacing,
    "features": time_features,
    "shape-model": time_shapes,
}


def make_fine(triangles: int) -> dict[str, Callable[[ShellSettings, Path], Any]]:
    """Make what makes the windows, those of models on so many triangles."""
    from patterndb.core.polygonmesh import PolygonMesh
    from patterndb.geometry.surface import Surface

    surface = hills(triangles)
    points = surface.vertices - SIDE / 2.0
    model = Surface.from_soup(PolygonMesh.from_faces(points, surface.triangles))
    return MAKERS | {
        "retopo": lambda settings, folder: make_retopo(settings, folder, surface),
        "features": lambda settings, folder: make_features(settings, folder, model),
    }


def spell(seconds: list[float]) -> str:
    """Spell times in milliseconds."""
    return f"{1e3 * median(seconds):.0f} ({1e3 * max(seconds):.0f})"


def main() -> None:
    """Time the windows that are asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--triangles", type=int, default=100_000)
    parser.add_argument("--window", choices=list(MAKERS), action="append")
    options = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors", file=sys.stderr)
    print("| window | first picture, ms | move to ink, ms | end to result, ms | CPU a frame, ms |")
    print("|---|---:|---:|---:|---:|", flush=True)
    makers = make_fine(options.triangles)
    with tempfile.TemporaryDirectory() as folder:
        settings = ShellSettings(Path(folder) / "windows.ini")
        start_application(settings)
        for name in options.window or MAKERS:
            # What a process pays once is paid.
            make = makers[name]
            TimedWindow(lambda make=make: make(settings, Path(folder))).window.quit_now()
            one = TimedWindow(lambda make=make: make(settings, Path(folder)))
            inks, fills = TIMERS[name](one, options.times)
            turned = "" if name == "browse" else f"{1e3 * one.turn():.0f}"
            print(
                f"| {name} | {1e3 * one.first:.0f} | {spell(inks)} | {spell(fills)} | {turned} |",
                flush=True,
            )
            one.window.quit_now()
            close = getattr(one.state, "close", None)
            if close is not None:
                close()


if __name__ == "__main__":
    main()
