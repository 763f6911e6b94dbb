"""A fishbone: ribs across a backbone, as arrays, and synchronised: rows are shifted so that a row
runs along the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.features.fishbone.fishbone import carry_backbone
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.errors import InvalidFeatureError

#: A rib is of another sheet if its nearest sample is so many times as far from the backbone
#: sample before it as its origin is from the origin there.
STRAYED = 4.0


class RibLike(Protocol):
    """What a fishbone takes of a rib."""

    @property
    def origin(self) -> Points:
        """(3,) the point of the backbone."""
        ...

    @property
    def points(self) -> Points:
        """(k, 3) samples at equal steps along the contour."""
        ...

    @property
    def normals(self) -> Points:
        """(k, 3) unit normals there."""
        ...

    @property
    def backbone(self) -> int:
        """The sample nearest to where the backbone meets the rib."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Fishbone:
    """Ribs along a curve: one column of samples each, in rows that belong together.

    points:   (m, k, 3) float64, samples at equal steps along every rib; 0 where not valid.
    normals:  (m, k, 3) float64 unit normals, of one side of the surface; 0 where not valid.
    valid:    (m, k) bool, is there a sample? In each rib one run, which holds its backbone.
    backbone: (m,) int64, the row of the sample that the curve runs through.
    ribs:     (m,) int64, ascending, the numbers of the ribs: those that failed are not there.
    origins:  (m, 3) float64, where the ribs' planes meet the curve, which may be off the model.
    seam:     of a closed curve, how far rows are shifted from the last rib to the first: row r of
              the last goes on as row r + seam of the first. None of a curve with ends.

    Raises InvalidFeatureError for arrays that do not agree.
    """

    points: Points
    normals: Points
    valid: NDArray[np.bool_]
    backbone: NDArray[np.int64]
    ribs: NDArray[np.int64]
    origins: Points
    seam: int | None = None

    def __post_init__(self) -> None:
        m, k = self.valid.shape
        if not m:
            raise InvalidFeatureError("a fishbone needs at least one rib")
        if self.points.shape != (m, k, 3) or self.normals.shape != (m, k, 3):
            raise InvalidFeatureError(
                f"a fishbone of {m} ribs with {k} rows has points {self.points.shape} and "
                f"normals {self.normals.shape}; both must be ({m}, {k}, 3)"
            )
        if not self.backbone.shape == self.ribs.shape == (m,) or self.origins.shape != (m, 3):
            raise InvalidFeatureError(
                f"give a backbone row, number and origin for each of {m} ribs"
            )
        if not ((self.backbone >= 0) & (self.backbone < k)).all():
            raise InvalidFeatureError(f"a fishbone's backbone leaves its rows 0..{k - 1}")
        broken = np.diff(self.valid.astype(np.int8), axis=1, prepend=0) > 0
        wrong = (broken.sum(axis=1) != 1) | ~self.valid[np.arange(m), self.backbone]
        if wrong.any():
            raise InvalidFeatureError(
                f"the samples of rib {self.ribs[np.argmax(wrong)]} are not one run with its "
                "backbone sample in it"
            )

    @classmethod
    def from_ribs(cls, ribs: Sequence[RibLike | None]) -> Fishbone:
        """From ribs of equal counts of samples; None for one that failed.

        Contours of open models have no sense of their own: each rib runs the way of the one
        before, and its normals are on the same side.

        Raises InvalidFeatureError if all failed, or if counts differ.
        """
        there = [(i, rib) for i, rib in enumerate(ribs) if rib is not None]
        if not there:
            raise InvalidFeatureError(
                f"none of the {len(ribs)} ribs meets the model near the curve; draw the stroke "
                "on the surface, or make the radius larger"
            )
        counts = {len(rib.points) for _, rib in there}
        if len(counts) > 1:
            raise InvalidFeatureError(f"ribs have {sorted(counts)} samples; all must have the same")
        points = np.stack([rib.points for _, rib in there]).astype(np.float64)
        normals = np.stack([rib.normals for _, rib in there]).astype(np.float64)
        backbone = np.array([rib.backbone for _, rib in there], np.int64)
        last = points.shape[1] - 1
        for i in range(1, len(points)):
            before = points[i - 1]
            if _squared_distance(points[i, ::-1], before) < _squared_distance(points[i], before):
                points[i], normals[i] = points[i, ::-1].copy(), normals[i, ::-1].copy()
                backbone[i] = last - backbone[i]
            if np.einsum("kc,kc->", normals[i], normals[i - 1]) < 0.0:
                normals[i] *= -1.0
        valid = np.ones(points.shape[:2], np.bool_)
        numbers = np.array([i for i, _ in there], np.int64)
        origins = np.stack([rib.origin for _, rib in there]).astype(np.float64)
        return cls(points, normals, valid, backbone, numbers, origins)

    @property
    def first(self) -> NDArray[np.int64]:
        """(m,) the first row of every rib."""
        return np.argmax(self.valid, axis=1).astype(np.int64)

    @property
    def stop(self) -> NDArray[np.int64]:
        """(m,) the row after the last of every rib."""
        return (self.valid.shape[1] - np.argmax(self.valid[:, ::-1], axis=1)).astype(np.int64)

    @property
    def spacing(self) -> Floats:
        """(m,) the mean step between neighbouring samples of every rib."""
        steps = np.linalg.norm(np.diff(self.points, axis=1), axis=2)
        steps[~(self.valid[:, 1:] & self.valid[:, :-1])] = 0.0
        return steps.sum(axis=1) / np.maximum(self.valid.sum(axis=1) - 1, 1)

    @property
    def gaps(self) -> Floats:
        """(m - 1,) the distances between the origins of neighbouring ribs; of a closed curve (m,),
        the last from the last rib to the first."""
        return np.linalg.norm(np.diff(self._around(self.origins), axis=0), axis=1)

    @property
    def steps(self) -> Floats:
        """(m - 1,), or (m,) as gaps: the mean step between samples of neighbouring ribs."""
        spacing = self._around(self.spacing)
        return (spacing[1:] + spacing[:-1]) / 2.0

    @property
    def arcs(self) -> Floats:
        """(m,) how far along the curve each rib is."""
        return np.r_[0.0, np.cumsum(self.gaps)][: len(self.points)]

    def measure_along(self, others: NDArray[np.int64]) -> Floats:
        """(m, p) how far ribs are along the curve from others (p,), of a closed one the shorter way
        round."""
        arcs = self.arcs
        away = np.abs(arcs[:, None] - arcs[others])
        return away if self.seam is None else np.minimum(away, self.gaps.sum() - away)

    def _around(self, values: Floats) -> Floats:
        """Values of ribs; of a closed curve the first once more."""
        return values if self.seam is None else np.concatenate([values, values[:1]])

    def at(self, rows: NDArray[np.int64]) -> Points:
        """(m, 3) one sample of every rib."""
        return self.points[np.arange(len(self.points)), rows]


