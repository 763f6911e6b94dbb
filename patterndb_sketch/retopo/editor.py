"""The editor: what a window, a script and a test drive.

It has a state and its history (:class:`patterndb_sketch.retopo.tool.State`), and obeys calls of the
tools of the table (:mod:`patterndb_sketch.retopo.table`), which may say what
:mod:`patterndb_sketch.retopo.arguments` reads. After a call it notes what is rarely meant, open
ends and curves that leave the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, Triangles
from patterndb.verbs import PlotVerbs
from patterndb_sketch.history import DEPTH, History
from patterndb_sketch.retopo.arguments import read_arguments
from patterndb_sketch.retopo.draft.fitting import sample_both_sides
from patterndb_sketch.retopo.draft.refitting import claim_curves, refit_quads
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    PlacedCache,
    RetopoMesh,
    fill_network,
    release_vertices,
    weld_patches,
)
from patterndb_sketch.retopo.network import Network, Node, add_borders
from patterndb_sketch.retopo.network.flooding import find_leaps
from patterndb_sketch.retopo.network.invariants import check_kept_faces
from patterndb_sketch.retopo.quadimport import QuadImport
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half, Plane, cut_half, mirror_mesh
from patterndb_sketch.retopo.table import TOOLS
from patterndb_sketch.retopo.tool import State, ToolWork
from patterndb_sketch.retopo.wording import count_places, list_places
from query.engine import PatternSource

__all__ = ["DEPTH", "TOOLS", "Call", "Outcome", "Retopology", "State"]


@dataclass(frozen=True, slots=True)
class Call:
    """A tool by name, with arguments as plain data; see :data:`TOOLS`."""

    tool: str
    arguments: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a call came to.

    changed: is the state another one? refused: why the tool did nothing, None if it did
    something. notes: what the user should know. ends: those of them that tell of open ends,
    which who looks at the curves sees.
    """

    changed: bool
    refused: str | None = None
    notes: tuple[str, ...] = ()
    ends: tuple[str, ...] = ()


#: Planes of symmetry whose placed patches are kept: who tries one goes back to that before.
PLANES = 4


