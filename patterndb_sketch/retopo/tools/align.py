"""The alignment tool: a curve, or a corner with its curves, moves to a ridge or valley near it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import NEAR_CURVE, Argument, Word
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.builder import AtNode, NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.structure import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.course import even_course, note_crossings
from patterndb_sketch.retopo.tools.pull import find_held, move_node_to
from patterndb_sketch.retopo.tools.salience import MODES, Mode, Salience
from patterndb_sketch.retopo.tracing import smoothing_targets
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: What the two targets of smoothing and the pull of the features weigh in a step.
WEIGHTS = (1.0, 1.0, 1.0)

#: A step goes this part of the way that they want.
PART = 0.5

#: A curve is at rest when no point moves by more than this, in target edges.
REST = 1e-3

#: It is told that a curve is still on its way if a point moved by this in the last step, in target
#: edges: below it one hardly sees the next fifty steps.
ON_ITS_WAY = 0.02

#: Steps after which it is left as it is.
MOST_STEPS = 50

#: Pulls fade towards an end, which stays, over this many target edges: so that the curve is led
#: to the feature, and does not break off to it.
LEAD = 2.0

#: Pulls are averaged over this many target edges along the curve, both ways; directions along it
#: are taken over as much. Points are far closer than that, and would fold up one by one.
ALONG = 0.25

#: Fewest points of an open curve: one that moves with two on either side.
FEWEST = 5

#: A feature is felt if it bends an edge by this, in radians: 1/4 degree, a quarter of FAINT.
FELT = math.radians(0.25)


def align_nearest(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    salience: Salience,
    point: ArrayLike,
    normal: ArrayLike,
    mode: Mode = "both",
) -> Edit:
    """Align what is pressed to features: the nearest corner or open end within the snap radius,
    else the nearest chain. See :func:`align_node` and :func:`align_chain`.

    point, normal: (3,) on the surface. Raises RefusedError if nothing is near.
    """
    at = find_held(network, sizes, point, normal)
    if isinstance(at, AtNode):
        return align_node(network, surface, sizes, salience, at.node, mode)
    return align_chain(network, surface, sizes, salience, at.chain, mode)


def align_chain(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    salience: Salience,
    chain: int,
    mode: Mode = "both",
) -> Edit:
    """Move a chain, whose ends stay, to the nearest ridge or valley; its patches stay patches.

    salience: of this surface, for this target edge. Features are felt up to about 3 target
    edges off. Raises RefusedError for a border or the seam of symmetry, a chain of too few
    points, and if nothing is felt anywhere on it.
    Source: Takayama et al. 2013, section 4 (after Lee and Lee 2002), and their program.
    """
    _check_salience(sizes, salience)
    line = network.chain(chain)
    if line.marked:
        raise RefusedError("a border or the seam of symmetry stays where it is")
    least = 3 if line.is_closed_loop else FEWEST
    if len(line.points) < least:
        raise RefusedError(f"the curve has fewer than {least} points: it is too short to move")
    feature, _ = salience.feel(line.points, line.normals, mode)
    if feature.max() < FELT:
        raise RefusedError(f"no {_name_mode(mode)} is near the curve: draw it closer to one")
    points, normals, last = move_snake(
        line.points, line.normals, line.is_closed_loop, surface, sizes, salience, mode
    )
    points, normals = even_course(points, normals, surface, sizes, line.is_closed_loop)
    builder = NetworkBuilder(network)
    builder.reshape_chain(chain, points, normals)
    after = builder.finish()
    notes = _note_rest(last) + note_crossings(network, after, [chain], sizes)
    return Edit.of(network, after, notes)


def align_node(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    salience: Salience,
    node: int,
    mode: Mode = "both",
) -> Edit:
    """Move a corner or an open end to the nearest ridge or valley; its chains follow, by shares
    that fall to 0 at their other ends, and patches stay patches.

    Raises RefusedError on a border or the seam of symmetry, and if nothing is felt there.
    """
    _check_salience(sizes, salience)
    at = network.node(node)
    if any(network.chains[half >> 1].marked for half in at.ends):
        raise RefusedError("a border or the seam of symmetry ends here: the corner stays")
    point, normal = at.point[None], at.normal[None]
    feature, _ = salience.feel(point, normal, mode)
    if feature[0] < FELT:
        raise RefusedError(f"no {_name_mode(mode)} is near the corner: move it closer to one")
    last = 0.0
    for _ in range(MOST_STEPS):
        old = point
        pull = salience.feel(point, normal, mode)[1]
        point, normal = take_to_surface(
            point + PART * _shorten(pull, sizes), normal, surface, sizes
        )
        last = float(np.linalg.norm(point - old)) / sizes.edge
        if last < REST:
            break
    builder = NetworkBuilder(network)
    move_node_to(builder, surface, sizes, node, point[0], normal[0])
    after = builder.finish()
    notes = _note_rest(last)
    notes += note_crossings(network, after, [half >> 1 for half in at.ends], sizes)
    return Edit.of(network, after, notes)


def move_snake(
    points: Points,
    normals: Points,
    closed: bool,
    surface: Surface,
    sizes: Sizes,
    salience: Salience,
    mode: Mode,
) -> tuple[Points, Points, float]:
    """A course (n, 3) moved to features until it is at rest or after MOST_STEPS; and how far its
    points went at most in the last step, in target edges.

    Each step takes points half of the way to the mean of what they want: both targets of
    smoothing, and the pull of the features across the curve, at most a target edge; and projects
    them. The ends of an open course stay.
    Differs from the program of Takayama et al. 2013: the feature is curvature that does not depend
    on the triangles, and its pull is in target edges. What pulls along the curve, as it ran at
    first, is left out: it would only crowd its points where features meet. Pulls are averaged
    along it, and fade to its ends; there, two points at each end stay, and the curve breaks
    off right behind them.
    """
    at, up, last = points, normals, 0.0
    wide = min(max(1, round(ALONG * sizes.edge / sizes.sampling)), (len(points) - 1) // 4)
    fade = np.ones(len(points))
    if not closed:
        along = arc_length(points)
        lead = min(LEAD * sizes.edge, 0.5 * float(along[-1]))
        fade = np.minimum(np.minimum(along, along[-1] - along) / lead, 1.0)
    ahead = _direct(points, wide, closed)
    for _ in range(MOST_STEPS):
        pull = salience.feel(at, up, mode)[1]
        pull -= np.einsum("nc,nc->n", pull, ahead)[:, None] * ahead
        pull = _average(fade[:, None] * _shorten(pull, sizes), wide, closed)
        middle, curved = smoothing_targets(at, closed)
        step = WEIGHTS[0] * (middle - at) + WEIGHTS[1] * (curved - at) + WEIGHTS[2] * pull
        moved, up = take_to_surface(at + PART / sum(WEIGHTS) * step, up, surface, sizes)
        if not closed:
            moved[[0, -1]], up[[0, -1]] = points[[0, -1]], normals[[0, -1]]
        last = float(np.linalg.norm(moved - at, axis=1).max()) / sizes.edge
        at = moved
        if last < REST:
            break
    return at, up, last


def _extend(values: Points, wide: int, closed: bool) -> Points:
    """(n + 2 wide, 3) values of a course (n, 3), with those before its first and after its last;
    those of an open one are turned about its ends."""
    if closed:
        return np.concatenate([values[-wide:], values, values[:wide]])
    before = 2.0 * values[:1] - values[wide:0:-1]
    after = 2.0 * values[-1:] - values[-2 : -2 - wide : -1]
    return np.concatenate([before, values, after])


def _direct(points: Points, wide: int, closed: bool) -> Points:
    """(n, 3) unit directions of a course (n, 3), taken over ``wide`` points each way."""
    more = _extend(points, wide, closed)
    return units(more[2 * wide :] - more[: -2 * wide])


def _average(pull: Points, wide: int, closed: bool) -> Points:
    """Means of pulls (n, 3) over ``wide`` points each way; 0 at open ends if they are 0 there."""
    total = np.cumsum(np.concatenate([np.zeros((1, 3)), _extend(pull, wide, closed)]), axis=0)
    return (total[2 * wide + 1 :] - total[: -2 * wide - 1]) / (2 * wide + 1)


def _shorten(pull: Points, sizes: Sizes) -> Points:
    """Pulls (n, 3) of at most a target edge."""
    length = np.linalg.norm(pull, axis=1)
    return pull * np.minimum(1.0, sizes.edge / np.maximum(length, sizes.edge))[:, None]


def _check_salience(sizes: Sizes, salience: Salience) -> None:
    if salience.edge != sizes.edge:
        raise InvalidRetopoError(
            f"the salience is for a target edge of {salience.edge:g}, not {sizes.edge:g}; make it "
            "anew when the target edge changes"
        )


def _note_rest(last: float) -> list[str]:
    if last < ON_ITS_WAY:
        return []
    return [f"still on its way after {MOST_STEPS} steps: align it again"]


def _name_mode(mode: Mode) -> str:
    return "ridge or valley" if mode == "both" else mode


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    foot, sizes = work.find_foot(a["at"]), work.state.sizes
    key = Salience, sizes.edge, work.state.plane
    if key not in work.kept:
        # Of another target edge or half it is of no use any more, and it may be large.
        for other in [one for one in work.kept if isinstance(work.kept[one], Salience)]:
            del work.kept[other]
        work.kept[key] = Salience.of(work.surface, sizes.edge)
    point, normal = foot.points[0], foot.normals[0]
    return work.keep_edit(
        align_nearest(work.network, work.surface, sizes, work.kept[key], point, normal, a["mode"])
    )


ALIGN = Tool(
    "align",
    "Move a curve or a corner onto the nearest ridge or valley.",
    {"at": NEAR_CURVE, "mode": Argument(Word(MODES), "what it goes to", "both")},
    _act,
    position=180,
    snaps=True,
    control=Control("z", "align", "click a curve: it moves to ridges or valleys", target="chain"),
)
