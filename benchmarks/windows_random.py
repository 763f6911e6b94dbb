"""Do thousands of random things in each window, and see that it stays whole.

    python benchmarks/windows_random.py --actions 10000 --seed 1 [--window retopo]

Commands of menus, keys, drags with any button, in the middle of which other things are done, the
wheel, sliders, lists and fields of docks, other sizes; all in one process, with its loop of events,
on no screen unless QT_QPA_PLATFORM names one. A window fails if an exception comes out of it, an
invariant of what it shows does not hold, or some steps taken back and done again do not lead to
where it was. Prints a table in Markdown: the slowest action in milliseconds, and the process's
memory in megabytes after a fifth of the actions and at the end; on the other stream, as it goes,
failures, and the memory after each thousand. Exits 1 after a failure.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import qInstallMessageHandler
from PySide6.QtWidgets import QFileDialog, QMessageBox

from tests.support.viewer.randomhand import MAKERS, try_window


def answer_dialogs(folder: Path) -> None:
    """Have files named without asking, and every question answered with Cancel."""
    QMessageBox.question = lambda *_: QMessageBox.StandardButton.Cancel  # type: ignore[method-assign]
    QFileDialog.getSaveFileName = (  # type: ignore[method-assign]
        lambda _parent, _title, _suggested, filters: (str(folder / f"saved{filters[1:]}"), filters)
    )


def quieten(_kind: object, _context: object, said: str) -> None:
    """Print what Qt says, but for what it lacks where there is no screen."""
    if not said.startswith(("QOpenGLWidget: Failed to create", "This plugin does not support")):
        print(said, file=sys.stderr)


def main() -> None:
    """Try the windows that are asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--actions", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--window", choices=list(MAKERS), action="append")
    options = parser.parse_args()
    print("| window | actions | failures | slowest, ms | memory, MB | s |")
    print("|---|---:|---:|---|---:|---:|", flush=True)
    failed = False
    qInstallMessageHandler(quieten)
    with tempfile.TemporaryDirectory() as folder:
        answer_dialogs(Path(folder))
        for name in options.window or MAKERS:
            tried = try_window(name, options.actions, options.seed, Path(folder))
            print(
                f"| {name} | {tried.actions:,} | {len(tried.failures)} "
                f"| {1e3 * tried.slowest:.0f} ({tried.slowest_action}) "
                f"| {tried.early:.0f}, {tried.late:.0f} | {tried.seconds:.0f} |",
                flush=True,
            )
            failed |= bool(tried.failures)
    sys.exit(failed)


if __name__ == "__main__":
    main()