class Retopology(PlotVerbs):
    """A network on a surface, edited by calls of tools.

    Windows, scripts and programs use the same calls; "undo" and "redo" are two of them. Every tool
    is a method, too, which returns the retopology: ``retopology.loop(at=[0, 0, 1],
    normal=[0, 0, 1])``. A tool that does nothing leaves no step in the history. After a call the
    patches have their loops; :meth:`fill` gives them counts, fills and places.

    Example: ``Retopology(patterndb.read("head.obj"), db).draft(quads=1500).fill()``
    """

    def __init__(
        self,
        surface: Surface | PolygonMesh | Triangles,
        source: PatternSource,
        sizes: Sizes | None = None,
    ) -> None:
        """Begin with the borders of a surface as marked chains.

        surface: oriented as :meth:`patterndb.geometry.surface.Surface.orient` does it, or a mesh of
        polygons or triangles that becomes such a surface. source: a database.

        Raises InvalidMeshError for a mesh that has no area, or one side only.
        """
        if isinstance(surface, PolygonMesh):
            surface = surface.surface()
        elif not isinstance(surface, Surface):
            surface = Surface.of(surface).orient()
        self.surface = surface
        self.source = source
        chosen = Sizes.of(surface.diagonal) if sizes is None else sizes
        network = Network(longest=2.0 * surface.diagonal)
        network = add_borders(network, surface, chosen.sampling)
        self._history = History(State(network, chosen))
        # What is placed, and where ridges are, depends on the surface: the half one has its own.
        self._caches: dict[Plane | None, PlacedCache] = {}
        self._halves: dict[Plane, Half] = {}
        self._kept: dict[Hashable, Any] = {}
        self._filled: FilledNetwork | None = None

    @classmethod
    def of_quads(cls, found: QuadImport, source: PatternSource) -> Retopology:
        """On the surface of a mesh of quads, with its regular grids as patches, and other faces
        as they are."""
        editor = cls(found.surface, source, found.sizes)
        editor.restore(State(found.network, found.sizes))
        editor.adopt(editor.network, found.filled)
        return editor

    @property
    def state(self) -> State:
        return self._history.now

    @property
    def network(self) -> Network:
        return self._history.now.network

    @property
    def sizes(self) -> Sizes:
        return self._history.now.sizes

    @property
    def half(self) -> Half | None:
        """The half of the surface that is worked on; None where symmetry is off."""
        plane = self.state.plane
        if plane is None:
            return None
        if plane not in self._halves:
            self._halves[plane] = cut_half(self.surface, plane)
        return self._halves[plane]

    @property
    def surface_now(self) -> Surface:
        """What curves and quads lie on: the surface, or its half while symmetry is on."""
        half = self.half
        return self.surface if half is None else half.surface

    @property
    def filled(self) -> FilledNetwork | None:
        """What :meth:`fill` or :meth:`adopt` gave for the network now; None if it changed since."""
        found = self._filled
        return found if found is not None and found.network is self.network else None

    @property
    def undoable(self) -> int:
        """Steps that can be undone."""
        return self._history.undoable

    @property
    def redoable(self) -> int:
        """Steps that can be redone."""
        return self._history.redoable

    def __getattr__(self, name: str) -> Callable[..., Retopology]:
        """Return the tool of this name as a method; RefusedError where it does nothing."""
        if name.startswith("_") or name not in (*TOOLS, "undo", "redo"):
            raise AttributeError(f"Retopology has no attribute and no tool {name!r}")

        def call(**arguments: object) -> Retopology:
            outcome = self.do(Call(name, arguments))
            if outcome.refused is not None:
                raise RefusedError(f"{name}: {outcome.refused}")
            return self

        return call

    def do(self, call: Call) -> Outcome:
        """Obey a call.

        Raises InvalidRetopoError for a tool or arguments that there are not; whatever else a
        tool cannot do is told in the outcome.
        """
        if call.tool in ("undo", "redo"):
            read_arguments(call.tool, {}, call.arguments)
            moved = self._history.undo() if call.tool == "undo" else self._history.redo()
            return Outcome(True) if moved else Outcome(False, f"there is nothing to {call.tool}")
        tool = TOOLS.get(call.tool)
        if tool is None:
            there = ", ".join([*TOOLS, "undo", "redo"])
            raise InvalidRetopoError(f"there is no tool {call.tool!r}; there are {there}")
        arguments = read_arguments(call.tool, tool.arguments, call.arguments)
        try:
            result = tool.act(
                ToolWork(self.state, self.surface_now, self.source, self.half, self._kept),
                arguments,
            )
            check_kept_faces(self.network, result.state.network)
        except RefusedError as error:
            return Outcome(False, str(error))
        state = result.state
        state = replace(state, network=claim_curves(self.network, state.network))
        if not tool.holds:
            state = replace(state, network=release_vertices(self.network, state.network))
        if state.same(self.state):
            return Outcome(False, None, result.notes)
        before = self.network
        self._history.step(state)
        if not tool.holds:
            self._refit(before)
        ends = describe_open_ends(before, state.network, state.sizes)
        leaps = describe_leaps(before, state.network, self.surface_now)
        return Outcome(True, None, (*result.notes, *ends, *leaps), ends)

    def _refit(self, before: Network) -> None:
        """Fit quads of a draft to the surface where the last step filled patches anew."""
        state, surface, half = self.state, self.surface_now, self.half
        cache = self._cache_of(state.plane)
        fitted = refit_quads(
            before,
            state.network,
            surface,
            self.source,
            state.sizes,
            lambda: sample_both_sides(surface, half, state.sizes.edge),
            cache,
        )
        if fitted is not state.network:
            self._history.settle(replace(state, network=fitted))

    def _cache_of(self, plane: Plane | None) -> PlacedCache:
        """What was placed with a plane of symmetry; kept of those that were used last."""
        cache = self._caches.pop(plane, None)
        cache = self._caches[plane] = PlacedCache() if cache is None else cache
        while len(self._caches) > PLANES:
            del self._caches[next(iter(self._caches))]
        return cache

    def keep_history(self) -> History[State]:
        """What :meth:`return_to` goes back to, whatever was begun since."""
        return self._history.copy()

    def return_to(self, history: History[State]) -> None:
        """Have the states be as they were when they were kept."""
        self._history = history

    def fill(self) -> FilledNetwork:
        """Counts, fills and places for all patches of the state now; it keeps them."""
        cache = self._cache_of(self.state.plane)
        found = fill_network(self.network, self.surface_now, self.source, self.sizes.edge, cache)
        self.adopt(self.network, found)
        return found

    def mesh(self, found: FilledNetwork) -> RetopoMesh:
        """The quads of the filled network as one mesh; while symmetry is on with their image."""
        plane = self.state.plane
        mesh = weld_patches(found)
        return mesh if plane is None else mirror_mesh(mesh, found.network, plane).mesh

    def adopt(self, network: Network, found: FilledNetwork) -> bool:
        """Keep what was filled elsewhere, if the network is still the one that it was made for."""
        if network is not self.network:
            return False
        if found.network is not network:
            self._history.settle(replace(self.state, network=found.network))
        self._filled = found
        return True

    def restore(self, state: State) -> None:
        """Begin from a state that was saved; nothing can be undone."""
        self._history = History(state)
        self._filled = None


