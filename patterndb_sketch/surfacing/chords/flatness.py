"""How far from flat a piece of a cycle is: the spread of its vertices along three axes."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

#: How flatness is measured: "relative" to the whole cycle, or as "printed" in the paper.
Flatness = Literal["relative", "printed"]

#: A cycle is planar if it spreads across its plane by less than this share of its largest
#: spread: files keep some six digits.
PLANAR = 1e-6

#: The number of moments of a set of points: its size, 3 sums, 6 sums of products.
N_MOMENTS = 10

#: A piece is planar where, measured in the whole cycle's own spread, the variance across its
#: plane is below this. The moments carry errors of some 1e-15, of which the square root makes
#: 3e-8 at 0, but only 2e-10 here.
PLANAR_PIECE = 1e-11


def standardise(points: Points) -> tuple[Points, float]:
    """The points (n, 3) in axes in which their covariance is the unit matrix.

    Returns them and the determinant of their covariance, in units of length**6. If they are
    planar (PLANAR), points and determinant are 0.

    Ratios of determinants are the same in any axes; in these, the moments of every part are of
    the order of 1 and keep their digits, however flat, small or far away the points are.
    """
    own, determinant = _standardised(np.ascontiguousarray(points, np.float64))
    return own, float(determinant)


#: Sweeps over the off-diagonal elements: they converge in 5 to 8.
MOST_SWEEPS = 32


@kernel
def diagonalise(
    given: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The eigenvalues of a symmetric matrix (3, 3), ascending, and unit eigenvectors as columns.

    Source: the cyclic method of Jacobi (Golub and Van Loan 2013, section 8.5).
    """
    matrix = given.copy()
    vectors = np.zeros((3, 3))
    for d in range(3):
        vectors[d, d] = 1.0
    for _ in range(MOST_SWEEPS):
        if matrix[0, 1] == 0.0 and matrix[0, 2] == 0.0 and matrix[1, 2] == 0.0:
            break
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            element = matrix[p, q]
            if element == 0.0:
                continue
            ratio = (matrix[q, q] - matrix[p, p]) / (2.0 * element)
            size = 1.0 / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
            tangent = size if ratio >= 0.0 else -size
            cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
            sine = tangent * cosine
            matrix[p, p] -= tangent * element
            matrix[q, q] += tangent * element
            matrix[p, q] = matrix[q, p] = 0.0
            x, y = matrix[p, r], matrix[q, r]
            matrix[p, r] = matrix[r, p] = cosine * x - sine * y
            matrix[q, r] = matrix[r, q] = sine * x + cosine * y
            for d in range(3):
                x, y = vectors[d, p], vectors[d, q]
                vectors[d, p] = cosine * x - sine * y
                vectors[d, q] = sine * x + cosine * y
    values = np.array([matrix[0, 0], matrix[1, 1], matrix[2, 2]])
    for i, j in ((0, 1), (1, 2), (0, 1)):
        if values[j] < values[i]:
            values[i], values[j] = values[j], values[i]
            for d in range(3):
                vectors[d, i], vectors[d, j] = vectors[d, j], vectors[d, i]
    return values, vectors


@kernel
def _standardised(points: Points) -> tuple[Points, float]:
    n = len(points)
    own = points.copy()
    # Twice: far from the origin, the first mean is off by the digits that the distance costs.
    for _ in range(2):
        for d in range(3):
            mean = 0.0
            for i in range(n):
                mean += own[i, d] / n
            for i in range(n):
                own[i, d] -= mean
    size = 0.0
    for i in range(n):
        for d in range(3):
            size = max(size, abs(own[i, d]))
    if size == 0.0:
        return np.zeros((n, 3)), 0.0
    covariance = np.zeros((3, 3))
    for i in range(n):
        for d in range(3):
            own[i, d] /= size
        for d in range(3):
            for e in range(3):
                covariance[d, e] += own[i, d] * own[i, e] / n
    variances, axes = diagonalise(covariance)
    if variances[0] <= PLANAR**2 * variances[2]:
        return np.zeros((n, 3)), 0.0
    for i in range(n):
        x, y, z = own[i, 0], own[i, 1], own[i, 2]
        for d in range(3):
            along = x * axes[0, d] + y * axes[1, d] + z * axes[2, d]
            own[i, d] = along / math.sqrt(variances[d])
    return own, variances[0] * variances[1] * variances[2] * size**6


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


@kernel
def add_moments(moments: NDArray[np.float64], point: NDArray[np.float64]) -> None:
    """Add a point (3,) to the moments (10,)."""
    x, y, z = point[0], point[1], point[2]
    moments[0] += 1.0
    moments[1] += x
    moments[2] += y
    moments[3] += z
    moments[4] += x * x
    moments[5] += x * y
    moments[6] += x * z
    moments[7] += y * y
    moments[8] += y * z
    moments[9] += z * z


@kernel
def sum_moments(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(10,) moments of points (n, 3): how many, their sums, and the sums of their products."""
    moments = np.zeros(N_MOMENTS)
    for i in range(len(points)):
        add_moments(moments, points[i])
    return moments


@kernel
def find_determinant(moments: NDArray[np.float64]) -> float:
    """The determinant of the covariance that the moments (10,) have, 0 for a planar piece.

    The points must be in the axes of :func:`standardise`.
    """
    share = 1.0 / moments[0]
    x, y, z = moments[1] * share, moments[2] * share, moments[3] * share
    xx = moments[4] * share - x * x
    xy = moments[5] * share - x * y
    xz = moments[6] * share - x * z
    yy = moments[7] * share - y * y
    yz = moments[8] * share - y * z
    zz = moments[9] * share - z * z
    # The largest variance is eliminated first: what remains keeps its digits in needles, too.
    if yy > xx and yy >= zz:
        xx, yy, xz, yz = yy, xx, yz, xz
    elif zz > xx:
        xx, zz, xy, yz = zz, xx, yz, xy
    if xx <= 0.0:
        return 0.0
    a = yy - xy * xy / xx
    b = yz - xy * xz / xx
    c = zz - xz * xz / xx
    area = a * c - b * b
    # Divided by a + c, about the least variance where that is far below the others.
    if area <= PLANAR_PIECE * (a + c):
        return 0.0
    return xx * area
