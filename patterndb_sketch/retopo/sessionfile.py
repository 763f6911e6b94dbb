"""Sessions of retopology as files: the surface, the curves, counts, fills and sizes.

A session is one zip file of three entries:

- session.json: {"format": "patterndb retopology session", "version": 1, "name": "spot.obj",
  "sizes": {"snap": 0.04, ...}, "plane": null, "network": ...}, the plane of symmetry as
  {"point": [0, 0, 0], "normal": [1, 0, 0]} while that is on. The network has what nodes, chains
  and patches are, in the order in which the network has them, and, where density is painted, the
  strokes of the brush: {"segments": [[...]], "radius": 0.1, "factor": 2, "sets": false}, a segment
  being nine numbers, where it begins and ends and the normal there;
- surface.npz: vertices (v, 3) float64 and triangles (t, 3) int32 of the surface;
- network.npz: the points of the network, one after another in the same order. nodes (n, 6),
  chains (s, 6): points and normals of nodes, and of the samples of all chains. quads (q, 4): of
  the fills of all patches; codes (c,): their patterns' codes. lines (l, 3): points of flow lines.
  moved (m,), places (m, 3): vertices moved by hand.

The history of undo is not part of it. To read first: the declared entries, then
:func:`parse_session`, then :func:`_network`.
"""

from __future__ import annotations

import io
import json
import math
import time
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta, field, structs
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.code import decode
from patterndb.core.disk import Disk
from patterndb.errors import InvalidCodeError, InvalidMeshError, PatternDBError
from patterndb.geometry.surface import Surface
from patterndb.system.archives import read_array, read_members
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    Point,
    complete_points,
    name_file,
    parse_json,
    read_limited,
)
from patterndb.system.files import replace_file
from patterndb_sketch.autosave import EVERY, Autosave
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import Choice, Filling, Flow
from patterndb_sketch.retopo.network import (
    NONE,
    BrokenNetworkError,
    BrushStroke,
    Chain,
    Density,
    Network,
    Node,
    Patch,
    check_network,
)
from patterndb_sketch.retopo.network.density import LEAST
from patterndb_sketch.retopo.network.density import MOST as MOST_DENSE
from patterndb_sketch.retopo.network.invariants import UNIT
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.state import State
from patterndb_sketch.retopo.symmetry import Plane, cut_half

#: How the name of a session's file ends.
SUFFIX = ".retopo"

#: Bytes that a session may have, packed or not: a surface of some 20 million triangles.
MAX_BYTES = 1_000_000_000

FORMAT, VERSION = "patterndb retopology session", 1
JSON_NAME, SURFACE_NAME, NETWORK_NAME = "session.json", "surface.npz", "network.npz"
SURFACE_ARRAYS = {"vertices": ("<f8", 3), "triangles": ("<i4", 3)}

#: How hard arrays are packed: coordinates hardly get smaller by more, and it takes thrice as long.
PACKING = 1

#: The arrays of the network by name: their types, and the length of a row, 0 for plain numbers.
NETWORK_ARRAYS: dict[str, tuple[str, int]] = {
    "nodes": ("<f8", 6),
    "chains": ("<f8", 6),
    "quads": ("<i4", 4),
    "codes": ("<u2", 0),
    "lines": ("<f8", 3),
    "moved": ("<i4", 0),
    "places": ("<f8", 3),
}

#: Numbers are below this: they are kept as int32, and half-chains are twice a chain's id.
MOST = 2**30

# The entries of session.json.

Id = Annotated[int, Meta(ge=0, le=MOST)]
End = Annotated[int, Meta(ge=NONE, le=MOST)]
Half = Annotated[int, Meta(ge=0, le=2 * MOST + 1)]
Length = Annotated[int, Meta(ge=1, le=2 * MOST + 1)]
SomeRows = Annotated[int, Meta(ge=1, le=MOST)]
LineRows = Annotated[int, Meta(ge=2, le=MOST)]
Marks = Annotated[
    tuple[str, str], Meta(extra={"length": "a chain has two marks, of its left and its right"})
]


SEGMENT = "a segment has nine numbers: where it begins and ends, and the normal"


