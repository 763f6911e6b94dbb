"""A rib: the model's outline in a plane across the curve, near the curve."""

from __future__ import annotations

from dataclasses import dataclass

from patterndb.geometry.points import Points


@dataclass(frozen=True, slots=True, eq=False)
class Rib:
    """Where a sample of the curve may move to.

    origin:   (3,) float64, the point of the backbone. axes: (3, 3) x, y and the unit normal of
              the rib's plane.
    polygon:  (p, 3) float64, points of cut edges and of changes between them; the last is the
              first again if ``closed``. It does not cross itself.
    points:   (n, 3) float64, samples of the polygon at equal arc length.
    normals:  (n, 3) float64 unit vectors in the plane, outward. Ribs run so that the cross
              product of their direction and the plane's normal is outward.
    backbone: the sample nearest to the origin; -1 if there is none.
    away:     how far the polygon is from the origin; inf without one.
    closed:   the whole outline lies within the radius; it is cut open opposite the origin.
    rounds:   of dilation and erosion, 0 if no picture was needed.
    joined:   did segments lose what hangs over at crossings, or were gaps between them bridged?
    reaches:  does the first, the last sample lie on the circle? If not, a sheet ends there, or
              the outline meets itself.
    note:     what is not as it should be, "" if all is.

    A rib without samples: the model has nothing within the radius.
    """

    origin: Points
    axes: Points
    polygon: Points
    points: Points
    normals: Points
    backbone: int
    away: float
    closed: bool
    rounds: int
    joined: bool
    reaches: tuple[bool, bool]
    note: str

    @property
    def repaired(self) -> bool:
        """Do segments cross or leave gaps, so that the rib is put together from several?"""
        return self.joined or self.rounds > 0

    def __len__(self) -> int:
        return len(self.points)
