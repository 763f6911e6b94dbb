"""The frame of a model: do curves lie on it, and if not, in which of the 24 turns would they?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import Template
from patterndb_sketch.features.splines import Spline

#: A point of a curve is on the model if it is nearer than this share of the diagonal: the model's,
#: or that of all points if they take up less room.
ON_MODEL = 0.02

#: Curves are those of the model if at least this share of their points is on it. Of six cars and
#: thirteen bodies it is 0.94 to 1, for some run inside as the backs of wheelhouses do; in all other
#: turns, back to front among them, it is 0.7 at most.
LEAST_ON = 0.8

#: Points of every curve that are looked at.
SAMPLES = 40

#: Ratios of units of length: metre, decimetre, centimetre, millimetre, inch, foot and yard.
LENGTHS = (1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048, 0.9144)
UNITS = tuple(sorted({one / other for one in LENGTHS for other in LENGTHS}))

AXES = "xyz"


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn of a model that takes axes to axes.

    axes: for x, y and z of the turned model which axis of the model it is, with its sign, such as
    ("y", "-x", "z"). Right-handed ones alone: a mirror image is another model.
    """

    axes: tuple[str, str, str]

    @classmethod
    def parse(cls, text: str) -> Turn:
        """The turn that is written as "y,-x,z". Raises InvalidFeatureError for what is none."""
        parts = tuple(part.strip() for part in text.split(","))
        for turn in TURNS:
            if turn.axes == parts:
                return turn
        raise InvalidFeatureError(
            f"{text!r} is no turn; give the model's axes that become x, y and z, such as y,-x,z; "
            "a mirror image, such as x,-y,z, is none"
        )

    def __str__(self) -> str:
        return ",".join(self.axes)

    def turn_points(self, points: Points) -> Points:
        """(n, 3) points in the turned frame, exactly."""
        columns = [AXES.index(axis[-1]) for axis in self.axes]
        signs = [-1.0 if axis[0] == "-" else 1.0 for axis in self.axes]
        return np.asarray(points, np.float64)[:, columns] * signs

    def turn_model(self, model: Surface) -> Surface:
        """The same triangles in the turned frame."""
        return Surface.from_soup(
            PolygonMesh.from_faces(self.turn_points(model.vertices), model.triangles)
        )


def _list_turns() -> tuple[Turn, ...]:
    found: list[Turn] = []
    for order, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[range(3), order] = signs
        if np.linalg.det(matrix) > 0.0:
            axes = [("-" if s < 0 else "") + AXES[k] for k, s in zip(order, signs, strict=True)]
            found.append(Turn((axes[0], axes[1], axes[2])))
    return tuple(found)


#: All turns, that which does nothing first.
TURNS = _list_turns()


def measure_share_on(model: Surface, points: Points) -> float:
    """The share of points (n, 3) that is on a model."""
    # Few points of a large model are far from its surface: curves in another unit would be on it.
    size = min(model.diagonal, float(np.linalg.norm(np.ptp(points, axis=0))))
    return float((model.measure_distances(points) < ON_MODEL * size).mean())


def sample_curves(curves: Iterable[Spline]) -> Points:
    """(n, 3) points of all curves, as many of each. Raises InvalidFeatureError if there is none."""
    every = [curve.sample(SAMPLES) for curve in curves]
    if not every:
        raise InvalidFeatureError("the network has none of the template's curves")
    return np.concatenate(every)


def find_turn(model: Surface, curves: Iterable[Spline]) -> tuple[Turn, float]:
    """The turn in which most of the curves' points are on the model, and their share; of equally
    good ones that which comes first, so that a model is not turned for nothing."""
    points = sample_curves(curves)
    # The points are turned back rather than the model: its tree is built once.
    shares = [measure_share_on(model, _turn_back(turn, points)) for turn in TURNS]
    best = int(np.argmax(shares))
    return TURNS[best], shares[best]


def find_scale(model: Surface, curves: Iterable[Spline]) -> tuple[float, Turn, float]:
    """The ratio of two units of length by which the curves have to be enlarged to lie on the model,
    in which turn, and the share of their points that is on it then."""
    points = sample_curves(curves)
    # Curves go from end to end of a model, whatever share of its width they cover.
    ratio = float(np.ptp(model.vertices, axis=0).max() / np.ptp(points, axis=0).max())
    scale = min(UNITS, key=lambda unit: abs(np.log(unit / ratio)))
    shares = [measure_share_on(model, scale * _turn_back(turn, points)) for turn in TURNS]
    best = int(np.argmax(shares))
    return scale, TURNS[best], shares[best]


def check_frame(model: Surface, curves: Iterable[Spline]) -> None:
    """Raises InvalidFeatureError if the curves do not lie on the model; it says in which turn, or
    in which unit, they would."""
    every = list(curves)
    share = measure_share_on(model, sample_curves(every))
    if share >= LEAST_ON:
        return
    raise InvalidFeatureError(
        f"the curves do not lie on the model: {share:.0%} of their points are within "
        f"{ON_MODEL:.0%} of the diagonal; {_mend(model, every)}"
    )


def _mend(model: Surface, curves: list[Spline]) -> str:
    """What would bring curves and model together."""
    turn, share = find_turn(model, curves)
    if share >= LEAST_ON:
        return f"in the model turned to {turn} (--turn {turn}) it is {share:.0%}"
    scale, turn, share = find_scale(model, curves)
    if share >= LEAST_ON:
        turned = "" if turn == TURNS[0] else f", and the model turned to {turn}"
        return (
            f"were the curves {scale:g} times as large{turned}, it would be {share:.0%}: give both "
            "in one unit of length"
        )
    return "in no turn by right angles it is enough: is it another model's network?"


def check_sense(template: Template, spanned: Points) -> None:
    """Raises InvalidFeatureError if half a template is inside out on its curves, which are then
    those of the other half.

    spanned: (v, 3) its vertices on the membrane. Hollow parts, which are seen from inside, are not
    looked at.
    """
    quads = template.quads[~template.hollow[template.quads[:, 0]]]
    if not template.mirrored or not len(quads):
        return
    corners = spanned[quads]
    centre = corners.reshape(-1, 3).mean(axis=0) * [1.0, 0.0, 1.0]
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    if np.einsum("qc,qc->", across, corners.mean(axis=1) - centre) < 0.0:
        side = "above" if corners[..., 1].mean() > 0.0 else "below"
        raise InvalidFeatureError(
            f"the template {template.name} is inside out on these curves, which are {side} y = 0: "
            "they are those of the other half; give them with y and -y exchanged"
        )


def _turn_back(turn: Turn, points: Points) -> Points:
    result = np.empty_like(points)
    for k, axis in enumerate(turn.axes):
        result[:, AXES.index(axis[-1])] = points[:, k] * (-1.0 if axis[0] == "-" else 1.0)
    return result
