"""Surfaces that clients have sent: kept in memory for a while, under the hash of their bytes."""

from __future__ import annotations

import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from ingest.formats import FORMATS, ReadLimits, find_format, parse
from patterndb.errors import NotFoundError, UnsupportedFormatError
from patterndb.geometry.surface import Surface
from patterndb_app.service.refusals import LargeRequestError

#: Bytes that a surface takes for each triangle and vertex, its tree of boxes included: measured as
#: 170 and 60 on surfaces of 10,000 to 1,000,000 triangles, and rounded up.
TRIANGLE_BYTES = 200
VERTEX_BYTES = 80


@dataclass(slots=True)
class KeptSurface:
    """A surface, what it has and takes, and when it was last used (of the cache's clock)."""

    id: str
    surface: Surface
    n_vertices: int
    n_faces: int
    size: int
    used: float


class SurfaceCache:
    """The surfaces of a service, those unused for longest given up first."""

    def __init__(
        self, most_bytes: int, seconds: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """most_bytes: of all of them. seconds: that each is kept after its last use."""
        self._most = most_bytes
        self._seconds = seconds
        self._clock = clock
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, KeptSurface] = OrderedDict()

    @property
    def size(self) -> int:
        """Bytes that all of them take."""
        with self._lock:
            return sum(one.size for one in self._kept.values())

    def __len__(self) -> int:
        with self._lock:
            return len(self._kept)

    def add(self, data: bytes, suffix: str, limits: ReadLimits) -> KeptSurface:
        """Keep the surface in the bytes of a mesh file; suffix: of its format, as ".obj".

        Raises MeshFileError for what is no such file, LargeRequestError for one that alone takes
        more memory than there is for all.
        """
        number = hashlib.sha256(data).hexdigest()
        known = self._take(number)
        if known is not None:
            return known
        mesh = parse(data, f"surface{suffix}", limits)
        size = len(mesh.corners) * TRIANGLE_BYTES + len(mesh.points) * VERTEX_BYTES
        if size > self._most:
            raise LargeRequestError(
                f"a surface of {mesh.n_faces:,} faces takes {size:,} bytes; {self._most:,} are "
                "kept in all; send one of fewer faces"
            )
        surface = Surface.from_polygons(mesh)
        kept = KeptSurface(number, surface, len(mesh.points), mesh.n_faces, size, self._clock())
        with self._lock:
            self._kept[number] = kept
            self._kept.move_to_end(number)
            self._give_up()
        return kept

    def find(self, number: str) -> KeptSurface:
        """The surface of an id; raises NotFoundError where it is not kept any more."""
        found = self._take(number)
        if found is None:
            raise NotFoundError(f"no surface {number} is kept here; send it again to /v1/surfaces")
        return found

    def remaining(self, kept: KeptSurface) -> float:
        """Seconds that a surface is kept if it is not used again."""
        return max(0.0, kept.used + self._seconds - self._clock())

    def _take(self, number: str) -> KeptSurface | None:
        with self._lock:
            self._give_up()
            found = self._kept.get(number)
            if found is not None:
                found.used = self._clock()
                self._kept.move_to_end(number)
            return found

    def _give_up(self) -> None:
        """Give up those that are too old, then those unused for longest until the rest fits."""
        oldest = self._clock() - self._seconds
        size = sum(one.size for one in self._kept.values())
        for number, one in list(self._kept.items()):
            if one.used >= oldest and size <= self._most:
                break
            del self._kept[number]
            size -= one.size


#: Suffixes by the media types that mesh files are sent with.
MEDIA_TYPES = {
    "model/obj": ".obj",
    "application/ply": ".ply",
    "model/ply": ".ply",
    "model/off": ".off",
}


def find_suffix(media_type: str, name: str | None, data: bytes) -> str:
    """Find of which format a mesh file that was sent is: by its name, its type, or its beginning.

    Raises UnsupportedFormatError for formats that are not read from bytes alone.
    """
    suffix = MEDIA_TYPES.get(media_type, "")
    if name and "." in name:
        suffix = f".{name.rpartition('.')[2].lower()}"
    if not suffix:
        start = data[:64].lstrip().lower()
        suffix = ".ply" if start.startswith(b"ply") else ".off" if _is_off(start) else ".obj"
    format = find_format(f"mesh{suffix}")
    if not format.from_bytes:
        known = ", ".join(one.suffixes[0] for one in FORMATS if one.from_bytes)
        raise UnsupportedFormatError(
            f"{format.name} is not read here; send {known}", path=f"mesh{suffix}"
        )
    return suffix


def _is_off(start: bytes) -> bool:
    return b"off" in start.split(None, 1)[0] if start else False