def _squared_distance(points: Points, others: Points) -> float:
    return float(((points - others) ** 2).sum())


def synchronise(fishbone: Fishbone, start: int | None = None, *, closed: bool = False) -> Fishbone:
    """The fishbone with its ribs shifted, so that all backbone samples have one row.

    closed: the last rib is beside the first: the fishbone gets a seam, unless the surface turns
            over all the way round, as a Moebius strip does.

    From rib ``start`` both ways: the sample of the next rib nearest to the backbone sample
    becomes the backbone sample there. Rows that ribs do not reach after the shift are not valid:
    there are as many rows as the shifted ribs cover. By default the start is the rib closest to
    the middle from which the fewest ribs stray.

    Ribs that stray are left out: beyond the end of a surface, planes meet other sheets alone.

    Source: feature curve recovery paper, section 4.3.3 and figure 6. Differs from the paper:
    it does not say what becomes of rows that a shift leaves empty, and of ribs on other sheets.
    """
    m = len(fishbone.points)
    if start is not None and not 0 <= start < m:
        raise InvalidFeatureError(f"the start of ribs is {start}; there are ribs 0..{m - 1}")
    starts = (start,) if start is not None else tuple(m * k // 8 for k in (4, 3, 5, 2, 6, 1, 7))
    rows, kept = fishbone.backbone, np.zeros(m, np.bool_)
    for begin in starts:
        trial = carry_backbone(
            fishbone.points, fishbone.first, fishbone.stop, fishbone.backbone,
            fishbone.origins, begin, STRAYED,
        )  # fmt: skip
        if (trial >= 0).sum() > kept.sum():
            rows, kept = trial, trial >= 0
        if kept.sum() > m // 2:
            break
    first, stop = (fishbone.first - rows)[kept], (fishbone.stop - rows)[kept]
    low, n_rows = int(first.min()), int(stop.max() - first.min())
    m = len(first)
    points = np.zeros((m, n_rows, 3))
    normals = np.zeros((m, n_rows, 3))
    valid = np.zeros((m, n_rows), np.bool_)
    for i, old in enumerate(np.flatnonzero(kept)):
        here = slice(int(first[i]) - low, int(stop[i]) - low)
        there = slice(int(fishbone.first[old]), int(fishbone.stop[old]))
        points[i, here] = fishbone.points[old, there]
        normals[i, here] = fishbone.normals[old, there]
        valid[i, here] = True
    backbone = np.full(m, -low, np.int64)
    seam = _find_seam(points, valid, -low) if closed else None
    return Fishbone(
        points, normals, valid, backbone, fishbone.ribs[kept], fishbone.origins[kept], seam
    )


def _find_seam(points: Points, valid: NDArray[np.bool_], backbone: int) -> int | None:
    """Rows from the backbone of the first rib to the sample nearest to that of the last; None if
    the two ribs run opposite ways."""
    both = np.flatnonzero(valid[0] & valid[-1])
    if len(both) > 1:
        along = [points[i, both[-1]] - points[i, both[0]] for i in (0, -1)]
        if float(along[0] @ along[1]) < 0.0:
            return None
    away = np.linalg.norm(points[0] - points[-1, backbone], axis=1)
    return int(np.argmin(np.where(valid[0], away, np.inf))) - backbone
