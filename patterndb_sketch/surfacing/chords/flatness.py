"""How far from flat a piece of a cycle is: the spread of its vertices along three axes."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from patterndb._native.surfacing.chords.flatness import find_determinant, standardised, sum_moments
from patterndb.geometry.points import Points

#: How flatness is measured: "relative" to the whole cycle, or as "printed" in the paper.
Flatness = Literal["relative", "printed"]


def standardise(points: Points) -> tuple[Points, float]:
    """The points (n, 3) in axes in which their covariance is the unit matrix.

    Returns them and the determinant of their covariance, in units of length**6. If they are
    planar (PLANAR), points and determinant are 0.

    Ratios of determinants are the same in any axes; in these, the moments of every part are of
    the order of 1 and keep their digits, however flat, small or far away the points are.
    """
    own, determinant = standardised(np.ascontiguousarray(points, np.float64))
    return own, float(determinant)


def is_planar(points: Points) -> bool:
    """Are the points (n, 3) planar, as far as PLANAR tells? Then no piece of them is less so."""
    return standardise(points)[1] == 0.0


def measure_flatness(piece: Points, whole: Points, form: Flatness = "relative") -> float:
    """S(K): 0 for a planar piece (k, 3) of a whole cycle (n, 3), the larger the less flat.

    "relative": sqrt(det Cov(piece) / det Cov(whole)), without unit: 1 for the whole cycle.
    "printed":  det Cov(piece), the product of the principal components' variances, in units of
    length**6. Of a planar whole cycle, every piece has 0.

    Source: Abbasinejad et al. 2013, section 3.2. Differs from the paper: the printed form
    depends on the unit of length, so that at unit size alpha = 0.1 cuts nothing; hence the
    relative form, which is the ratio of the volumes of the two boxes.
    """
    axes_centre = whole.mean(axis=0)
    own, determinant = standardise(whole)
    if determinant == 0.0:
        return 0.0
    # The affine map to the whole's own axes, found from its points, then applied to the piece.
    centred = whole - axes_centre
    to_own, *_ = np.linalg.lstsq(centred, own, rcond=None)
    inside = (piece - axes_centre) @ to_own
    ratio = find_determinant(sum_moments(inside)) / find_determinant(sum_moments(own))
    return math.sqrt(ratio) if form == "relative" else ratio * determinant
