"""Write patterndb/data/kernel_parts.jsonl: which kernels call which, and how long each compiles.

    python scripts/record_parts.py

Compiles every kernel of the list anew, in this process and into a folder that is then removed:
some six minutes. To be run after scripts/record_kernels.py; what the file lacks is only compiled
more often than it need be.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from patterndb.system.caches import KERNELS_VARIABLE
from patterndb.system.files import replace_file
from patterndb.system.kernellist import (
    ListedKernel,
    find_kernel,
    freeze_types,
    read_list,
)
from patterndb.system.kernelpack import PACK_VARIABLE
from patterndb.system.kernelparts import PARTS_NAME, KernelPart, format_part, name_part
from patterndb.system.kerneltypes import spell_type

TARGET = Path(__file__).resolve().parents[1] / "patterndb" / "data" / PARTS_NAME


class PartRecorder:
    """What is compiled, what it calls, and how long it takes without that."""

    def __init__(self) -> None:
        self.kernels: dict[str, ListedKernel] = {}
        self.calls: dict[str, set[str]] = {}
        self.seconds: dict[str, float] = {}
        # Of what is being compiled, outermost first: name, time of the beginning, seconds within
        # it that belong to what it calls.
        self._stack: list[tuple[str, float, list[float]]] = []

    def name(self, dispatcher: Any, types: Any) -> str:
        """The name of a version; empty where the list has no words for it."""
        from patterndb.system.kernels import ContentCache

        if not isinstance(getattr(dispatcher, "_cache", None), ContentCache):
            return ""
        function = dispatcher.py_func
        try:
            spelled = freeze_types([spell_type(one) for one in types])
        except ValueError:
            return ""
        kernel = ListedKernel(function.__module__, function.__name__, spelled, (), 0)
        found = name_part(kernel)
        self.kernels[found] = kernel
        return found

    def note_call(self, dispatcher: Any, types: tuple[Any, ...]) -> None:
        """Note a call within what is being compiled."""
        called = self.name(dispatcher, types)
        within = next((name for name, _, _ in reversed(self._stack) if name), "")
        if called and within:
            self.calls.setdefault(within, set()).add(called)

    def begin(self, dispatcher: Any, types: Any) -> None:
        """Note that something begins to be compiled."""
        name = self.name(dispatcher, types)
        self._stack.append((name, time.process_time(), [0.0]))

    def end(self) -> None:
        """Note that what was begun last has been compiled."""
        name, began, within = self._stack.pop()
        took = time.process_time() - began
        if self._stack:
            # Numba's own functions belong to the kernel that calls them.
            self._stack[-1][2][0] += took if name else within[0]
        if name:
            self.seconds[name] = self.seconds.get(name, 0.0) + took - within[0]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        # Read by what is imported from here on.
        os.environ.update({KERNELS_VARIABLE: folder, PACK_VARIABLE: ""})
        from numba.core import event

        from patterndb.system.compiling import COMPILED
        from patterndb.system.kernels import CALL_NOTES

        COMPILED.watcher = lambda compiling: None
        recorder = PartRecorder()

        class Listener(event.Listener):
            """Passes events on: numba wants one of its own class."""

            def on_start(self, event: Any) -> None:
                recorder.begin(event.data["dispatcher"], event.data["args"])

            def on_end(self, event: Any) -> None:
                recorder.end()

        event.register("numba:compile", Listener())
        CALL_NOTES.append(recorder.note_call)
        listed = read_list()
        for i, kernel in enumerate(listed):
            found = find_kernel(kernel)
            if found is None:
                sys.exit(f"{kernel.module}.{kernel.name} is no more: scripts/record_kernels.py")
            dispatcher, types = found
            dispatcher.compile(types)
            print(f"{i + 1} of {len(listed)}: {kernel.name}", file=sys.stderr)
    lines: list[str] = []
    for name, kernel in sorted(recorder.kernels.items(), key=lambda item: item[1].key):
        tenths = max(1, round(10 * recorder.seconds.get(name, 0.0)))
        noted = ListedKernel(kernel.module, kernel.name, kernel.types, (), tenths)
        lines.append(format_part(KernelPart(noted, tuple(sorted(recorder.calls.get(name, ()))))))
    replace_file(TARGET, "".join(line + "\n" for line in lines))
    print(f"{len(lines)} versions, {sum(recorder.seconds.values()):.0f} s: {TARGET}")


if __name__ == "__main__":
    main()
