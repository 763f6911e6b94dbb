"""The progress bar of an ingest: on a terminal only, with rate and time left."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Generator
from typing import TYPE_CHECKING

from patterndb_app.cli.text import plural, printable, say, shortened

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

    from ingest import MeshReport, Progress

#: Characters of the names of the meshes in work beside the bar.
SHOWN_NAMES = 30


class LearningProgress:
    """Shows what an ingest reports: lines for files, and a bar if there is one."""

    def __init__(self, bar: Bar | None, talk: bool) -> None:
        self._bar = bar
        self._talk = talk
        self._task: TaskID | None = None
        self._started = time.perf_counter()

    def update(self, state: Progress) -> None:
        """Move the bar."""
        if self._bar is None:
            return
        if self._task is None:
            self._task = self._bar.add_task("learning", total=state.bytes_total, rate="", names="")
        seconds = time.perf_counter() - self._started
        self._bar.update(
            self._task,
            completed=state.bytes_done,
            rate=f"{state.patches / max(seconds, 1e-9):,.0f} patches/s",
            names=shortened(printable(", ".join(state.working)), SHOWN_NAMES),
        )

    def report(self, mesh: MeshReport) -> None:
        """Tell what became of a file."""
        if not self._talk:
            return
        if mesh.outcome in ("learned", "replaced"):
            text = (
                f"{mesh.name}: {plural(mesh.distinct, 'patch', 'patches')} of "
                f"{plural(mesh.quads_used, 'quad')}, {plural(mesh.patterns, 'pattern')}, "
                f"{mesh.new_patterns:,} of them new"
            )
            if mesh.outcome == "replaced":
                text += " (had been learned with other options)"
            if mesh.quads_read == 0:
                text = f"{mesh.name}: holds no quads; nothing to learn"
        else:
            text = f"{mesh.name}: {mesh.outcome}"
        if self._bar is not None:
            self._bar.console.print(printable(text), highlight=False, markup=False, soft_wrap=True)
        else:
            say(printable(text))


@contextlib.contextmanager
def learning_progress(*, talk: bool) -> Generator[LearningProgress]:
    """The progress of one ingest; the bar goes away at its end."""
    # There is no stderr at all where the shell closed it (2>&-).
    if sys.stderr is None or not sys.stderr.isatty():  # pyright: ignore[reportUnnecessaryComparison]
        yield LearningProgress(None, talk)
        return
    # Imported here because rich takes a moment that piped runs need not wait for.
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as RichProgress

    bar = RichProgress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        TextColumn("left"),
        TextColumn("{task.fields[names]}", style="dim", markup=False),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        yield LearningProgress(bar, talk)
