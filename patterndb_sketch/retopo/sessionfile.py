"""Sessions of retopology as files: the surface, the curves, counts, fills and sizes.

A session is one zip file of three entries:

- session.json: {"format": "patterndb retopology session", "version": 1, "name": "spot.obj",
  "sizes": {"snap": 0.04, ...}, "plane": null, "network": ...}, the plane of symmetry as
  {"point": [0, 0, 0], "normal": [1, 0, 0]} while that is on, the network as
  :mod:`patterndb_sketch.retopo.sessionnetwork` has it;
- surface.npz: vertices (v, 3) float64 and triangles (t, 3) int32 of the ground;
- network.npz: the arrays of the network.

The history of undo is not part of it.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb.system.documents import JsonValue, parse_json, read_limited
from patterndb.system.files import replace_file
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.sessionfills import ARRAYS as NETWORK_ARRAYS
from patterndb_sketch.retopo.sessionfills import entries_of
from patterndb_sketch.retopo.sessionnetwork import network_document, network_of
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.state import State
from patterndb_sketch.retopo.symmetry import Plane, cut_half

#: How the name of a session's file ends.
SUFFIX = ".retopo"

#: Bytes that a session may have, packed or not: a surface of some 20 million triangles.
MAX_BYTES = 1_000_000_000

FORMAT, VERSION = "patterndb retopology session", 1
JSON_NAME, SURFACE_NAME, NETWORK_NAME = "session.json", "surface.npz", "network.npz"
KEYS = ("format", "version", "name", "sizes", "plane", "network")
SURFACE_ARRAYS = {"vertices": ("<f8", 3), "triangles": ("<i4", 3)}

#: How hard arrays are packed: coordinates hardly get smaller by more, and it takes thrice as long.
PACKING = 1


@dataclass(frozen=True, slots=True, eq=False)
class RetopoSession:
    """All that editing needs. ground: the whole one, whatever symmetry is. name: of the file that
    the surface came from, for titles."""

    ground: Ground
    state: State
    name: str = ""


def read_session(path: Path | str) -> RetopoSession:
    """The session in a file, bit for bit as it was written.

    Raises InvalidRetopoError that names the file and says what is wrong; OSError as reading does.
    """
    path = Path(path)
    with _named(path):
        return parse_session(read_limited(path, MAX_BYTES, InvalidRetopoError, "split the surface"))


def write_session(path: Path | str, session: RetopoSession) -> None:
    """Write a session; :func:`read_session` gives it back. OSError as writing does."""
    replace_file(Path(path), session_bytes(session))


def session_bytes(session: RetopoSession, surface: bytes | None = None) -> bytes:
    """The file of a session; the same session gives the same bytes.

    surface: what :func:`surface_bytes` gave for its ground, so that saving again and again need
    not pack it each time.
    """
    document, arrays = network_document(session.state.network)
    whole = {
        "format": FORMAT,
        "version": VERSION,
        "name": session.name,
        "sizes": asdict(session.state.sizes),
        "plane": None if session.state.plane is None else asdict(session.state.plane),
        "network": document,
    }
    text = json.dumps(whole, separators=(",", ":"), allow_nan=False)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        _add(archive, JSON_NAME, text.encode(), zipfile.ZIP_DEFLATED)
        # These are packed themselves.
        _add(archive, SURFACE_NAME, surface or surface_bytes(session.ground))
        _add(archive, NETWORK_NAME, _packed(arrays))
    return file.getvalue()


def surface_bytes(ground: Ground) -> bytes:
    """A ground's vertices and triangles, packed; see :func:`session_bytes`."""
    return _packed(
        {"vertices": ground.vertices.astype("<f8"), "triangles": ground.triangles.astype("<i4")}
    )