def describe_open_ends(before: Network, after: Network, sizes: Sizes) -> tuple[str, ...]:
    """The open ends that an edit left, in words with places; () for none that is new."""
    ends = np.array([n.point for n in _list_new_ends(before, after)]).reshape(-1, 3)
    if not len(ends):
        return ()
    return (
        f"{count_places('an open end', 'open ends', ends)}: nothing to be joined to was within "
        f"the snap radius of {sizes.snap:.3g}",
    )


def describe_leaps(before: Network, after: Network, surface: Surface) -> tuple[str, ...]:
    """Where an edit left curves that leave the surface, likewise."""
    leaps = find_new_leaps(before, after, surface)
    if not len(leaps):
        return ()
    what = "a curve leaves" if len(leaps) == 1 else "curves leave"
    return (
        f"{what} the surface {list_places(leaps)}, for another part of it: redraw it along the "
        "surface, with points nearer to each other",
    )


def _list_new_ends(before: Network, after: Network) -> list[Node]:
    """The open ends of a network that were none before."""
    return [
        node
        for number, node in sorted(after.nodes.items())
        if node.open and not ((former := before.nodes.get(number)) is not None and former.open)
    ]


def find_new_leaps(before: Network, after: Network, surface: Surface) -> Points:
    """(k, 3) where curves that are new, or run elsewhere than before, leave the surface.

    Not those that a draft laid: they were traced on the surface, and the draft is judged by its
    quads. Between sheets closer than its samples the nearest sheet need not be its own.
    """
    found: list[Points] = [np.empty((0, 3))]
    for number, chain in sorted(after.chains.items()):
        if chain.auto:
            continue
        former = before.chains.get(number)
        if former is None or former.points is not chain.points:
            found.append(find_leaps(surface, chain.points, chain.is_closed_loop))
    leaps = np.concatenate(found)
    if not len(leaps) or not before.chains:
        return leaps
    # A curve that is cut by the edit is another chain: what it did before it still does.
    former = [
        find_leaps(surface, chain.points, chain.is_closed_loop)
        for number, chain in before.chains.items()
        if number not in after.chains and not chain.auto
    ]
    old = np.concatenate([np.empty((0, 3)), *former])
    away = np.linalg.norm(leaps[:, None] - old, axis=2)
    return leaps[~(away < SAME_LEAP * surface.diagonal).any(axis=1)]


#: Two places where curves leave the surface are one if they are this near, in parts of the
#: diagonal.
SAME_LEAP = 0.002
