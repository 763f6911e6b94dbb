"""Define what a tool is: an entry of the table, and what it works on.

Read :class:`State` (what editing changes), :class:`ToolWork` (what a tool is given),
:class:`Result` (what it gives back), :class:`Control` (how a window offers it) and :class:`Tool`
(all of these).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.arguments import MOST_POINTS, Argument, Number
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    Edit,
    Network,
    are_equal,
    find_nearest_place,
    take_samples,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half, Plane, refuse_beyond
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from query.engine import PatternSource

#: What the mouse gives a tool.
#: stroke: a line drawn on the surface. click: a point. drag: two points, pressed and released.
#: plane: a straight line across the view. scribble: a line, or a curve by a click. corner: a
#: point, or a wedge dragged to one. within: a line, or by a click a point of a patch. count: the
#: wheel changes the curve under the pointer. act: nothing; it is done when it is chosen.
Gesture = Literal[
    "stroke", "click", "drag", "plane", "scribble", "corner", "within", "count", "act"
]

#: What of the network is shown to be meant: where ends snap to, a curve, a corner, or a patch.
Target = Literal["ends", "chain", "corner", "patch", "none"]

#: How far off a surface's box a point may be that is meant to be on it, and what lengths may be, as
#: parts of its diagonal: what is beyond is a mistake in the unit, and would take all memory.
FAR = 1.0
LEAST_LENGTH, MOST_LENGTH = 1e-6, 100.0


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What editing changes, as one value.

    network: the curves, with counts and fills. sizes: of brushes and edges. plane: of symmetry,
    None where it is off.

    Undoing is to take an earlier state. What the user looks at, such as whether the surface is
    hidden, is not part of it.
    """

    network: Network
    sizes: Sizes
    plane: Plane | None = None

    def same(self, other: State) -> bool:
        """Are they equal, bit for bit?"""
        return (
            self.sizes == other.sizes
            and self.plane == other.plane
            and are_equal(self.network, other.network)
        )


