"""Sessions of retopology: the surface, the curves, their counts, fills and density, the sizes.

The content of the file is :class:`SavedRetopology`; :mod:`patterndb_sketch.sessions` reads and
writes it. The history of undo is not part of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.code import decode
from patterndb.core.disk import Disk
from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidCodeError, InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb.system.documents import JsonModel, JsonValue
from patterndb_sketch.recovery import Autosave
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import Choice, Filling
from patterndb_sketch.retopo.network import (
    BrokenNetworkError,
    Chain,
    Density,
    Network,
    Node,
    Paint,
    Patch,
    check_network,
)
from patterndb_sketch.retopo.network.density import LEAST, MOST
from patterndb_sketch.retopo.network.invariants import UNIT
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Plane, cut_half
from patterndb_sketch.retopo.tool import State
from patterndb_sketch.sessions import SessionFormat

#: How the name of a session's file ends.
SUFFIX = ".retopo"

#: Numbers are at most this: half-chains, twice a chain's id, are kept in 32 bits.
MOST_NUMBER = 2**30


class SavedPatch(JsonModel):
    """A patch; filling: None where nothing was ever chosen for it."""

    id: int
    loop: tuple[int, ...]
    corners: tuple[int, ...]
    filling: Filling | None


class SavedNetwork(JsonModel):
    """A network, in its own order; longest: None for a limit without end."""

    nodes: list[Node]
    chains: list[Chain]
    patches: list[SavedPatch]
    next_id: int
    longest: float | None
    density: Density


class SavedRetopology(JsonModel):
    """What a session has. vertices (v, 3) and triangles (t, 3): the whole surface."""

    name: Annotated[str, Meta(description="the name of a mesh file")]
    vertices: Points
    triangles: Int32Array
    sizes: Sizes
    plane: Plane | None
    network: SavedNetwork


@dataclass(frozen=True, slots=True, eq=False)
class RetopoSession:
    """All that editing needs. surface: the whole one, whatever symmetry is. name: of the file that
    the surface came from, for titles."""

    surface: Surface
    state: State
    name: str = ""


def _save(session: RetopoSession) -> SavedRetopology:
    """Return what a file has; raises InvalidRetopoError for a choice that is not a Filling."""
    network = session.state.network
    return SavedRetopology(
        session.name,
        session.surface.vertices,
        session.surface.triangles,
        session.state.sizes,
        session.state.plane,
        SavedNetwork(
            list(network.nodes.values()),
            list(network.chains.values()),
            [_save_patch(patch) for patch in network.patches.values()],
            network.next_id,
            network.longest if math.isfinite(network.longest) else None,
            network.density,
        ),
    )


def _save_patch(patch: Patch) -> SavedPatch:
    if not isinstance(patch.choice, Filling | None):
        raise InvalidRetopoError(f"patch {patch.id} has a choice that is not a Filling")
    return SavedPatch(patch.id, patch.loop, patch.corners, patch.choice)


def _open(saved: SavedRetopology, place: JsonValue) -> RetopoSession:
    """Return the session that a file has; raises InvalidRetopoError with the place in it."""
    network = _open_network(saved.network, place.at("network"))
    with place.at("vertices").named():
        surface = Surface.from_arrays(saved.vertices, saved.triangles).orient()
    if len(surface.vertices) != len(saved.vertices) or surface.repairs.dropped:
        place.at("vertices").fail("vertices in one place, or triangles without an area")
    if saved.plane is not None:
        with place.at("plane").named():
            cut_half(surface, saved.plane)
    return RetopoSession(surface, State(network, saved.sizes, saved.plane), saved.name)


RETOPO_SESSION: SessionFormat[RetopoSession, SavedRetopology] = SessionFormat(
    "retopology", InvalidRetopoError, SavedRetopology, _save, _open
)


def autosave_session(begun: RetopoSession, **options: Any) -> Autosave[State]:
    """Return an autosave of an editor's states, of which ``begun`` has the first.

    options: as for :class:`patterndb_sketch.recovery.Autosave`.
    """

    def encode(state: State) -> bytes:
        return RETOPO_SESSION.encode(RetopoSession(begun.surface, state, begun.name))

    return Autosave(encode, begun.state, same=State.same, **options)


def _open_network(saved: SavedNetwork, place: JsonValue) -> Network:
    """Return a network whose invariants hold; raises InvalidRetopoError with the place."""
    network = Network(
        {node.id: node for node in saved.nodes},
        {chain.id: chain for chain in saved.chains},
        {one.id: Patch(one.id, one.loop, one.corners, one.filling) for one in saved.patches},
        saved.next_id,
        math.inf if saved.longest is None else saved.longest,
        density=saved.density,
    )
    kept = len(network.nodes) + len(network.chains) + len(network.patches)
    if kept < len(saved.nodes) + len(saved.chains) + len(saved.patches):
        place.fail("an id is used twice")
    if not 0 <= saved.next_id <= MOST_NUMBER:
        place.at("next_id").fail(f"it must be 0 to {MOST_NUMBER}")
    for i, node in enumerate(saved.nodes):
        if not node.point.shape == node.normal.shape == (3,):
            place.at("nodes", i).fail("its point and its normal must have 3 numbers")
    for i, chain in enumerate(saved.chains):
        if chain.count > MOST_NUMBER:
            place.at("chains", i, "count").fail(f"it must be at most {MOST_NUMBER}")
        if chain.points.ndim != 2 or chain.normals.ndim != 2:
            place.at("chains", i).fail("points and normals must be lists of [x, y, z]")
    for i, stroke in enumerate(saved.density.strokes):
        _check_brush(stroke, place.at("density", "strokes", i))
    for i, one in enumerate(saved.patches):
        _check_patch(one, network, place.at("patches", i))
    try:
        # Patches stay as they are while chains move: not every loop need be one.
        check_network(network, patches=False)
    except BrokenNetworkError as error:
        place.fail(f"{error}; the file was changed, or a fault wrote it")
    return network


def _check_brush(stroke: Paint, place: JsonValue) -> None:
    shape = (len(stroke.starts), 3)
    if not stroke.starts.shape == stroke.ends.shape == stroke.normals.shape == shape != (0, 3):
        place.fail("a brush stroke needs a segment or more: starts, ends and normals [x, y, z]")
    if not (abs(np.linalg.norm(stroke.normals, axis=1) - 1.0) <= UNIT).all():
        place.at("normals").fail("a normal has not length 1")
    if not stroke.radius > 0.0:
        place.at("radius").fail("the radius of a brush must be above 0")
    if not LEAST <= stroke.factor <= MOST:
        place.at("factor").fail(f"a brush changes density by {LEAST:g} to {MOST:g}")


def _check_patch(patch: SavedPatch, network: Network, place: JsonValue) -> None:
    loop, corners, filling = patch.loop, patch.corners, patch.filling
    if not loop or not {half >> 1 for half in loop} <= network.chains.keys():
        place.at("loop").fail("a patch needs half-chains, of chains in the file")
    if corners[:1] != (0,) or list(corners) != sorted({*corners}) or corners[-1] >= len(loop):
        place.at("corners").fail("corners are ascending places in the loop, the first is 0")
    if filling is None:
        return
    place = place.at("filling")
    try:
        which, places = filling.moved_vertices
        lines = [flow.points for flow in filling.flows]
    except ValueError:
        place.fail("a flow, or the moved vertices, end within a number")
    if any(len(line) < 2 for line in lines):
        place.at("flows").fail("a flow needs two points or more")
    if len(which) != len(places) or not all(np.isfinite(one).all() for one in (places, *lines)):
        place.fail("every moved vertex needs a place, and all numbers must be finite")
    n_vertices = 0
    if filling.choice is not None:
        _check_choice(filling.choice, len(corners), place.at("choice"))
        n_vertices = filling.choice.n_vertices
    if len(which) and not 0 <= which.min() <= which.max() < n_vertices:
        place.at("moved").fail(f"moved vertices are 0..{n_vertices - 1}, those of the fill")


def _check_choice(choice: Choice, n_sides: int, place: JsonValue) -> None:
    if len(choice.lengths) != n_sides:
        place.at("lengths").fail(f"the patch has {n_sides} sides")
    numbers = (*choice.lengths, *choice.widths, choice.rotation, choice.n_irregular)
    if not 0 <= min(numbers) <= max(numbers) <= MOST_NUMBER or not min(choice.lengths):
        place.fail(f"the numbers of a fill are 0 to {MOST_NUMBER}, its lengths from 1")
    try:
        quads, code = choice.faces, np.frombuffer(choice.code, "<u2")
    except ValueError:
        place.fail("the quads, or the code, end within a number")
    if not is_disk_within(quads, choice.n_vertices, choice.perimeter):
        place.at("quads").fail("the quads do not fill the patch: no disk within its boundary")
    try:
        Disk.from_twin(decode(code))
    except (InvalidCodeError, InvalidMeshError) as error:
        place.at("code").fail(str(error))


def is_disk_within(quads: NDArray[np.integer], n_vertices: int, perimeter: int) -> bool:
    """Are these quads (q, 4) one disk, all of the vertices 0..n - 1 its own, whose boundary is
    0..P - 1 counter-clockwise?"""
    if not 4 <= perimeter <= n_vertices or not len(quads):
        return False
    if n_vertices > quads.size or quads.min() < 0 or quads.max() >= n_vertices:
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
    graph = coo_array((np.ones(len(tail), np.int8), (tail, head)), shape=(n_vertices, n_vertices))
    connected = connected_components(graph, directed=False)[0] == 1
    return n_vertices - edges + len(quads) == 1 and connected
