"""Bodies: the clean mesh of a car, with its named curves and the network that they form, and rough
strokes along them, as users draw them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from bodies.car import CARS, Car, random_car
from bodies.coons import MIRROR, Coons, blended, cut, grid_faces, weld
from bodies.curves import Kind, Line, Ridge, lines, rounded
from bodies.layout import Layout, joined, layout
from bodies.outline import Outline, outline
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.boxes import read_car

#: Components in the order of :attr:`Body.components`.
COMPONENTS = read_car().components

#: Vertices of neighbouring pieces are one if they are this near, in metres: they differ by the
#: rounding of numbers and by 1e-7 from feet on broken lines.
WELD = 2e-6

#: Samples of the smooth curves.
SMOOTH_SAMPLES = 401


@dataclass(frozen=True, slots=True, eq=False)
class NamedCurve:
    """A feature whose place is known.

    points:    (k, 3) float64, vertices of the clean mesh; its edges join them in turn. For a
               hidden curve, samples at equal parameters.
    radius:    (k,) float64, of the surface's cross-section on the curve: 0 where it is sharp,
               inf where the surface is smooth.
    smooth:    (m, 3) float64, the curve itself, densely; the mesh's edges are its chords.
    """

    name: str
    kind: Kind
    component: str
    points: Points = field(repr=False)
    radius: Floats = field(repr=False)
    smooth: Points = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A car-like body, clean: closed (a half is open in the plane y = 0 alone), oriented, welded.

    The origin is in the middle of the front axle; x points to the tail, y to the passenger's
    side, z up; metres. A half is the driver's, y <= 0.

    points:     (v, 3) float64. faces: (f, 4) int64 quads, counter-clockwise from outside.
    patches:    (f,) int64 into patch_names. components: (f,) int64 into COMPONENTS.
    features:   the named curves, of the half with y <= 0.
    corners:    by name, (3,) the points where curves meet.
    resolution, whole: what it was made with.
    """

    name: str
    car: Car
    points: Points = field(repr=False)
    faces: Int64Array = field(repr=False)
    patches: Int64Array = field(repr=False)
    patch_names: tuple[str, ...] = field(repr=False)
    components: Int64Array = field(repr=False)
    features: tuple[NamedCurve, ...] = field(repr=False)
    corners: dict[str, Points] = field(repr=False)
    resolution: float
    whole: bool

    @property
    def triangles(self) -> Int64Array:
        """(2 f, 3) int64: every quad cut along its shorter diagonal, its halves in turn."""
        return cut(self.points, self.faces)

    @property
    def diagonal(self) -> float:
        """Of the bounding box, in metres."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def feature(self, name: str) -> NamedCurve:
        """The named curve; raises InvalidFeatureError if there is none."""
        for curve in self.features:
            if curve.name == name:
                return curve
        known = ", ".join(curve.name for curve in self.features)
        raise InvalidFeatureError(f"a body has no curve {name!r}; it has {known}")


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """What a body is meshed from."""

    outline: Outline
    lines: tuple[Line, ...]

    def ridges(self, surface: Coons) -> list[Ridge]:
        """Of the curves along a surface."""
        every = [line.ridge for line in self.lines if line.ridge is not None]
        return [one for one in every if surface in one.surfaces]

    def at(self, surface: str, parameters: Floats) -> Points:
        """(..., 3) points of a finished surface, its edges rounded, at (..., 2) parameters."""
        base = self.outline.surfaces[surface]
        flat = parameters.reshape(-1, 2)
        points = rounded(base, base(flat), self.ridges(base))
        return points.reshape(*parameters.shape[:-1], 3)


@lru_cache(maxsize=32)
def shape(car: Car) -> Shape:
    """The curves and surfaces of a car; kept for the last few cars."""
    made = outline(car)
    return Shape(made, lines(made))


def build(car: Car, name: str = "", resolution: float = 1.0, whole: bool = False) -> Body:
    """The clean body of a car.

    resolution: a factor on the edges in every direction; 1 gives about 6000 triangles per half.
    whole:      both halves, welded in the plane y = 0, rather than the driver's alone.
    """
    if not 0.4 <= resolution <= 8.0:
        raise InvalidFeatureError(f"the resolution is {resolution}; give 0.4 to 8")
    made = shape(car)
    plan = layout(made.outline, resolution)
    points: list[Points] = []
    faces: list[Int64Array] = []
    offset = 0
    for piece in plan.pieces:
        sides = [plan.along(edge) for edge in (piece.bottom, piece.right, piece.top, piece.left)]
        parameters = blended(*(
            edge.path(t)
            for edge, t in zip(
                (piece.bottom, piece.right, piece.top, piece.left), sides, strict=True
            )
        ))  # fmt: skip
        points.append(made.at(piece.surface, parameters).reshape(-1, 3))
        flat = grid_faces(*parameters.shape[:2]) + offset
        faces.append(flat if made.outline.surfaces[piece.surface].outward > 0.0 else flat[:, ::-1])
        offset += len(points[-1])
    counts = [len(part) for part in faces]
    patches = np.repeat(np.arange(len(counts)), counts)
    components = np.array([COMPONENTS.index(piece.component) for piece in plan.pieces])
    welded, ids = weld(np.concatenate(points), WELD)
    every = ids[np.concatenate(faces)]
    welded[np.abs(welded[:, 1]) < WELD, 1] = 0.0
    if whole:
        count = len(welded)
        at, ids = weld(np.r_[welded, welded * MIRROR], WELD)
        every = np.r_[ids[every], ids[every + count][:, ::-1]]
        patches = np.r_[patches, patches]
        welded = at
    features = _features(made, plan)
    return Body(
        name, car, welded, every, patches, tuple(piece.name for piece in plan.pieces),
        components[patches], features, _corners(features), resolution, whole,
    )  # fmt: skip


def body(name: str, resolution: float = 1.0, whole: bool = False) -> Body:
    """One of the thirteen named bodies."""
    if name not in CARS:
        raise InvalidFeatureError(f"there is no car {name!r}; there are {', '.join(CARS)}")
    return build(CARS[name], name, resolution, whole)


def random_body(seed: int, resolution: float = 1.0, whole: bool = False) -> Body:
    """A body between the named ones; the same seed gives the same."""
    return build(random_car(seed), f"random {seed}", resolution, whole)


#: The samples of curves that are not sampled under their own names.
SAMPLED_AS = {
    "windscreen_base": "across", "roof_front": "across", "roof_rear": "across",
    "rear_window_base": "across", "a_pillar": "screen", "c_pillar": "screen",
    "windscreen_profile": "screen", "rear_window_profile": "screen",
    "roof_rail": "cabin", "belt_line": "cabin", "roof_profile": "cabin",
    "hood_profile": "hood", "deck_profile": "deck",
    "front_profile": "front_corner", "rear_profile": "rear_corner",
}  # fmt: skip


def _sampled(made: Shape, plan: Layout, line: Line) -> Floats:
    """The parameters of the curve's vertices."""
    if line.kind == "hidden":
        return np.linspace(0.0, 1.0, 41)
    if line.name in plan.samples:
        return plan.samples[line.name]
    if line.name in SAMPLED_AS:
        return plan.samples[SAMPLED_AS[line.name]]
    house, _, rest = line.name.partition("_")
    if rest == "inner_arch":
        return plan.samples[f"{house}_arch"]
    if rest == "inner_sill":
        return plan.samples[f"{house}_span"]
    if line.name == "bottom_profile":
        front, rear = made.outline.houses
        cuts = [0.0, *front.feet, *rear.feet, 1.0]
        names = ("sill_front", "front_span", "sill_middle", "rear_span", "sill_rear")
        return joined(cuts, [plan.samples[name] for name in names])
    return plan.samples["inwards"]


