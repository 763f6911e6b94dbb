"""A screen of the tests' own, and windows on it; here, too, for its place: tests find hands.py."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.display.hands import Shown, end, open_display

MISSING = [name for name in ("Xvfb", "openbox", "xdotool") if shutil.which(name) is None]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what needs the screen, and skip it where that cannot be opened."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.display)
            if MISSING:
                named = f"{', '.join(MISSING)} is not there: apt-get install xvfb openbox xdotool"
                item.add_marker(pytest.mark.skip(reason=named))


@pytest.fixture(scope="module")
def display() -> Iterator[dict[str, str]]:
    """The environment of a screen with a window manager."""
    # Not in pytest's folder, whose name is too long for sockets.
    with tempfile.TemporaryDirectory() as folder, open_display(Path(folder)) as environment:
        yield environment


@pytest.fixture(scope="module")
def showing(display: dict[str, str]) -> Iterator[list[Shown]]:
    """The process that shows windows, if it was started; at the end it must end well."""
    started: list[Shown] = []
    try:
        yield started
        for one in started:
            one.finish()
    finally:
        for one in started:
            end(one.process)


@pytest.fixture
def shown(
    showing: list[Shown],
    display: dict[str, str],
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Shown]:
    """A hand on the process that shows windows, which go by a folder of the test's own."""
    if not showing:
        showing.append(Shown(display, tmp_path_factory.mktemp("showing")))
    (one,) = showing
    one.folder = tmp_path
    quiet = False
    try:
        yield one
        one.tell("[w.quit_now() for w in app.topLevelWidgets() if hasattr(w, 'quit_now')] and 0")
        one.check_quiet()
        quiet = True
    finally:
        if not quiet:
            # A question may be open yet: the next test gets another process.
            showing.clear()
            end(one.process)
