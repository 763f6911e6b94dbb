"""What pulls a curve along its ribs: bends of the surface, and the angle of its normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.features.fishbone.terms import bends as _bends
from patterndb._native.features.fishbone.terms import ways as _ways
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone.fishbone import Fishbone

#: The percentile of a term over all samples that counts as 1: a few outliers, at spikes of the
#: model, do not make a feature look flat.
PERCENTILE = 99.5

#: Bends are measured over so many windows at once. The narrowest says where a sharp edge is, the
#: widest where the middle of a rounded one is, whose own bends are all alike.
SCALES = (1.0, 4.0)

#: A surface that bends by less than this within a window, in radians, is flat, and normals that
#: all meet the angle as nearly meet it: rounding is not stretched to the whole range.
FLAT = 1e-4

#: What it costs to be off the backbone by as much as bends count near it, as a share of what the
#: worst sample costs: a stroke wobbles, but it was drawn along what it lies beside all the way.
#: Chosen with UNLIKE and CONTINUITY on half the creases of benchmarks/feature_creases.py.
ASTRAY = 0.4

#: It costs no more than this share of it, however far off: a stroke was drawn along the only crease
#: within reach.
FARTHEST = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class Terms:
    """The terms of a fishbone, each from 0 to 1, inf where there is no sample.

    curvature: (m, k) float64, 1 where ribs bend most, and near the backbone.
    isophote:  (m, k) float64, 0 where normals have the angle.
    flat:      of the two terms, those without any differences to follow.
    bends:     (m, k, 3) float64, which way ribs bend, as long as they bend, wherever the backbone
               is: 1 long where the curvature next to the backbone would be 1, 0 without a sample.
    """

    curvature: Floats
    isophote: Floats
    flat: tuple[str, ...]
    bends: Points


def find_terms(
    fishbone: Fishbone, window: float, nearness: float, axis: ArrayLike, beta: float
) -> Terms:
    """Both terms of a fishbone; see :func:`curvature` and :func:`isophote`.

    nearness: bends s along the rib from the backbone count exp(-(s / nearness)^2 / 2) times; inf
              for no difference.

    Differs from the paper: there all bends within the radius count alike, and a blunt feature
    is left for any sharper one beside it that the stroke did not mean.
    """
    plain = curvature(fishbone, window)
    bends = plain * weigh_nearness(fishbone, nearness)
    angles = isophote(fishbone, axis, beta)
    floor = FLAT / window
    flat = tuple(
        name
        for name, values, least in (
            ("curvature", bends, floor),
            ("isophote", angles, FLAT),
        )
        if _reach(values, fishbone.valid) < least
    )
    sizes = np.clip(plain / max(_reach(bends, fishbone.valid), floor), 0.0, 1.0)
    ways = _ways(fishbone.points, fishbone.first, fishbone.stop, fishbone.spacing, window)
    return Terms(
        scale_term(bends, fishbone.valid, floor),
        scale_term(angles, fishbone.valid, FLAT),
        flat,
        sizes[..., None] * ways,
    )


def tau(found: Terms, alpha: float) -> Floats:
    """(m, k) the cost of cutting a rib at its samples: 0 at the best, 1 at the worst.

    alpha (1 - curvature) + (1 - alpha) isophote. Inf where there is no sample.

    Source: feature curve recovery paper, section 4.3.3, equation 1. Differs from the paper: the
    cut is the cheapest one, so the printed sum would avoid curvature; it is turned round.
    """
    if not 0.0 <= alpha <= 1.0:
        raise InvalidFeatureError(f"alpha is {alpha}; give a number from 0 to 1")
    result = np.full(found.curvature.shape, np.inf)
    valid = np.isfinite(found.curvature)
    bends, angles = found.curvature[valid], found.isophote[valid]
    result[valid] = alpha * (1.0 - bends) + (1.0 - alpha) * angles
    return result


def weigh_creases(
    found: Terms, fishbone: Fishbone, alpha: float, nearness: ArrayLike, unlike: ArrayLike = 0.0
) -> Floats:
    """(m, k) the cost of samples where all ribs together say which crease it is; inf where there is
    no sample.

    nearness: (m,) or one number: so far from the backbone a sample costs ASTRAY more, twice as far
    four times as much, but no more than FARTHEST. unlike: (m, k) or one number, what samples cost
    more for other reasons.

    Differs from :func:`tau`: sharpness counts by its square root, and how far off a sample is
    counts for itself. What a bend is multiplied by, as there, draws a curve to a crease that lies
    twice as far off all along and bends a little more.
    """
    width = np.broadcast_to(np.asarray(nearness, np.float64), len(fishbone.points))[:, None]
    rows = np.arange(fishbone.valid.shape[1]) - fishbone.backbone[:, None]
    astray = np.minimum(ASTRAY * (rows * fishbone.spacing[:, None] / width) ** 2, FARTHEST)
    sharp = np.sqrt(np.minimum(np.linalg.norm(found.bends, axis=2), 1.0))
    costs = alpha * (1.0 - sharp + astray + unlike)
    angles = np.where(fishbone.valid, found.isophote, 0.0)
    return np.where(fishbone.valid, costs + (1.0 - alpha) * angles, np.inf)


def curvature(fishbone: Fishbone, window: float) -> Floats:
    """(m, k) float64 how much ribs bend, in radians per length; 0 where there is no sample.

    The mean of |kappa| over the chords to both sides, each ``window`` long along the rib rather
    than up to the next sample: neither the sampling nor facets narrower than the window count.
    Of a chord b' - b at the angle x to the tangent, kappa is 2 x / window. So the mean is the
    angle between both chords per window, 1 / radius on a circle whatever the window. It is
    taken over several windows, SCALES times the given one: the sum of their angles per sum of
    their lengths. At a corner that turns by phi it has a peak, and is 0 beyond the widest.
    Within a window of a rib's end the angle over what there is counts.

    Source: feature curve recovery paper, section 4.3.3, where kappa = 2 (b' - b) . n / |b' - b|^2.
    Differs from the paper: with the normal of the edge, as printed, kappa is 0 everywhere; n is
    the normal of the vertex b, halfway between the chords. And the printed kappa, which is
    2 sin(x) / |b' - b|, has a flat top at corners, as chords across a corner are shorter; the
    angle over the length along the rib has a peak there, and is the same on circles.

    Raises InvalidFeatureError for a window that is not positive.
    """
    if not (np.isfinite(window) and window > 0.0):
        raise InvalidFeatureError(f"the window of curvature is {window}; give a positive length")
    return _bends(fishbone.points, fishbone.first, fishbone.stop, fishbone.spacing, window)


def isophote(fishbone: Fishbone, axis: ArrayLike, beta: float) -> Floats:
    """(m, k) float64 |arccos(n . a) - beta| in radians; 0 where there is no sample.

    axis: (3,) of any length. beta: radians from 0 to pi. The better of n and -n.

    Ribs know the normals of their contours, which lie in the ribs' planes: they are the
    surface's normals projected along the backbone. Where the curve itself is they agree, since
    its tangent lies in the surface.

    Source: feature curve recovery paper, section 4.3.3. Differs from the paper: models have no
    sides, so either side of the surface may have the angle.

    Raises InvalidFeatureError for an axis without length, or an angle out of range.
    """
    along = np.asarray(axis, np.float64)
    if along.shape != (3,) or not np.isfinite(along).all() or not np.linalg.norm(along) > 0.0:
        raise InvalidFeatureError(f"the axis of isophotes is {axis}; give a direction (x, y, z)")
    if not 0.0 <= beta <= np.pi:
        raise InvalidFeatureError(f"the angle of isophotes is {beta}; give radians from 0 to pi")
    angle = np.arccos(np.clip(fishbone.normals @ (along / np.linalg.norm(along)), -1.0, 1.0))
    off = np.minimum(np.abs(angle - beta), np.abs(np.pi - angle - beta))
    return np.where(fishbone.valid, off, 0.0)


def weigh_nearness(fishbone: Fishbone, nearness: ArrayLike) -> Floats:
    """(m, k) weights of samples, 1 at the backbone; nearness: (m,) or one number."""
    width = np.broadcast_to(np.asarray(nearness, np.float64), len(fishbone.points))[:, None]
    if not (width > 0.0).all():
        raise InvalidFeatureError(f"the nearness of bends is {nearness}; give a positive length")
    rows = np.arange(fishbone.valid.shape[1]) - fishbone.backbone[:, None]
    return np.exp(-0.5 * (rows * fishbone.spacing[:, None] / width) ** 2)


def _reach(values: Floats, valid: NDArray[np.bool_]) -> float:
    return float(np.percentile(values[valid], PERCENTILE))


def scale_term(values: Floats, valid: NDArray[np.bool_], floor: float) -> Floats:
    """(m, k) values from 0 to 1, PERCENTILE of which is 1, inf where there is no sample; all 0 if
    that is below a floor."""
    reach = _reach(values, valid)
    scaled = np.clip(values / reach, 0.0, 1.0) if reach > floor else np.zeros_like(values)
    return np.where(valid, scaled, np.inf)
