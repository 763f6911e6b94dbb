"""Snakes: a curve, or a corner with its curves, moves to a ridge or a valley near it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from query.placing.surface import Points
from sketch.retopo.errors import InvalidRetopoError, RefusedError
from sketch.retopo.ground import Ground, targets
from sketch.retopo.network.draft import Draft
from sketch.retopo.network.edits import Edit
from sketch.retopo.network.ends import AtNode
from sketch.retopo.network.structure import Network
from sketch.retopo.sizes import Sizes
from sketch.retopo.tools.course import crossing_notes, evened, on_ground
from sketch.retopo.tools.pull import held, with_node_at
from sketch.retopo.tools.salience import MODES, Mode, Salience

#: What the two targets of smoothing and the pull of the features weigh in a step.
WEIGHTS = (1.0, 1.0, 1.0)

#: A step goes this part of the way that they want.
PART = 0.5

#: A curve is at rest when no point moves by more than this, in target edges.
REST = 1e-3

#: Steps after which it is left as it is.
MOST_STEPS = 50

#: Points at each end of a curve that stay.
STAYING = 2

#: A feature is felt if it bends an edge by this, in radians: 1/4 degree, a quarter of FAINT.
FELT = 0.25 * np.pi / 180.0


def align(
    network: Network,
    ground: Ground,
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
    at = held(network, sizes, point, normal)
    if isinstance(at, AtNode):
        return align_node(network, ground, sizes, salience, at.node, mode)
    return align_chain(network, ground, sizes, salience, at.chain, mode)


def align_chain(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    salience: Salience,
    chain: int,
    mode: Mode = "both",
) -> Edit:
    """Move a chain, whose ends stay, to the nearest ridge or valley; its patches stay patches.

    salience: of this ground, for this target edge. Features are felt up to about 3 target
    edges off. Raises RefusedError for a border or the seam of symmetry, a chain of too few
    points, and if nothing is felt anywhere on it.
    Source: Takayama et al. 2013, section 4 (after Lee and Lee 2002), and their program.
    """
    _check(sizes, salience, mode)
    line = network.chain(chain)
    if line.marked:
        raise RefusedError("a border or the seam of symmetry stays where it is")
    least = 3 if line.loose else 2 * STAYING + 1
    if len(line.points) < least:
        raise RefusedError(f"the curve has fewer than {least} points: it is too short to move")
    feature, _ = salience.felt(line.points, line.normals, mode)
    if feature.max() < FELT:
        raise RefusedError(f"no {_what(mode)} is near the curve: draw it closer to one")
    points, normals, rest = snake(
        line.points, line.normals, line.loose, ground, sizes, salience, mode
    )
    points, normals = evened(points, normals, ground, sizes, line.loose)
    draft = Draft(network)
    draft.reshape_chain(chain, points, normals)
    after = draft.finished()
    notes = [] if rest else [f"still moving after {MOST_STEPS} steps: align it again"]
    notes += crossing_notes(network.chains, after, [chain], sizes)
    return Edit.of(network, after, notes)


def align_node(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    salience: Salience,
    node: int,
    mode: Mode = "both",
) -> Edit:
    """Move a corner or an open end to the nearest ridge or valley; its chains follow, by shares
    that fall to 0 at their other ends, and patches stay patches.

    Raises RefusedError on a border or the seam of symmetry, and if nothing is felt there.
    """
    _check(sizes, salience, mode)
    at = network.node(node)
    if any(network.chains[half >> 1].marked for half in at.ends):
        raise RefusedError("a border or the seam of symmetry ends here: the corner stays")
    point, normal = at.point[None], at.normal[None]
    feature, _ = salience.felt(point, normal, mode)
    if feature[0] < FELT:
        raise RefusedError(f"no {_what(mode)} is near the corner: move it closer to one")
    for _ in range(MOST_STEPS):
        old = point
        pull = salience.felt(point, normal, mode)[1]
        point, normal = on_ground(point + PART * _short(pull, sizes), normal, ground, sizes)
        rest = float(np.linalg.norm(point - old)) < REST * sizes.edge
        if rest:
            break
    else:
        rest = False
    draft = Draft(network)
    with_node_at(draft, ground, sizes, node, point[0], normal[0])
    after = draft.finished()
    notes = [] if rest else [f"still moving after {MOST_STEPS} steps: align it again"]
    notes += crossing_notes(network.chains, after, [half >> 1 for half in at.ends], sizes)
    return Edit.of(network, after, notes)


def snake(
    points: Points,
    normals: Points,
    closed: bool,
    ground: Ground,
    sizes: Sizes,
    salience: Salience,
    mode: Mode,
) -> tuple[Points, Points, bool]:
    """A course (n, 3) moved to features, at rest or after MOST_STEPS; and is it at rest?

    Each step takes points half of the way to the mean of what they want: both targets of
    smoothing, and the pull of the features across the curve, at most a target edge; and projects
    them. STAYING points at each end of an open course stay.
    Differs from the program of Takayama et al. 2013: the feature is curvature that does not depend
    on the triangles, its pull is in target edges, and what pulls along the curve is left out:
    that would only crowd its points where features meet.
    """
    still = np.zeros(len(points), bool)
    if not closed:
        still[:STAYING] = still[-STAYING:] = True
    for _ in range(MOST_STEPS):
        wants = _short(_across(points, salience.felt(points, normals, mode)[1], closed), sizes)
        middle, curved = targets(points, closed)
        step = WEIGHTS[0] * (middle - points) + WEIGHTS[1] * (curved - points) + WEIGHTS[2] * wants
        step *= PART / sum(WEIGHTS)
        step[still] = 0.0
        moved, above = on_ground(points + step, normals, ground, sizes)
        moved[still], above[still] = points[still], normals[still]
        far = float(np.linalg.norm(moved - points, axis=1).max())
        points, normals = moved, above
        if far < REST * sizes.edge:
            return points, normals, True
    return points, normals, False


def _across(points: Points, pull: Points, closed: bool) -> Points:
    """What of pulls (n, 3) is not along the course (n, 3)."""
    if closed:
        along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    else:
        along = np.gradient(points, axis=0)
    size = np.einsum("nc,nc->n", along, along)
    part = np.einsum("nc,nc->n", pull, along) / np.where(size > 0.0, size, 1.0)
    return pull - part[:, None] * along


def _short(pull: Points, sizes: Sizes) -> Points:
    """Pulls (n, 3) of at most a target edge."""
    length = np.linalg.norm(pull, axis=1)
    return pull * np.minimum(1.0, sizes.edge / np.maximum(length, sizes.edge))[:, None]


def _check(sizes: Sizes, salience: Salience, mode: Mode) -> None:
    if mode not in MODES:
        raise InvalidRetopoError(f"curves are aligned to {', '.join(MODES)}, not to {mode!r}")
    if salience.edge != sizes.edge:
        raise InvalidRetopoError(
            f"the salience is for a target edge of {salience.edge:g}, not {sizes.edge:g}; make it "
            "anew when the target edge changes"
        )


def _what(mode: Mode) -> str:
    return "ridge or valley" if mode == "both" else mode
