"""The frame of a model: do curves lie on it, and if not, in which of the 24 turns would they?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.model import Model
from patterndb_sketch.features.splines import Spline

#: A point of a curve is on the model if it is nearer than this share of the diagonal.
ON_MODEL = 0.02

#: Curves are those of the model if at least this share of their points is on it. Of six cars and
#: thirteen bodies it is 0.94 to 1, for some run inside as the backs of wheelhouses do; in all other
#: turns, back to front among them, it is 0.7 at most.
LEAST_ON = 0.8

#: Points of every curve that are looked at.
SAMPLES = 40

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

    def turn_model(self, model: Model) -> Model:
        """The same triangles in the turned frame."""
        return Model.from_arrays(self.turn_points(model.points), model.triangles)


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


def measure_share_on(model: Model, points: Points) -> float:
    """The share of points (n, 3) that is on a model."""
    away = model.nearest(points).lengths
    return float((away < ON_MODEL * model.diagonal).mean())


def sample_curves(curves: Iterable[Spline]) -> Points:
    """(n, 3) points of all curves, as many of each. Raises InvalidFeatureError if there is none."""
    every = [curve.sample(SAMPLES) for curve in curves]
    if not every:
        raise InvalidFeatureError("the network has none of the template's curves")
    return np.concatenate(every)


def find_turn(model: Model, curves: Iterable[Spline]) -> tuple[Turn, float]:
    """The turn in which most of the curves' points are on the model, and their share; of equally
    good ones that which comes first, so that a model is not turned for nothing."""
    points = sample_curves(curves)
    # The points are turned back rather than the model: its tree is built once.
    shares = [measure_share_on(model, _turn_back(turn, points)) for turn in TURNS]
    best = int(np.argmax(shares))
    return TURNS[best], shares[best]


def check_frame(model: Model, curves: Iterable[Spline]) -> None:
    """Raises InvalidFeatureError if the curves do not lie on the model; it says in which turn they
    would."""
    every = list(curves)
    share = measure_share_on(model, sample_curves(every))
    if share >= LEAST_ON:
        return
    turn, better = find_turn(model, every)
    mend = (
        f"in the model turned to {turn} (--turn {turn}) it is {better:.0%}"
        if better >= LEAST_ON
        else "in no turn by right angles it is enough: is it another model's network?"
    )
    raise InvalidFeatureError(
        f"the curves do not lie on the model: {share:.0%} of their points are within "
        f"{ON_MODEL:.0%} of its diagonal; {mend}"
    )


def _turn_back(turn: Turn, points: Points) -> Points:
    result = np.empty_like(points)
    for k, axis in enumerate(turn.axes):
        result[:, AXES.index(axis[-1])] = points[:, k] * (-1.0 if axis[0] == "-" else 1.0)
    return result
