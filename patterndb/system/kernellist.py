"""The list of kernels that the verbs call, with the types of arguments that they call them with.

``data/kernels.jsonl``, written by ``scripts/record_kernels.py``, a line each: packs are made of it,
and it tells what to compile before a verb runs. A list that has fallen behind the code does no
harm: what it names and is no more is passed over, and what it does not name is compiled when
needed.
"""

# pyright: reportMissingTypeStubs=false, reportPrivateUsage=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from typing import Any

from patterndb.system.kerneltypes import make_type

#: Where the list lies in the package.
LIST_NAME = "kernels.jsonl"


@dataclass(frozen=True, slots=True)
class ListedKernel:
    """A kernel as it is called.

    module, name: where it is found. types: of its arguments, as
    :func:`patterndb.system.kerneltypes.spell_type` spells them. verbs: those that call it so.
    plain: those of them whose plainest call does. seconds: about what compiling it took, whole
    ones, at least 1.
    """

    module: str
    name: str
    types: tuple[Any, ...]
    verbs: tuple[str, ...]
    seconds: int
    plain: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from the others."""
        return self.module, self.name, json.dumps(self.types)


def read_list(verbs: Iterable[str] | None = None, *, plain: bool = False) -> list[ListedKernel]:
    """The kernels of these verbs, of all where none are given; each once.

    plain: only what the plainest call of each verb needs.
    """
    text = (files("patterndb") / "data" / LIST_NAME).read_text(encoding="utf-8")
    listed = [parse_kernel(line) for line in text.splitlines()]
    if verbs is None:
        return listed
    wanted = set(verbs)
    return [kernel for kernel in listed if wanted & set(kernel.plain if plain else kernel.verbs)]


def parse_kernel(line: str) -> ListedKernel:
    """A line of the list."""
    document = json.loads(line)
    module, _, name = document["kernel"].partition(":")
    return ListedKernel(
        module,
        name,
        freeze_types(document["types"]),
        tuple(document["verbs"]),
        document["seconds"],
        tuple(document["plain"]),
    )


def format_kernel(kernel: ListedKernel) -> str:
    """The line of the list, without its end."""
    document = {
        "kernel": f"{kernel.module}:{kernel.name}",
        "types": kernel.types,
        "verbs": kernel.verbs,
        "plain": kernel.plain,
        "seconds": kernel.seconds,
    }
    return json.dumps(document)


def find_kernel(kernel: ListedKernel) -> tuple[Any, tuple[Any, ...]] | None:
    """Numba's dispatcher and the types of arguments; None where the code has them no more.

    Imports the module, and the compiler with it.
    """
    from patterndb.system.kernels import ContentCache

    try:
        found = getattr(import_module(kernel.module), kernel.name)
        types = tuple(make_type(spelled) for spelled in kernel.types)
    except (ImportError, AttributeError):
        return None
    if not isinstance(getattr(found, "_cache", None), ContentCache):
        return None
    return found, types


def freeze_types(value: Any) -> Any:
    """Types as JSON gives them, with tuples in place of lists: equal ones have equal hashes."""
    return tuple(freeze_types(one) for one in value) if isinstance(value, list) else value