def parse_session(data: bytes) -> RetopoSession:
    """As :func:`read_session`, of a file's content; messages do not name a file."""
    content = _members(data, "a session of retopology")
    names = (JSON_NAME, SURFACE_NAME, NETWORK_NAME)
    if sorted(content) != sorted(names):
        there = ", ".join(sorted(content))[:200] or "nothing"
        raise InvalidRetopoError(
            f"this is no session of retopology: its zip has {there}; it must have "
            f"{', '.join(names)}"
        )
    document = parse_json(content[JSON_NAME], InvalidRetopoError, "a session")
    if document.is_object:
        head = document.entries()
        kind, version = (head[k].value if k in head else None for k in ("format", "version"))
        if (kind, version) != (FORMAT, VERSION):
            document.fail(f"the format is {kind!r} {version}; this reads {FORMAT!r} {VERSION}")
    entries = entries_of(document, KEYS)
    state = State(
        network_of(entries["network"], _arrays(content[NETWORK_NAME], NETWORK_ARRAYS)),
        _sizes(entries["sizes"]),
        _plane(entries["plane"]),
    )
    surface = _arrays(content[SURFACE_NAME], SURFACE_ARRAYS)
    try:
        ground = Ground.of(surface["vertices"], surface["triangles"])
    except PatternDBError as error:
        raise InvalidRetopoError(f"the surface: {error}") from None
    if len(ground.vertices) != len(surface["vertices"]) or ground.dropped:
        raise InvalidRetopoError(
            "the surface: vertices in one place, or triangles without an area, which no session has"
        )
    if state.plane is not None:
        try:
            cut_half(ground, state.plane)
        except PatternDBError as error:
            entries["plane"].fail(str(error))
    return RetopoSession(ground, state, entries["name"].text("the name of a mesh file"))


def _sizes(value: JsonValue) -> Sizes:
    names = tuple(field.name for field in fields(Sizes))
    entries = entries_of(value, names)
    try:
        return Sizes(*(entries[name].number() for name in names))
    except InvalidRetopoError as error:
        raise InvalidRetopoError(f"{value.where}: {error}") from None


def _plane(value: JsonValue) -> Plane | None:
    if value.value is None:
        return None
    entries = entries_of(value, ("point", "normal"))
    (x, y, z), (u, v, w) = (entries[name].point() for name in ("point", "normal"))
    try:
        return Plane((x, y, z), (u, v, w))
    except InvalidRetopoError as error:
        raise InvalidRetopoError(f"{value.where}: {error}") from None


def _packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            plain = io.BytesIO()
            np.lib.format.write_array(plain, np.ascontiguousarray(array), allow_pickle=False)
            _add(archive, f"{name}.npy", plain.getvalue(), zipfile.ZIP_DEFLATED)
    return file.getvalue()


def _arrays(data: bytes, wanted: Mapping[str, tuple[str, int]]) -> dict[str, NDArray[Any]]:
    """Arrays by name: of these types, with rows of so many, 0 for plain numbers."""
    content = _members(data, "an entry of a session")
    if sorted(content) != sorted(f"{name}.npy" for name in wanted):
        there = ", ".join(sorted(content))[:200] or "nothing"
        raise InvalidRetopoError(f"the session's arrays are {', '.join(wanted)}; it has {there}")
    found: dict[str, NDArray[Any]] = {}
    for name, (kind, row) in wanted.items():
        try:
            array = np.lib.format.read_array(io.BytesIO(content[f"{name}.npy"]), allow_pickle=False)
        except (ValueError, EOFError, OSError, MemoryError) as reason:
            raise InvalidRetopoError(f"the session's {name} are damaged: {reason}") from None
        if array.dtype.str != kind or array.shape[1:] != ((row,) if row else ()) or not array.ndim:
            raise InvalidRetopoError(
                f"the session's {name} must be {kind} in rows of {row or 1}, got "
                f"{array.dtype.str} {array.shape}"
            )
        found[name] = np.ascontiguousarray(array)
    return found


def _members(data: bytes, what: str) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len({one.filename for one in members}) < len(members):
                raise InvalidRetopoError(f"{what} has two entries of one name in its zip")
            if sum(one.file_size for one in members) > MAX_BYTES:
                raise InvalidRetopoError(f"{what} has more than {MAX_BYTES:,} bytes in its zip")
            return {one.filename: archive.read(one) for one in members}
    except InvalidRetopoError:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError) as reason:
        raise InvalidRetopoError(f"this is not {what}, which is a zip file: {reason}") from None
    except (RuntimeError, NotImplementedError, MemoryError) as reason:
        # An encrypted entry, a method of packing that is not known, a size that is a lie.
        raise InvalidRetopoError(f"this is not {what} that can be read: {reason}") from None


def _add(
    archive: zipfile.ZipFile, name: str, content: bytes, method: int = zipfile.ZIP_STORED
) -> None:
    # An entry without a date of its own is of 1980: the same session gives the same file.
    entry = zipfile.ZipInfo(name)
    entry.compress_type = method
    archive.writestr(entry, content, compresslevel=PACKING)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """What goes wrong inside is about a file."""
    try:
        yield
    except PatternDBError as error:
        raise InvalidRetopoError(f"{path}: {error}") from None
