"""The verb that describes an installation for a bug report: report."""

from __future__ import annotations

import os
import platform
import re
import sys
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import click

import patterndb
from patterndb.errors import PatternDBError
from patterndb.system.caches import cache_folders
from patterndb.system.extras import EXTRAS
from patterndb_app.cli.options import as_json
from patterndb_app.cli.text import plural, printable, write, write_json

#: How the program's own variables begin.
VARIABLES = "PATTERNDB_"


@click.command()
@as_json
def report(as_json: bool) -> int:
    """Describe this installation: versions, windows and cache folders.

    To be put into a bug report. It names folders, and so perhaps you: read it before you send it.

    \b
    patterndb report
    patterndb report --json
    """
    described = describe_installation()
    if as_json:
        write_json(described)
        return 0
    for title, entries in described.items():
        write(f"{title}:")
        for name, value in entries.items():
            write(f"  {name:<18} {printable(value)}")
    return 0


def describe_installation() -> dict[str, dict[str, str]]:
    """Describe this installation: words by their names, in sections."""
    return {
        "program": {
            "patterndb": patterndb.__version__,
            "folder": str(Path(patterndb.__file__).parent.parent),
            "Python": f"{platform.python_implementation()} {platform.python_version()}",
            "executable": sys.executable,
            "system": platform.platform(),
            "processor": platform.machine(),
            "cores": str(os.cpu_count()),
        },
        "packages": {name: _find_version(name) for name in _list_packages()},
        "extras": {
            name: "installed" if extra.is_there() else f"not installed: {extra.install}"
            for name, extra in EXTRAS.items()
        },
        "windows": {"here": _try_window(), "DISPLAY": os.environ.get("DISPLAY", "not set")},
        "cache folders": {
            f"{place}.": f"{folder} ({_measure_folder(folder)})"
            for place, folder in enumerate(cache_folders(), 1)
        },
        "variables": {k: v for k, v in sorted(os.environ.items()) if k.startswith(VARIABLES)},
    }


def _list_packages() -> list[str]:
    """List the packages that the program asks for."""
    try:
        lines = requires("patterndb") or []
    except PackageNotFoundError:
        # A checkout on the path, installed nowhere.
        lines = ["numpy", "scipy", "click", "msgspec", "platformdirs"]
    names = set[str]()
    for line in lines:
        extra = re.search(r"extra == ['\"](\w+)['\"]", line)
        name = re.match(r"[\w.-]+", line)
        # What developers alone install says nothing of the program.
        if name and (extra is None or extra[1] in EXTRAS):
            names.add(name[0])
    return sorted(names)


def _find_version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _measure_folder(folder: Path) -> str:
    """How much a folder holds, and whether it can be written."""
    if not folder.is_dir():
        return "not there"
    sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
    writable = "" if os.access(folder, os.W_OK) else ", cannot be written"
    return f"{plural(len(sizes), 'file')}, {sum(sizes) / 1e6:.1f} MB{writable}"


def _try_window() -> str:
    """Can a window be opened here? Tried in a process of its own; or why none can."""
    from viewer.shell.probe import check_display

    try:
        check_display()
    except PatternDBError as error:
        return str(error)
    return "can be opened"
