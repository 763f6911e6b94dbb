"""The optional parts of an installation: what each brings, and what needs it.

The package alone brings what learning, queries and flat pictures need. The table below is what
pyproject.toml offers in addition; a test holds the two together.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires
from importlib.util import find_spec
from pathlib import Path

from patterndb.errors import MissingExtraError


@dataclass(frozen=True, slots=True)
class Extra:
    """An optional part of the installation.

    packages: what it installs, by the names that they are imported by. purpose: what needs it.
    """

    name: str
    packages: tuple[str, ...]
    purpose: str

    @property
    def install(self) -> str:
        """The command that installs it, by the tool that installed this program.

        It names the packages themselves, because no index has this one.
        """
        wanted = " ".join(_quote(one) for one in list_requirements(self.name))
        prefix = Path(sys.prefix)
        if (prefix / "pipx_metadata.json").exists():
            return f"pipx inject {_quote(prefix.name)} {wanted}"
        # Environments that uv makes have no pip.
        if find_spec("pip") is None:
            return f"uv pip install --python {_quote(sys.executable)} {wanted}"
        return f"{_quote(sys.executable)} -m pip install {wanted}"

    def is_there(self) -> bool:
        """Can all its packages be imported?"""
        return not self.find_missing()

    def find_missing(self) -> list[str]:
        """Find those of its packages that are not installed."""
        return [package for package in self.packages if find_spec(package) is None]


#: Every extra by its name.
EXTRAS = {
    extra.name: extra
    for extra in (
        Extra(
            "viewer",
            ("vtkmodules", "pyvista", "matplotlib", "PySide6", "pyvistaqt"),
            "windows; pictures of surfaces; pyvista; reading VTK files",
        ),
        Extra("sketch", ("ortools",), "surfacing networks, retopology, the solver cp-sat"),
        Extra("usd", ("pxr",), "reading USD files"),
        Extra("service", ("fastapi", "uvicorn", "python_multipart"), "answering over HTTP"),
        Extra("client", ("httpx",), "asking a service"),
        Extra("dask", ("dask", "distributed"), "learning on a cluster"),
    )
}


def list_requirements(extra: str) -> list[str]:
    """List what an extra installs, as pip takes it; sources that are installed nowhere name
    themselves."""
    try:
        lines = requires("patterndb") or []
    except PackageNotFoundError:
        lines = []
    of_extra = re.compile(rf"""extra == ["']{extra}["']""")
    found = [line.partition(";")[0].strip() for line in lines if of_extra.search(line)]
    return found or [f"{Path(__file__).parents[2]}[{extra}]"]


def _quote(word: str) -> str:
    """The word as shells take it, Windows' too."""
    return word if re.fullmatch(r"[\w./:\\-]+", word) else f'"{word}"'


def require_extra(name: str, doing: str, packages: tuple[str, ...] = ()) -> None:
    """Raise MissingExtraError where an extra is not installed, with the command that installs it.

    doing: what needs it, the subject of the sentence ("reading USD files"). packages: those of it
    that are needed; () is all of them.

    Example: ``require_extra("viewer", "a window")``
    """
    extra = EXTRAS[name]
    missing = [one for one in extra.find_missing() if not packages or one in packages]
    if missing:
        lacking = "is not installed" if len(missing) == 1 else "are not installed"
        raise MissingExtraError(
            f"{doing} needs {' and '.join(missing)}, which {lacking} (extra {name}): "
            f"{extra.install}"
        )