class NodeEntries(JsonModel):
    id: Id
    ends: list[Half]
    flagged: list[bool]
    cut: bool


class ChainEntries(JsonModel):
    id: Id
    start: End
    end: End
    samples: LineRows
    count: Id
    pinned: bool
    marks: Marks
    laid: bool = False


class FillEntries(JsonModel):
    """quads, code: how many rows of the arrays are its own."""

    lengths: list[Length]
    quads: SomeRows
    vertices: Id
    code: SomeRows
    widths: list[Half]
    rotation: Id
    mirrored: bool
    origin: str
    irregular: Id
    by: Literal["program", "user"]


class PatchEntries(JsonModel):
    """flows, moved: how many rows of the arrays are its own, of every flow line.

    filling: a patch that nothing was ever chosen for is not one whose choice was taken back.
    """

    id: Id
    loop: list[Half]
    corners: list[Half]
    fill: FillEntries | None
    flows: list[LineRows]
    moved: Id
    filling: bool


class BrushEntries(JsonModel):
    """A stroke of the brush that paints density."""

    segments: Annotated[
        list[Annotated[list[Number], Meta(min_length=9, max_length=9, extra={"length": SEGMENT})]],
        Meta(min_length=1, extra={"length": "a brush stroke has a segment or more"}),
    ]
    radius: Number
    factor: Number
    sets: bool


class NetworkEntries(JsonModel):
    next_id: Id
    longest: Number | None
    nodes: list[NodeEntries]
    chains: list[ChainEntries]
    patches: list[PatchEntries]
    density: list[BrushEntries] = field(default_factory=list)


class PlaneEntries(JsonModel):
    point: Point
    normal: Point


class SizesEntries(JsonModel):
    snap: Number
    spine: Number
    autocompletion: Number
    brush: Number
    edge: Number
    sampling: Number


class SessionEntries(JsonModel):
    format: str
    version: int
    name: Annotated[str, Meta(description="the name of a mesh file")]
    sizes: SizesEntries
    plane: PlaneEntries | None
    network: NetworkEntries


@dataclass(frozen=True, slots=True, eq=False)
class RetopoSession:
    """All that editing needs. surface: the whole one, whatever symmetry is. name: of the file that
    the surface came from, for titles."""

    surface: Surface
    state: State
    name: str = ""


def read_session(path: Path | str) -> RetopoSession:
    """The session in a file, bit for bit as it was written.

    Raises InvalidRetopoError that names the file and says what is wrong; OSError as reading does.
    """
    path = Path(path)
    with name_file(path, InvalidRetopoError):
        return parse_session(read_limited(path, MAX_BYTES, InvalidRetopoError, "split the surface"))


def write_session(path: Path | str, session: RetopoSession) -> None:
    """Write a session; :func:`read_session` gives it back. OSError as writing does."""
    replace_file(Path(path), session_bytes(session))


def session_bytes(session: RetopoSession, packed: bytes | None = None) -> bytes:
    """The file of a session; the same session gives the same bytes.

    packed: what :func:`surface_bytes` gave for its surface, so that saving again and again need
    not pack it each time.
    """
    document, arrays = _network_document(session.state.network)
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
        _add(archive, SURFACE_NAME, packed or surface_bytes(session.surface))
        _add(archive, NETWORK_NAME, _packed(arrays))
    return file.getvalue()


def surface_bytes(surface: Surface) -> bytes:
    """A surface's vertices and triangles, packed; see :func:`session_bytes`."""
    return _packed(
        {"vertices": surface.vertices.astype("<f8"), "triangles": surface.triangles.astype("<i4")}
    )


def autosave_session(
    surface: Surface,
    state: State,
    *,
    session: Path | None = None,
    base: str = "",
    folder: Path | None = None,
    name: str = "",
    every: float = EVERY,
    clock: Callable[[], float] = time.monotonic,
) -> Autosave[State]:
    """Keep the states of an editor in case of a crash; name: of the surface's file, else as for
    :class:`patterndb_sketch.autosave.Autosave`."""
    packed = cache(lambda: surface_bytes(surface))

    def encode(state: State) -> bytes:
        return session_bytes(RetopoSession(surface, state, name), packed())

    return Autosave(
        encode,
        state,
        session=session,
        base=base,
        folder=folder,
        same=State.same,
        every=every,
        clock=clock,
    )


