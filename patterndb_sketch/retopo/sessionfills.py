"""Patches and their fills as documents of JSON and rows of arrays, as sessions keep them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.code import decode
from patterndb.core.disk import Disk
from patterndb.errors import InvalidCodeError, InvalidMeshError
from patterndb.system.documents import JsonValue
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import Choice, Filling, Flow
from patterndb_sketch.retopo.network import Patch

#: The arrays by name: their types, and the length of a row, 0 for plain numbers.
ARRAYS: dict[str, tuple[str, int]] = {
    "nodes": ("<f8", 6),
    "chains": ("<f8", 6),
    "quads": ("<i4", 4),
    "codes": ("<u2", 0),
    "lines": ("<f8", 3),
    "moved": ("<i4", 0),
    "places": ("<f8", 3),
}

PATCH_KEYS = ("id", "loop", "corners", "fill", "flows", "moved", "filling")
FILL_KEYS = (
    "lengths", "quads", "vertices", "code", "widths", "rotation", "mirrored", "origin",
    "irregular", "by",
)  # fmt: skip

#: Numbers are below this: they are kept as int32, and half-chains are twice a chain's id.
MOST = 2**30


@dataclass(slots=True)
class Taken:
    """Rows of the arrays, taken from front to back."""

    arrays: Mapping[str, NDArray[Any]]
    at: dict[str, int]

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self.arrays = arrays
        self.at = dict.fromkeys(ARRAYS, 0)

    def rows(self, name: str, count: JsonValue, least: int = 0) -> NDArray[Any]:
        """The next rows, as many as a value says."""
        return self.next(name, number(count, least=least), count)

    def next(self, name: str, n: int, where: JsonValue) -> NDArray[Any]:
        start = self.at[name]
        if start + n > len(self.arrays[name]):
            where.fail(f"the session has too few {name} for this: {len(self.arrays[name])}")
        self.at[name] += n
        rows = self.arrays[name][start : start + n]
        if rows.dtype.kind == "f" and not np.isfinite(rows).all():
            where.fail(f"there are {name} that are not finite")
        return rows

    def check_all(self) -> None:
        for name, at in self.at.items():
            if at < len(self.arrays[name]):
                raise InvalidRetopoError(
                    f"the session has {len(self.arrays[name])} {name}, and names {at} of them"
                )


def patch_document(patch: Patch, parts: dict[str, list[NDArray[Any]]]) -> dict[str, object]:
    filling = Filling() if patch.choice is None else patch.choice
    if not isinstance(filling, Filling):
        raise InvalidRetopoError(f"patch {patch.id} has a choice that is no Filling")
    flows = [flow.points for flow in filling.flows]
    parts["lines"] += flows
    which, places = filling.moved_vertices
    parts["moved"].append(which)
    parts["places"].append(places)
    fill: dict[str, object] | None = None
    if filling.choice is not None:
        choice = filling.choice
        code = np.frombuffer(choice.code, "<u2")
        parts["quads"].append(choice.faces)
        parts["codes"].append(code)
        fill = {
            "lengths": list(choice.lengths),
            "quads": len(choice.faces),
            "vertices": choice.n_vertices,
            "code": len(code),
            "widths": list(choice.widths),
            "rotation": choice.rotation,
            "mirrored": choice.mirrored,
            "origin": choice.origin,
            "irregular": choice.n_irregular,
            "by": choice.by,
        }
    return {
        "id": patch.id,
        "loop": list(patch.loop),
        "corners": list(patch.corners),
        "fill": fill,
        "flows": [len(points) for points in flows],
        "moved": len(which),
        # A patch that nothing was ever chosen for is not one whose choice was taken back.
        "filling": patch.choice is not None,
    }


def patch_of(value: JsonValue, take: Taken, chains: set[int]) -> Patch:
    entries = entries_of(value, PATCH_KEYS)
    loop, corners = numbers(entries["loop"]), numbers(entries["corners"])
    if not loop or not {half >> 1 for half in loop} <= chains:
        entries["loop"].fail("a patch has half-chains of chains that are there")
    if corners[:1] != (0,) or list(corners) != sorted({*corners}) or corners[-1] >= len(loop):
        entries["corners"].fail("corners are ascending places in the loop, the first is 0")
    flows = tuple(Flow.of(take.rows("lines", one, least=2)) for one in entries["flows"].items())
    which = take.rows("moved", entries["moved"])
    places = take.next("places", len(which), entries["moved"])
    choice: Choice | None = None
    if entries["fill"].value is not None:
        choice = _choice(entries["fill"], take, len(corners))
    n_vertices = 0 if choice is None else choice.n_vertices
    if len(which) and not 0 <= which.min() <= which.max() < n_vertices:
        entries["moved"].fail(f"moved vertices are 0..{n_vertices - 1}, those of the fill")
    filling = Filling(choice, flows).with_moved(which, places)
    if not entries["filling"].truth():
        if filling != Filling():
            entries["filling"].fail("it is false, and the patch has a fill, a line or a place")
        return Patch(number(entries["id"]), loop, corners)
    return Patch(number(entries["id"]), loop, corners, filling)


def _choice(value: JsonValue, take: Taken, n_sides: int) -> Choice:
    entries = entries_of(value, FILL_KEYS)
    lengths = numbers(entries["lengths"], least=1)
    if len(lengths) != n_sides:
        entries["lengths"].fail(f"the patch has {n_sides} sides")
    quads = take.rows("quads", entries["quads"], least=1)
    n_vertices = number(entries["vertices"])
    if not disk_within(quads, n_vertices, sum(lengths)):
        entries["quads"].fail("the quads do not fill the patch: they are no disk in its boundary")
    code = take.rows("codes", entries["code"], least=1)
    try:
        Disk.from_twin(decode(code))
    except (InvalidCodeError, InvalidMeshError) as error:
        entries["code"].fail(str(error))
    by = entries["by"].text()
    if by not in ("program", "user"):
        entries["by"].refuse('"program" or "user"')
    return Choice(
        lengths,
        np.ascontiguousarray(quads, "<i4").tobytes(),
        n_vertices,
        code.tobytes(),
        numbers(entries["widths"]),
        number(entries["rotation"]),
        entries["mirrored"].truth(),
        entries["origin"].text(),
        number(entries["irregular"]),
        "program" if by == "program" else "user",
    )


def disk_within(quads: NDArray[Any], n_vertices: int, perimeter: int) -> bool:
    """Are these quads (q, 4) one disk, all of the vertices 0..n - 1 its own, whose boundary is
    0..P - 1 counter-clockwise?"""
    if not 4 <= perimeter <= n_vertices or quads.min() < 0 or quads.max() >= n_vertices:
        return False
    tail, head = quads.ravel().astype(np.int64), np.roll(quads, -1, axis=1).ravel().astype(np.int64)
    there = np.unique(tail * n_vertices + head)
    if len(there) < len(tail) or len(np.unique(tail)) < n_vertices or (tail == head).any():
        return False
    back = head * n_vertices + tail
    lone = ~np.isin(back, there)
    if lone.sum() != perimeter or not (head[lone] == (tail[lone] + 1) % perimeter).all():
        return False
    edges = (len(tail) + perimeter) // 2
    return n_vertices - edges + len(quads) == 1 and _connected(tail, head, n_vertices)


def _connected(tail: NDArray[np.int64], head: NDArray[np.int64], n: int) -> bool:
    graph = coo_array((np.ones(len(tail), np.int8), (tail, head)), shape=(n, n))
    return connected_components(graph, directed=False)[0] == 1


def entries_of(value: JsonValue, keys: tuple[str, ...]) -> dict[str, JsonValue]:
    entries = value.entries(keys)
    for key in keys:
        if key not in entries:
            value.fail(f'"{key}" is missing; there must be {", ".join(keys)}')
    return entries


def number(value: JsonValue, least: int = 0, most: int = MOST) -> int:
    found = value.whole()
    if not least <= found <= most:
        value.refuse(f"a whole number from {least} to {most}")
    return found


def numbers(value: JsonValue, least: int = 0) -> tuple[int, ...]:
    return tuple(number(one, least, 2 * MOST + 1) for one in value.items())
