"""Noticing a file of the user's that hides one of our packages.

``ingest``, ``query`` and ``viewer`` are names that a script may well have. Python looks in the
script's folder first, so that ``import query`` would give the script instead of ours, and
whatever needs ours would fail with a message about something else.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from itertools import pairwise

from patterndb.errors import HiddenPackageError

#: Our packages whose names are ordinary words.
ORDINARY_NAMES = ("ingest", "query", "viewer")


def refuse_hidden_packages(folder: str, names: Iterable[str] = ORDINARY_NAMES) -> None:
    """Raise HiddenPackageError, which names the file, if another module hides one of ours.

    folder: where our packages lie side by side. Nothing is imported, and nothing is said of a
    package that does not lie there. Under ``python -m patterndb`` the process ends with the
    message alone, for nothing else could keep the traceback from it.
    """
    for name in names:
        found = _find(name)
        if found is None or found.origin is None:
            continue  # a folder without __init__.py hides nothing
        ours = PathFinder.find_spec(name, [folder])
        if ours is None or ours.origin is None or _is_same(ours.origin, found.origin):
            continue
        where = found.origin
        if os.path.basename(where) == "__init__.py":  # noqa: PTH119
            where = os.path.dirname(where)  # noqa: PTH120
        message = f"{where} hides patterndb's own package {name!r}: rename it"
        if sys.argv[:1] == ["-m"] and _is_run_as_module():
            print(f"patterndb: {message}", file=sys.stderr)
            raise SystemExit(3)
        raise HiddenPackageError(message)


def _find(name: str) -> ModuleSpec | None:
    try:
        return find_spec(name)
    except (ValueError, ImportError):  # a module without a spec, made by hand
        return None


def _is_same(ours: str, found: str) -> bool:
    return os.path.realpath(ours) == os.path.realpath(found)


def _is_run_as_module() -> bool:
    """Is ``python -m patterndb`` on its way?"""
    words = sys.orig_argv
    return any(a == "-m" and b.startswith("patterndb") for a, b in pairwise(words))
