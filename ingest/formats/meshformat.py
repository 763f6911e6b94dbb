"""What the registry of mesh formats holds of each: an entry of ``ingest.formats.FORMATS``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from ingest.formats.files import ReadLimits
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import UnsupportedFormatError

Parse = Callable[[bytes, str | Path, ReadLimits], PolygonMesh]


def _need_nothing() -> None:
    """Require nothing: the format is read by this package itself."""


@dataclass(frozen=True, slots=True)
class MeshFormat:
    """A format of mesh files.

    name:     what people call it, "OBJ".
    suffixes: of its files, in lower case; the first is the usual one.
    help:     one line, for people, on what is read and written.
    parse:    the mesh in the bytes of a file, whose path is given for messages; where
              ``from_bytes`` is False, a library opens that path itself.
    require:  raises MissingExtraError where what reads it is not installed.
    spell:    a mesh as the bytes of a file; None where the format is read only.
    """

    name: str
    suffixes: tuple[str, ...]
    help: str
    parse: Parse
    spell: Callable[[PolygonMesh], bytes] | None = None
    from_bytes: bool = True
    require: Callable[[], None] = _need_nothing


def refuse_reading(name: str) -> Parse:
    """Return the ``parse`` of a format of triangles, which raises UnsupportedFormatError."""

    def parse(_data: bytes, path: str | Path, _limits: ReadLimits) -> NoReturn:
        raise UnsupportedFormatError(
            f"{name} holds triangles only, the quads were lost when it was written; export the "
            "original as OBJ, PLY or USD",
            path=path,
        )

    return parse