def parse_session(data: bytes) -> RetopoSession:
    """As :func:`read_session`, of a file's content; messages do not name a file."""
    content = read_members(data, InvalidRetopoError, "a session of retopology", max_bytes=MAX_BYTES)
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
    entries = document.read(SessionEntries)
    place = document.at("network")
    network = _network(place, entries.network, _arrays(content[NETWORK_NAME], NETWORK_ARRAYS))
    try:
        sizes = Sizes(**structs.asdict(entries.sizes))
    except InvalidRetopoError as error:
        document.at("sizes").fail(str(error))
    state = State(network, sizes, _plane(document.at("plane"), entries.plane))
    arrays = _arrays(content[SURFACE_NAME], SURFACE_ARRAYS)
    try:
        surface = Surface.from_arrays(arrays["vertices"], arrays["triangles"]).orient()
    except PatternDBError as error:
        raise InvalidRetopoError(f"the surface: {error}") from None
    if len(surface.vertices) != len(arrays["vertices"]) or surface.repairs.dropped:
        raise InvalidRetopoError(
            "the surface: vertices in one place, or triangles without an area, which no session has"
        )
    if state.plane is not None:
        try:
            cut_half(surface, state.plane)
        except PatternDBError as error:
            document.at("plane").fail(str(error))
    return RetopoSession(surface, state, entries.name)


def _plane(place: JsonValue, entries: PlaneEntries | None) -> Plane | None:
    if entries is None:
        return None
    (x, y, z), (u, v, w) = complete_points([entries.point, entries.normal])
    try:
        return Plane((x, y, z), (u, v, w))
    except InvalidRetopoError as error:
        place.fail(str(error))


def _network(
    place: JsonValue, entries: NetworkEntries, arrays: Mapping[str, NDArray[Any]]
) -> Network:
    """Return the network of the entries at a place and its arrays.

    Raises InvalidRetopoError that names the place where rows are too few or too many, and where
    the invariants of networks do not hold.
    """
    rows = _SessionRows(arrays)
    nodes = [_node(place.at("nodes", i), one, rows) for i, one in enumerate(entries.nodes)]
    chains = [_chain(place.at("chains", i), one, rows) for i, one in enumerate(entries.chains)]
    ids = {node.id for node in nodes} | {NONE}
    for i, chain in enumerate(chains):
        if not {chain.start, chain.end} <= ids:
            place.at("chains", i).fail(f"there is no node {chain.start} or {chain.end}")
    there = {chain.id for chain in chains}
    halves = {2 * chain + side for chain in there for side in (0, 1)}
    for i, node in enumerate(nodes):
        if not set(node.ends) <= halves:
            place.at("nodes", i).fail(f"there is no half-chain {min(set(node.ends) - halves)}")
    patches = [
        _patch(place.at("patches", i), one, rows, there) for i, one in enumerate(entries.patches)
    ]
    rows.check_all()
    network = Network(
        {node.id: node for node in nodes},
        {chain.id: chain for chain in chains},
        {patch.id: patch for patch in patches},
        entries.next_id,
        math.inf if entries.longest is None else entries.longest,
        density=Density(
            tuple(
                _brush_stroke(place.at("density", i), one) for i, one in enumerate(entries.density)
            )
        ),
    )
    if sum(map(len, (nodes, chains, patches))) > sum(
        map(len, (network.nodes, network.chains, network.patches))
    ):
        place.fail("an id is used twice")
    try:
        # Patches stay as they are while chains move: not every loop need be one.
        check_network(network, patches=False)
    except BrokenNetworkError as error:
        place.fail(f"{error}; the file was changed, or a fault wrote it")
    return network


