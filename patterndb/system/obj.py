"""The lines of an OBJ file: what all that write meshes have in common.

Every coordinate is written by its shortest text that reads back as the same number.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray


def format_obj(
    points: NDArray[Any],
    faces: Iterable[Sequence[int]],
    *,
    comments: Iterable[str] = (),
    groups: Sequence[str] = (),
) -> str:
    """Return the text of an OBJ file.

    points: (v, 3). faces: vertices from 0, or a (q, k) array. comments: lines at its head.
    groups: the name of a group for each face; a group begins wherever it changes.
    """
    lines = [*(f"# {comment}" for comment in comments), *vertex_lines(points)]
    for number, line in enumerate(face_lines(faces)):
        if groups and (not number or groups[number] != groups[number - 1]):
            lines.append(f"g {groups[number]}")
        lines.append(line)
    return join_lines(lines)


def vertex_lines(points: NDArray[Any]) -> list[str]:
    """Return a line ``v x y z`` for each of (v, 3) points."""
    return [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]


def face_lines(faces: Iterable[Sequence[int]]) -> list[str]:
    """Return a line ``f a b c ...`` for each face, of vertices that count from 0 here."""
    return ["f " + " ".join([str(vertex + 1) for vertex in face]) for face in faces]


def join_lines(lines: Iterable[str]) -> str:
    """Return the lines as the text of a file."""
    return "\n".join(lines) + "\n"
