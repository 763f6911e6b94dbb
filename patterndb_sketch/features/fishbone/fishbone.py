"""A fishbone: ribs across a backbone, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.errors import InvalidFeatureError


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

    Raises InvalidFeatureError for arrays that do not agree.
    """

    points: Points
    normals: Points
    valid: NDArray[np.bool_]
    backbone: NDArray[np.int64]
    ribs: NDArray[np.int64]
    origins: Points

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
            if _apart(points[i, ::-1], before) < _apart(points[i], before):
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
        """(m - 1,) the distances between the origins of neighbouring ribs."""
        return np.linalg.norm(np.diff(self.origins, axis=0), axis=1)

    def at(self, rows: NDArray[np.int64]) -> Points:
        """(m, 3) one sample of every rib."""
        return self.points[np.arange(len(self.points)), rows]


def _apart(points: Points, others: Points) -> float:
    return float(((points - others) ** 2).sum())