def _features(made: Shape, plan: Layout) -> tuple[NamedCurve, ...]:
    smooth = np.linspace(0.0, 1.0, SMOOTH_SAMPLES)
    result: list[NamedCurve] = []
    for line in made.lines:
        t = _sampled(made, plan, line)
        radius = np.full(len(t), np.inf)
        if line.ridge is not None:
            radius = np.interp(t, line.ridge.parameters, line.ridge.radius())
        points = line.at(t)
        points[np.abs(points[:, 1]) < WELD, 1] = 0.0
        curve = NamedCurve(line.name, line.kind, line.component, points, radius, line.at(smooth))
        result.append(curve)
    return tuple(result)


def _corners(features: tuple[NamedCurve, ...]) -> dict[str, Points]:
    by_name = {curve.name: curve for curve in features}
    return {
        corner: _meeting([by_name[name].points for name in names])
        for corner, names in read_car().corners.items()
    }


def _meeting(curves: list[Points]) -> Points:
    """Return the end of the first curve that lies nearest to the other curves of a corner."""
    first, *others = curves
    ends = first[[0, -1]]
    apart = sum(np.linalg.norm(ends[:, None] - other[None], axis=2).min(axis=1) for other in others)
    return ends[int(np.argmin(apart))]


#: A stroke has from FEWEST to MOST points, and begins and ends within this share of the length.
FEWEST, MOST = 4, 8
ENDS = 0.03


def stroke(body: Body, feature: str, error: float = 0.01, seed: int = 0) -> Points:
    """(k, 3) float64 points on the clean body near a feature, 4 to 8 of them in order.

    error: the greatest distance from the feature across it, as a share of the diagonal; a point
           is as far as a number drawn evenly up to it, then moves to the nearest surface point,
           which is nowhere farther from its foot on the feature than twice the error.
    Raises InvalidFeatureError for an unknown or hidden feature, or an error out of 0 to 0.1.
    """
    curve = body.feature(feature)
    if curve.kind == "hidden":
        raise InvalidFeatureError(f"the curve {feature!r} is hidden: nobody can draw along it")
    if not 0.0 <= error <= 0.1:
        raise InvalidFeatureError(f"the error {error} is not between 0 and 0.1 of the diagonal")
    rng = np.random.default_rng(seed)
    count = int(rng.integers(FEWEST, MOST + 1))
    total = float(arc_length(curve.points)[-1])
    inner = (np.arange(1, count - 1) + rng.uniform(-0.3, 0.3, count - 2)) / (count - 1)
    shares = np.r_[rng.uniform(0.0, ENDS), inner, 1.0 - rng.uniform(0.0, ENDS)]
    feet = at_lengths(curve.points, shares * total)
    step = 1e-3 * total
    ahead = at_lengths(curve.points, shares * total + step)
    behind = at_lengths(curve.points, shares * total - step)
    tangents = (ahead - behind) / np.linalg.norm(ahead - behind, axis=1, keepdims=True)
    across = rng.normal(size=(count, 3))
    across -= np.einsum("ij,ij->i", across, tangents)[:, None] * tangents
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    sizes = error * body.diagonal * rng.uniform(0.0, 1.0, count)
    return _surface(body).nearest(feet + sizes[:, None] * across).points


@lru_cache(maxsize=4)
def _surface(body: Body) -> Surface:
    """The body's triangles, made once for all strokes on it."""
    return Surface.from_arrays(body.points, body.triangles)
