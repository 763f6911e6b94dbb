"""How much a mesh file may ask of the reader."""

from __future__ import annotations

from dataclasses import dataclass

MIB = 2**20


@dataclass(frozen=True, slots=True)
class ReadLimits:
    """Bounds beyond which a file is refused, checked before memory is spent on it.

    max_bytes: size of the file, in bytes. 512 MiB is some five million quads of OBJ text
        with texture coordinates; what is larger is a scan or a mistake, not made by hand.
    max_line_bytes: length of a line of text (continued lines joined), and of a PLY header,
        in bytes. A face of 64 corners takes under 3 KiB; 1 MiB leaves room for any
        free-form element, and stops a binary file that was named ``.obj``.
    max_arity: corners of one face. Hand-made polygons have a handful, caps of cylinders
        up to 64; beyond, a face count was most likely read from the wrong place.
    max_library_seconds: time that VTK or USD may spend on a file. The largest file within
        max_bytes takes them some twenty seconds; damaged ones can keep them busy for ever.
    """

    max_bytes: int = 512 * MIB
    max_line_bytes: int = MIB
    max_arity: int = 64
    max_library_seconds: float = 60.0


DEFAULT_LIMITS = ReadLimits()