def _node(place: JsonValue, entries: NodeEntries, rows: _SessionRows) -> Node:
    row = rows.take("nodes", 1, place)[0]
    ends, flagged = tuple(entries.ends), tuple(entries.flagged)
    return Node(entries.id, row[:3].copy(), row[3:].copy(), ends, flagged, entries.cut)


def _chain(place: JsonValue, entries: ChainEntries, rows: _SessionRows) -> Chain:
    found = rows.take("chains", entries.samples, place.at("samples"))
    return Chain(
        entries.id,
        entries.start,
        entries.end,
        np.ascontiguousarray(found[:, :3]),
        np.ascontiguousarray(found[:, 3:]),
        entries.count,
        entries.pinned,
        entries.marks,
        entries.laid,
    )


def _patch(place: JsonValue, entries: PatchEntries, rows: _SessionRows, chains: set[int]) -> Patch:
    loop, corners = tuple(entries.loop), tuple(entries.corners)
    if not loop or not {half >> 1 for half in loop} <= chains:
        place.at("loop").fail("a patch has half-chains of chains that are there")
    if corners[:1] != (0,) or list(corners) != sorted({*corners}) or corners[-1] >= len(loop):
        place.at("corners").fail("corners are ascending places in the loop, the first is 0")
    flows = tuple(
        Flow.of(rows.take("lines", n, place.at("flows", i))) for i, n in enumerate(entries.flows)
    )
    which, places = (
        rows.take(name, entries.moved, place.at("moved")) for name in ("moved", "places")
    )
    choice: Choice | None = None
    if entries.fill is not None:
        choice = _choice(place.at("fill"), entries.fill, rows, len(corners))
    n_vertices = 0 if choice is None else choice.n_vertices
    if len(which) and not 0 <= which.min() <= which.max() < n_vertices:
        place.at("moved").fail(f"moved vertices are 0..{n_vertices - 1}, those of the fill")
    filling = Filling(choice, flows).with_moved(which, places)
    if entries.filling:
        return Patch(entries.id, loop, corners, filling)
    if filling != Filling():
        place.at("filling").fail("it is false, and the patch has a fill, a line or a place")
    return Patch(entries.id, loop, corners)


def _brush_stroke(place: JsonValue, entries: BrushEntries) -> BrushStroke:
    rows = np.array(entries.segments, np.float64)
    if not entries.radius > 0.0:
        place.at("radius").fail("the radius of a brush is above 0")
    if not LEAST <= entries.factor <= MOST_DENSE:
        place.at("factor").fail(f"a brush changes density by {LEAST:g} to {MOST_DENSE:g}")
    if not (abs(np.linalg.norm(rows[:, 6:], axis=1) - 1.0) <= UNIT).all():
        place.at("segments").fail("a normal has not length 1")
    starts, ends, normals = (np.ascontiguousarray(rows[:, k : k + 3]) for k in (0, 3, 6))
    return BrushStroke(starts, ends, normals, entries.radius, entries.factor, entries.sets)


def _choice(place: JsonValue, entries: FillEntries, rows: _SessionRows, n_sides: int) -> Choice:
    if len(entries.lengths) != n_sides:
        place.at("lengths").fail(f"the patch has {n_sides} sides")
    quads = rows.take("quads", entries.quads, place.at("quads"))
    if not disk_within(quads, entries.vertices, sum(entries.lengths)):
        place.at("quads").fail("the quads do not fill the patch: they are no disk in its boundary")
    code = rows.take("codes", entries.code, place.at("code"))
    try:
        Disk.from_twin(decode(code))
    except (InvalidCodeError, InvalidMeshError) as error:
        place.at("code").fail(str(error))
    return Choice(
        tuple(entries.lengths),
        np.ascontiguousarray(quads, "<i4").tobytes(),
        entries.vertices,
        code.tobytes(),
        tuple(entries.widths),
        entries.rotation,
        entries.mirrored,
        entries.origin,
        entries.irregular,
        entries.by,
    )