@dataclass(frozen=True, slots=True, eq=False)
class ToolWork:
    """What a tool works on.

    surface: the half that is worked on while symmetry is on. half: that half, with the whole.
    kept: what a tool made before and may need again, by a key of its own; the editor keeps it.
    """

    state: State
    surface: Surface
    source: PatternSource
    half: Half | None = None
    kept: dict[Hashable, Any] = field(default_factory=dict)

    @property
    def network(self) -> Network:
        """The network, which knows its surface: one that was read or restored does not yet."""
        found = self.state.network
        return found if found.surface is self.surface else replace(found, surface=self.surface)

    @property
    def whole(self) -> Surface:
        """The whole surface, whatever symmetry is."""
        return self.surface if self.half is None else self.half.whole

    def find_foot(self, point: ArrayLike) -> SurfacePoints:
        """The point of the surface nearest to a point (3,), as one foot."""
        at = np.asarray(point, np.float64)[None]
        self._refuse_far(at)
        return self.surface.nearest(at)

    def clean_stroke(self, points: Points, closed: bool | None = None) -> SurfaceCurve:
        """A stroke as it was drawn, cleaned."""
        self._refuse_far(points)
        samples = arc_length(points)[-1] / self.state.sizes.sampling
        if samples > MOST_POINTS:
            raise InvalidRetopoError(
                f"the stroke would have {samples:,.0f} points at a sampling of "
                f"{self.state.sizes.sampling:g}, and {MOST_POINTS:,} are the most; draw it shorter"
            )
        return clean_stroke(points, self.whole, self.state.sizes, closed)

    def clean_stroke_here(
        self, points: Points, what: str, closed: bool | None = None
    ) -> SurfaceCurve:
        """A stroke, cleaned, that must be on the half that is worked on; what: it is, for words.

        Raises RefusedError if it is not, while symmetry is on.
        """
        drawn = self.clean_stroke(points, closed)
        if self.half is not None:
            refuse_beyond(drawn, self.half, what)
        return drawn

    def check_length(self, name: str, value: float, least: float = LEAST_LENGTH) -> float:
        """A length as it is given; InvalidRetopoError for one out of proportion to the surface.

        least: as a part of the surface's diagonal.
        """
        low, high = least * self.surface.diagonal, MOST_LENGTH * self.surface.diagonal
        if not low <= value <= high:
            raise InvalidRetopoError(
                f"{name} is {value:g}; on this surface give {low:.3g} to {high:.3g}"
            )
        return value

    def _refuse_far(self, points: Points) -> None:
        """InvalidRetopoError unless all points (n, 3) are within a diagonal of the surface's
        box."""
        low, high = self.whole.vertices.min(axis=0), self.whole.vertices.max(axis=0)
        reach = FAR * self.whole.diagonal
        far = np.flatnonzero(((points < low - reach) | (points > high + reach)).any(axis=1))
        if len(far):
            at = ", ".join(f"{x:g}" for x in points[far[0]])
            raise InvalidRetopoError(
                f"the point [{at}] is far from the surface, whose box is "
                f"[{', '.join(f'{x:g}' for x in low)}] to [{', '.join(f'{x:g}' for x in high)}]; "
                "give points of the surface"
            )

    def find_chain(self, point: ArrayLike) -> int:
        """The chain nearest to a point of the surface, within the snap radius."""
        foot = self.find_foot(point)
        found = find_nearest_place(
            take_samples(self.network), foot.points[0], foot.normals[0], self.state.sizes.snap
        )
        if found is None:
            raise RefusedError("no curve is near; point closer to one")
        return found.chain

    def keep_edit(self, edit: Edit) -> Result:
        """What a tool's edit comes to."""
        return Result(replace(self.state, network=edit.network), edit.notes)

    def keep_network(self, network: Network, notes: tuple[str, ...] = ()) -> Result:
        return Result(replace(self.state, network=network), notes)


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """The state after a tool, and what the user should know."""

    state: State
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Control:
    """How a window offers a tool; "" and None where what follows from its arguments will do.

    key:     that chooses it, one letter. title: in lists, else the tool's name.
    hint:    what to do, in a line, else the tool's help.
    gesture: what the mouse gives it. target: what of the network is shown to be meant.
    brush:   the size, a field of ``Sizes``, that the keys of brushes change.
    fixed:   arguments that are always so.
    mode:    can it be chosen? Else only keys of the window's own call it.
    """

    key: str = ""
    title: str = ""
    hint: str = ""
    gesture: Gesture | None = None
    target: Target | None = None
    brush: str = ""
    fixed: tuple[tuple[str, object], ...] = ()
    mode: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """An entry of the table of tools: all that a script, a window, the guide and a test know of it.

    name:      in calls. help: one sentence.
    arguments: by name. act: from work and arguments to a result; it raises RefusedError where the
               tool cannot do what it was asked for, InvalidRetopoError for what makes no sense.
    position:  in lists of tools, ascending; those without one come last, by name.
    snaps:     does it look for curves, corners or ends near to where it is pressed? Then it may be
               told within which radius; see :func:`accept_snap`.
    holds:     does it say itself which vertices are held where? Else those of patches whose
               curves take another course are let go.
    control:   how a window offers it.
    """

    name: str
    help: str
    arguments: Mapping[str, Argument]
    act: Callable[[ToolWork, dict[str, Any]], Result]
    position: float = math.inf
    snaps: bool = False
    holds: bool = False
    control: Control = Control()


#: The argument by which a call says within which radius it finds what is near.
SNAP = "snap"


def accept_snap(tool: Tool) -> Tool:
    """The tool with an argument for its snap radius, if it is one that snaps.

    The radius takes the place of ``Sizes.snap`` for one call: a window reaches less when one
    looks from nearer by, and its calls are the same in a script, whatever the view was.
    """
    if not tool.snaps:
        return tool

    def act(work: ToolWork, a: dict[str, Any]) -> Result:
        snap = a[SNAP]
        if snap is None:
            return tool.act(work, a)
        sizes = work.state.sizes
        near = replace(sizes, snap=work.check_length(f"{tool.name}: {SNAP}", snap))
        result = tool.act(replace(work, state=replace(work.state, sizes=near)), a)
        return replace(result, state=replace(result.state, sizes=sizes))

    radius = Argument(Number(1e-12), "for this call, in place of that of sizes", None, option=False)
    return replace(tool, arguments={**tool.arguments, SNAP: radius}, act=act)
