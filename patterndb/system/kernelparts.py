"""Which kernels call which, so that each is compiled once, before those that call it.

Numba compiles what a kernel calls together with it, and keeps both. Two processes that compile two
callers at once would both compile what these share, which is most of it.
``data/kernel_parts.jsonl``, written by ``scripts/record_parts.py``, has a line for every version:
the kernels of the list and all that they call. Like the list, it may fall behind the code without
harm.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from patterndb.system.kernellist import ListedKernel, freeze_types

#: Where the lines lie in the package.
PARTS_NAME = "kernel_parts.jsonl"


@dataclass(frozen=True, slots=True)
class KernelPart:
    """A version of a kernel, and what it calls.

    kernel: without verbs; its seconds are what compiling it took without what it calls, in tenths.
    calls: names of others (:func:`name_part`), those that it calls itself.
    """

    kernel: ListedKernel
    calls: tuple[str, ...]


def name_part(kernel: ListedKernel) -> str:
    """The name of a version among the parts: a hash of the kernel's name and its types."""
    return hashlib.sha256("\n".join(kernel.key).encode()).hexdigest()[:10]


def format_part(part: KernelPart) -> str:
    """The line of a part, without its end."""
    document = {
        "kernel": f"{part.kernel.module}:{part.kernel.name}",
        "types": part.kernel.types,
        "tenths": part.kernel.seconds,
        "calls": part.calls,
    }
    return json.dumps(document)


@cache
def read_parts() -> dict[str, KernelPart]:
    """All parts by their names; none where there is no such file."""
    path = files("patterndb") / "data" / PARTS_NAME
    if not path.is_file():
        return {}
    found: dict[str, KernelPart] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        document = json.loads(line)
        module, _, name = document["kernel"].partition(":")
        kernel = ListedKernel(module, name, freeze_types(document["types"]), (), document["tenths"])
        found[name_part(kernel)] = KernelPart(kernel, tuple(document["calls"]))
    return found


class CompileOrder:
    """Hands out kernels to be compiled: none before what it calls, long chains first.

    Parts that the kernels call are handed out as well. Not for several threads at once.
    """

    def __init__(self, kernels: Sequence[ListedKernel]) -> None:
        parts = read_parts()
        self._kernels = {name_part(kernel): kernel for kernel in kernels}
        reached = _reach(self._kernels, parts)
        self._calls: dict[str, set[str]] = {}
        callers: dict[str, list[str]] = {}
        for name in reached:
            # What is found in a kernel that calls itself is no reason to wait for it.
            calls = {c for c in parts[name].calls if c != name} if name in parts else set[str]()
            self._calls[name] = calls
            for call in calls:
                callers.setdefault(call, []).append(name)
        self._kernels |= {n: parts[n].kernel for n in reached if n not in self._kernels}
        self._callers = callers
        self.tenths = {
            name: parts[name].kernel.seconds if name in parts else 10 * kernel.seconds
            for name, kernel in self._kernels.items()
        }
        self._urgency: dict[str, int] = {}
        # What is called was reached before its callers: the reverse comes to callers first.
        for name in reversed(reached):
            above = max((self._urgency.get(c, 0) for c in callers.get(name, ())), default=0)
            self._urgency[name] = above + self.tenths[name]
        self._ready = {name for name, calls in self._calls.items() if not calls}
        self._at_work: set[str] = set()

    def __len__(self) -> int:
        """How many there are in all."""
        return len(self._kernels)

    def is_over(self) -> bool:
        """Has everything been handed out?"""
        return not self._calls

    def take(self) -> tuple[str, ListedKernel] | None:
        """The next one with its name, or None: all that is left waits for what is at work."""
        if not self._ready and self._calls and not self._at_work:
            # A ring of kernels that call each other: whichever is first compiles the others.
            self._ready = {max(self._calls, key=lambda name: self._urgency[name])}
        if not self._ready:
            return None
        name = max(self._ready, key=lambda one: (self._urgency[one], one))
        self._ready.discard(name)
        del self._calls[name]
        self._at_work.add(name)
        return name, self._kernels[name]

    def finish(self, name: str) -> None:
        """Note that a kernel is compiled, or cannot be: others need not wait for it any longer."""
        self._at_work.discard(name)
        for caller in self._callers.get(name, ()):
            if caller in self._calls:
                self._calls[caller].discard(name)
                if not self._calls[caller]:
                    self._ready.add(caller)


def _reach(names: Iterable[str], parts: dict[str, KernelPart]) -> list[str]:
    """All that these call, directly or not, and they themselves; what is called comes first."""
    reached: dict[str, None] = {}
    entered: set[str] = set()
    stack = [(name, False) for name in names]
    while stack:
        name, left = stack.pop()
        if left:
            reached[name] = None
        elif name not in entered:
            entered.add(name)
            stack.append((name, True))
            calls = parts[name].calls if name in parts else ()
            stack += [(c, False) for c in calls if c in parts and c not in entered]
    return list(reached)
