"""What a verb says while kernels are compiled that did not come with the package."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator

from patterndb.system.compiling import COMPILED
from patterndb_app.cli.progressline import ProgressLine
from patterndb_app.cli.text import say

#: Seconds of compiling from which on a verb says, in the end, what they were spent on.
WORTH_TELLING = 1.0


class CompileTalk:
    """What is said while kernels are compiled: in this process one by one, or ahead in others."""

    def __init__(self, head: str = "compiling kernels, once") -> None:
        self._head = head
        self._done = 0
        self._total = 0
        self._left = 0.0
        self._line: ProgressLine | None = None

    @contextlib.contextmanager
    def shown(self) -> Generator[None]:
        """Tell within the block, in which other processes compile."""
        self._line = ProgressLine(self._count)
        try:
            yield
        finally:
            self.close()

    def watch(self, compiling: bool) -> None:
        """Begin to tell, when compiling first begins (``CompileLog.watcher``)."""
        if compiling and self._line is None:
            self._line = ProgressLine(self._word)

    def update(self, done: int, total: int, left: float) -> None:
        """Note how many of how many kernels are there, and how many seconds are left."""
        self._done, self._total, self._left = done, total, left

    def close(self) -> None:
        """Take the line away."""
        if self._line is not None:
            self._line.close()

    def _word(self) -> str | None:
        if not COMPILED.is_compiling():
            return None
        if self._done < self._total:
            return self._count()
        return f"{self._head}: {COMPILED.kernels + 1} ({COMPILED.count_seconds():.0f} s)"

    def _count(self) -> str:
        left = f", about {self._left:.0f} s" if self._done else ""
        return f"{self._head}: {self._done} of {self._total}{left}"


@contextlib.contextmanager
def told_compiling(name_verb: Callable[[], str | None]) -> Generator[None]:
    """Compile what a verb lacks in several processes, when it first lacks something, and tell.

    name_verb: asked for the verb's name when it runs.
    """
    talk = CompileTalk()

    stages = iter((True, False))

    def compile_ahead() -> bool:
        # Imported here because a verb without kernels need not wait for it.
        from patterndb.system import warming

        plain = next(stages)
        warming.compile_ahead([name_verb() or ""], talk.update, plain=plain)
        return plain

    before = COMPILED.seconds
    watcher, ahead = COMPILED.watcher, COMPILED.ahead
    COMPILED.watcher, COMPILED.ahead = talk.watch, compile_ahead
    try:
        yield
    finally:
        COMPILED.watcher, COMPILED.ahead = watcher, ahead
        talk.close()
        if COMPILED.seconds - before > WORTH_TELLING:
            say(f"compiled kernels in {COMPILED.seconds - before:.0f} s{_explain()}")


def _explain() -> str:
    """Why it had to be, and where they are kept, as the end of a sentence."""
    from patterndb.system.caches import kernel_folder
    from patterndb.system.kernels import find_shipped

    folder = kernel_folder()
    pack, reason = find_shipped()
    why = "" if pack is not None else f" ({reason})"
    if folder is None:
        return f"{why}; there is no folder to keep them in: set PATTERNDB_CACHE to one"
    return f"{why}, kept in {folder}"
