"""The optional parts of an installation: what each brings, and what needs it.

``pip install patterndb`` brings what learning, queries and flat pictures need. The table below is
what pyproject.toml offers beside it; a test holds the two together.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

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
        """The line that installs it."""
        return f'pip install "patterndb[{self.name}]"'

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
            "windows; reading VTK files",
        ),
        Extra("sketch", ("ortools",), "surfacing networks, retopology, the solver cp-sat"),
        Extra("usd", ("pxr",), "reading USD files"),
        Extra("service", ("fastapi", "uvicorn", "python_multipart"), "answering over HTTP"),
        Extra("client", ("httpx",), "asking a service"),
        Extra("dask", ("dask", "distributed"), "learning on a cluster"),
    )
}


def require_extra(name: str, doing: str, packages: tuple[str, ...] = ()) -> None:
    """Raise MissingExtraError where an extra is not installed, with the line that installs it.

    doing: what needs it, the subject of the sentence ("reading USD files"). packages: those of it
    that are needed; () is all of them.

    Example: ``require_extra("viewer", "a window")``
    """
    extra = EXTRAS[name]
    missing = [one for one in extra.find_missing() if not packages or one in packages]
    if missing:
        raise MissingExtraError(
            f"{doing} needs {' and '.join(missing)}, which is not installed: {extra.install}"
        )
