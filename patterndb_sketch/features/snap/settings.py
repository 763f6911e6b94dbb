"""What a sketched curve is drawn to, and how stiff it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Floats
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone import Fishbone
from patterndb_sketch.features.ribs import RADIUS, SAMPLES

#: The length over which bends are measured, as a share of the diagonal.
WINDOW = 0.003

#: How near the backbone bends count, as a share of the diagonal: see
#: :func:`patterndb_sketch.features.fishbone.terms`.
NEARNESS = 0.012

#: Cost of moving across by as much as along: see :meth:`SnapSettings.cross`.
THETA = 0.4


@dataclass(frozen=True, slots=True)
class SnapSettings:
    """What a curve is drawn to, and how stiff it is.

    alpha:     1 for bends of the surface alone, 0 for the angle of its normals alone.
    axis:      (3,) the direction that normals are measured from. beta: the angle, in radians.
    stiffness: at least 1; the cost of moving across, as a multiple.
    theta:     that cost as such: moving across by some length costs theta times what the worst
               sample costs over the same length along the curve.
    strict:    rather, as the paper has it, moving by one sample costs as much as the worst
               sample: the curve hardly leaves the row that it is in.
    window:    length over which bends are measured, as a share of the model's diagonal.
    nearness:  bends at this distance from the backbone count 0.6 times, at twice it 0.14 times; a
               share of the diagonal, inf where all count alike.
    degree:    of the curve.
    radius:    reach of ribs to either side, as a share of the diagonal. n_samples: of each.
    rounds:    how often the ribs are built about the curve and cut. Two bring the curve to the
               feature; a third the ribs of a stroke's ends, which at first lie askew to it.

    Raises InvalidFeatureError for numbers out of range.
    """

    alpha: float = 1.0
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    beta: float = np.pi / 2.0
    stiffness: float = 1.0
    theta: float = THETA
    strict: bool = False
    window: float = WINDOW
    nearness: float = NEARNESS
    degree: int = 3
    radius: float = RADIUS
    n_samples: int = SAMPLES
    rounds: int = 3

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("alpha", self.alpha, 0.0, 1.0),
            ("beta", self.beta, 0.0, np.pi),
            ("stiffness", self.stiffness, 1.0, 1e6),
            ("theta", self.theta, 0.0, 1e6),
            ("window", self.window, 1e-9, 1.0),
            ("nearness", self.nearness, 1e-9, np.inf),
            ("radius", self.radius, 1e-6, 1.0),
            ("n_samples", self.n_samples, 5, 100_001),
            ("rounds", self.rounds, 1, 100),
        ):
            if not low <= value <= high:
                raise InvalidFeatureError(f"{name} is {value}; give {low:g} to {high:g}")

    def cross(self, fishbone: Fishbone, costs: Floats) -> Floats:
        """(m - 1,) capacities of the cross edges of a fishbone with sample costs (m, k).

        Source: feature curve recovery paper, section 4.3.3. Differs from the paper unless
        strict: capacities above all samples' make a curve that goes straight on whatever the
        surface is. Per length, rather than per sample, the result does not depend on how
        densely ribs are sampled: a cross edge costs theta f s / d where samples are s apart on
        ribs d apart.
        """
        count = len(costs) - 1
        if self.strict:
            return np.full(count, self.stiffness * costs[np.isfinite(costs)].max())
        spacing, gaps = fishbone.spacing, fishbone.gaps
        if not (count and gaps.mean() > 0.0):
            return np.zeros(count)
        step = (spacing[1:] + spacing[:-1]) / 2.0
        return self.theta * self.stiffness * step / gaps.mean()