class _SessionRows:
    """Rows of the arrays, taken from front to back."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self.arrays = arrays
        self.at = dict.fromkeys(NETWORK_ARRAYS, 0)

    def take(self, name: str, n: int, place: JsonValue) -> NDArray[Any]:
        """Return the next n rows; place: what asks for them, for messages."""
        start = self.at[name]
        if start + n > len(self.arrays[name]):
            place.fail(f"the session has too few {name} for this: {len(self.arrays[name])}")
        self.at[name] += n
        rows = self.arrays[name][start : start + n]
        if rows.dtype.kind == "f" and not np.isfinite(rows).all():
            place.fail(f"there are {name} that are not finite")
        return rows

    def check_all(self) -> None:
        """Raise InvalidRetopoError for rows that nothing took."""
        for name, at in self.at.items():
            if at < len(self.arrays[name]):
                raise InvalidRetopoError(
                    f"the session has {len(self.arrays[name])} {name}, and names {at} of them"
                )


def _network_document(network: Network) -> tuple[dict[str, object], dict[str, NDArray[Any]]]:
    """Return a network's document and arrays; :func:`_network` gives it back bit for bit.

    Raises InvalidRetopoError for a patch whose choice is no Filling.
    """
    parts: dict[str, list[NDArray[Any]]] = {name: [] for name in NETWORK_ARRAYS}
    for node in network.nodes.values():
        parts["nodes"].append(np.concatenate([node.point, node.normal])[None])
    for chain in network.chains.values():
        parts["chains"].append(np.concatenate([chain.points, chain.normals], axis=1))
    document: dict[str, object] = {
        "next_id": network.next_id,
        "longest": network.longest if math.isfinite(network.longest) else None,
        "nodes": [
            structs.asdict(NodeEntries(node.id, list(node.ends), list(node.flagged), node.cut))
            for node in network.nodes.values()
        ],
        "chains": [
            {
                "id": chain.id,
                "start": chain.start,
                "end": chain.end,
                "samples": len(chain.points),
                "count": chain.count,
                "pinned": chain.pinned,
                "marks": list(chain.marks),
                # As before where nothing was drafted: older programs read it.
                **({"laid": True} if chain.laid else {}),
            }
            for chain in network.chains.values()
        ],
        "patches": [_patch_document(patch, parts) for patch in network.patches.values()],
    }
    if network.density.strokes:
        document["density"] = [
            {
                "segments": np.hstack([one.starts, one.ends, one.normals]).tolist(),
                "radius": one.radius,
                "factor": one.factor,
                "sets": one.sets,
            }
            for one in network.density.strokes
        ]
    return document, {name: _joined(parts[name], *NETWORK_ARRAYS[name]) for name in NETWORK_ARRAYS}


def _patch_document(patch: Patch, parts: dict[str, list[NDArray[Any]]]) -> dict[str, object]:
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
        "filling": patch.choice is not None,
    }


def _joined(parts: list[NDArray[Any]], kind: str, row: int) -> NDArray[Any]:
    empty = np.empty((0, row) if row else 0, kind)
    return np.ascontiguousarray(np.concatenate([empty, *parts]), kind)


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
    content = read_members(data, InvalidRetopoError, "an entry of a session", max_bytes=MAX_BYTES)
    if sorted(content) != sorted(f"{name}.npy" for name in wanted):
        there = ", ".join(sorted(content))[:200] or "nothing"
        raise InvalidRetopoError(f"the session's arrays are {', '.join(wanted)}; it has {there}")
    found: dict[str, NDArray[Any]] = {}
    for name, (kind, row) in wanted.items():
        array = read_array(content[f"{name}.npy"], InvalidRetopoError, f"the session's {name}")
        if array.dtype.str != kind or array.shape[1:] != ((row,) if row else ()) or not array.ndim:
            raise InvalidRetopoError(
                f"the session's {name} must be {kind} in rows of {row or 1}, got "
                f"{array.dtype.str} {array.shape}"
            )
        found[name] = np.ascontiguousarray(array)
    return found


def _add(
    archive: zipfile.ZipFile, name: str, content: bytes, method: int = zipfile.ZIP_STORED
) -> None:
    # An entry without a date of its own is of 1980: the same session gives the same file.
    entry = zipfile.ZipInfo(name)
    entry.compress_type = method
    archive.writestr(entry, content, compresslevel=PACKING)
