"""The measures of a car: thirteen named ones, and any number of random ones."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from patterndb_sketch.features.errors import InvalidFeatureError

#: Random cars lie between the named ones, and beyond by at most this share of their spread.
BEYOND = 0.05

#: The lower edges of nose and tail lie this much behind the bumpers, in metres.
CHIN = 0.07


@dataclass(frozen=True, slots=True)
class Car:
    """The measures of a body, in metres. x points to the tail, from the front axle; heights are
    over the ground.

    wheelbase, front_overhang, rear_overhang, width, height: as in a data sheet.
    tyre_radius:  also the height of the axles.
    clearance:    height of the sill.
    nose_height, cowl_height, belt_height, tail_height: height of the shoulder line at the nose,
                  beside the windscreen's base, beside the rear window's base, at the tail.
    cowl, roof_front, roof_rear, rear_base: x of the lower and upper ends of the A-pillar, then of
                  the upper and lower ends of the C-pillar.
    tumblehome:   how far the roof rail lies further inside than the belt line.
    ledge:        width of the strip between the shoulder line and the belt line.
    nose_bow, tail_bow, screen_bow, rear_bow: how far the middles of the nose, the tail, the
                  windscreen and the rear window stand out beyond their sides.
    nose_rake, tail_rake: how far the upper edges of nose and tail lie behind the bumpers.
    nose_taper, tail_taper: width lost at each side of the nose and of the tail.
    hood_crown, roof_crown, side_bulge: rise of the middle of the surfaces over their borders.
    roof_fall:    how much lower the rail's rear end is than its highest part.
    bumper:       how far nose and tail stand out between their upper and lower edges.
    arch_radius:  of the wheel arches.
    edge:         width of the rounded edges, as a multiple of an ordinary car's; 0 gives creases.
    """

    wheelbase: float = 2.70
    front_overhang: float = 0.88
    rear_overhang: float = 1.05
    width: float = 1.80
    height: float = 1.45
    tyre_radius: float = 0.32
    clearance: float = 0.20
    nose_height: float = 0.74
    cowl_height: float = 0.96
    belt_height: float = 1.00
    tail_height: float = 0.97
    cowl: float = 0.55
    roof_front: float = 1.28
    roof_rear: float = 2.45
    rear_base: float = 3.08
    tumblehome: float = 0.16
    ledge: float = 0.06
    nose_bow: float = 0.20
    tail_bow: float = 0.13
    screen_bow: float = 0.18
    rear_bow: float = 0.12
    nose_rake: float = 0.10
    tail_rake: float = 0.06
    nose_taper: float = 0.11
    tail_taper: float = 0.08
    hood_crown: float = 0.05
    roof_crown: float = 0.05
    side_bulge: float = 0.06
    roof_fall: float = 0.035
    bumper: float = 0.06
    arch_radius: float = 0.37
    edge: float = 1.0

    def __post_init__(self) -> None:
        nose = self.nose_bow + self.nose_rake - self.front_overhang
        tail = self.wheelbase + self.rear_overhang - self.tail_bow - self.tail_rake
        order = (nose, self.cowl, self.roof_front, self.roof_rear, self.rear_base, tail)
        if any(b - a < 0.02 for a, b in pairwise(order)):
            raise InvalidFeatureError(
                f"nose, cowl, roof front, roof rear, rear window base and tail are at x = {order}:"
                " they must follow each other, at least 0.02 apart"
            )
        hood = self.cowl - self.screen_bow - (self.nose_rake - self.front_overhang)
        deck = self.wheelbase + self.rear_overhang - self.tail_rake
        deck -= self.rear_base + self.rear_bow
        if min(hood, deck) < 0.02:
            raise InvalidFeatureError(
                f"the hood is {hood:.3f} long in the middle and the deck {deck:.3f}: both need 0.02"
            )
        floor = self.tyre_radius + self.arch_radius + 0.02
        lowest = min(self.nose_height, self.tail_height)
        if lowest < floor or self.height < max(self.cowl_height, self.belt_height) + 0.1:
            raise InvalidFeatureError(
                f"the shoulder is as low as {lowest}: it must clear the wheel arches "
                f"({floor:.2f}), and the roof the shoulder by 0.1"
            )
        reach = self.arch_radius + 0.02
        chin = self.front_overhang - self.nose_bow - CHIN
        apron = self.rear_overhang - self.tail_bow - CHIN
        if min(chin, apron) < reach or self.wheelbase < 2.0 * reach:
            raise InvalidFeatureError(
                f"the arches reach {reach:.2f} from the axles: the sill's ends are {chin:.2f} and "
                f"{apron:.2f} away and the axles {self.wheelbase:.2f}; lengthen the overhangs"
            )
        if self.clearance > self.tyre_radius + 0.7 * self.arch_radius:
            raise InvalidFeatureError(
                f"the sill is {self.clearance} high: the wheel arches would be cut off"
            )
        if not 0.0 <= self.edge <= 2.5:
            raise InvalidFeatureError(f"edge is {self.edge}; give a number from 0 to 2.5")


CARS: dict[str, Car] = {
    "sedan": Car(),
    "hatchback": Car(
        wheelbase=2.58, front_overhang=0.84, rear_overhang=0.72, height=1.46, cowl=0.45,
        roof_front=1.16, roof_rear=2.70, rear_base=3.02, tail_height=0.98, belt_height=1.03,
        tail_rake=0.02, roof_fall=0.06, rear_bow=0.10, edge=1.2,
    ),
    "wagon": Car(
        wheelbase=2.78, rear_overhang=1.08, height=1.48, cowl=0.52, roof_front=1.26,
        roof_rear=3.38, rear_base=3.64, tail_rake=0.02, tail_height=1.0, roof_fall=0.05,
        tail_bow=0.09, rear_bow=0.07, edge=0.8,
    ),
    "coupe": Car(
        wheelbase=2.64, front_overhang=0.90, rear_overhang=0.98, width=1.82, height=1.34,
        nose_height=0.73, cowl_height=0.92, belt_height=0.95, tail_height=0.94, cowl=0.60,
        roof_front=1.28, roof_rear=2.05, rear_base=2.88, tumblehome=0.15, roof_fall=0.025,
        roof_crown=0.045, screen_bow=0.17, clearance=0.17, edge=1.1,
    ),
    "sports": Car(
        wheelbase=2.55, front_overhang=0.98, rear_overhang=0.82, width=1.92, height=1.18,
        tyre_radius=0.33, clearance=0.13, nose_height=0.715, cowl_height=0.83, belt_height=0.88,
        tail_height=0.87, cowl=0.48, roof_front=1.12, roof_rear=1.70, rear_base=2.34,
        tumblehome=0.13, ledge=0.09, nose_bow=0.34, nose_rake=0.20, nose_taper=0.17,
        hood_crown=0.07, screen_bow=0.16, rear_bow=0.08, roof_crown=0.03, roof_fall=0.008,
        arch_radius=0.36, bumper=0.03, tail_taper=0.06, edge=1.4,
    ),
    "suv": Car(
        wheelbase=2.80, front_overhang=0.86, rear_overhang=0.92, width=1.92, height=1.74,
        tyre_radius=0.38, clearance=0.34, nose_height=0.98, cowl_height=1.18, belt_height=1.24,
        tail_height=1.19, cowl=0.42, roof_front=1.12, roof_rear=3.10, rear_base=3.38,
        tumblehome=0.17, nose_rake=0.05, tail_rake=0.02, arch_radius=0.45, bumper=0.08,
        roof_fall=0.07, edge=1.0,
    ),
    "off-roader": Car(
        wheelbase=2.60, front_overhang=0.70, rear_overhang=0.72, width=1.82, height=1.88,
        tyre_radius=0.40, clearance=0.42, nose_height=1.10, cowl_height=1.19, belt_height=1.20,
        tail_height=1.20, cowl=0.40, roof_front=0.66, roof_rear=3.02, rear_base=3.14,
        tumblehome=0.07, ledge=0.07, nose_bow=0.06, tail_bow=0.04, screen_bow=0.06,
        rear_bow=0.03, nose_rake=0.02, tail_rake=0.01, nose_taper=0.06, tail_taper=0.03,
        hood_crown=0.02, roof_crown=0.03, side_bulge=0.02, roof_fall=0.01, bumper=0.03,
        arch_radius=0.47, edge=0.0,
    ),
    "van": Car(
        wheelbase=3.00, front_overhang=0.90, rear_overhang=0.95, width=1.95, height=1.96,
        tyre_radius=0.34, clearance=0.22, nose_height=0.92, cowl_height=1.12, belt_height=1.16,
        tail_height=1.13, cowl=-0.12, roof_front=0.70, roof_rear=3.62, rear_base=3.75,
        tumblehome=0.13, nose_bow=0.18, tail_bow=0.05, screen_bow=0.22, rear_bow=0.04,
        nose_rake=0.08, tail_rake=0.02, tail_taper=0.05, roof_fall=0.02, arch_radius=0.39,
        hood_crown=0.03, edge=1.3,
    ),
    "minivan": Car(
        wheelbase=2.85, front_overhang=0.90, rear_overhang=0.95, width=1.88, height=1.68,
        clearance=0.20, nose_height=0.82, cowl_height=1.06, belt_height=1.10, tail_height=1.06,
        cowl=0.08, roof_front=1.02, roof_rear=3.20, rear_base=3.62, tail_rake=0.02,
        nose_rake=0.12, screen_bow=0.22, roof_fall=0.07, tail_bow=0.08, rear_bow=0.08, edge=1.5,
    ),
    "pickup": Car(
        wheelbase=3.25, front_overhang=0.90, rear_overhang=1.15, width=1.90, height=1.78,
        tyre_radius=0.38, clearance=0.38, nose_height=1.03, cowl_height=1.16, belt_height=1.18,
        tail_height=1.14, cowl=0.55, roof_front=1.12, roof_rear=2.14, rear_base=2.28,
        tumblehome=0.16, ledge=0.07, nose_bow=0.12, tail_bow=0.03, rear_bow=0.03, nose_rake=0.04,
        tail_rake=0.01, tail_taper=0.02, nose_taper=0.07, side_bulge=0.04, roof_fall=0.03,
        hood_crown=0.03, arch_radius=0.46, bumper=0.04, edge=0.6,
    ),
    "city car": Car(
        wheelbase=2.00, front_overhang=0.66, rear_overhang=0.58, width=1.62, height=1.52,
        tyre_radius=0.29, clearance=0.19, nose_height=0.78, cowl_height=0.99, belt_height=1.04,
        tail_height=0.98, cowl=0.00, roof_front=0.74, roof_rear=2.00, rear_base=2.26,
        tail_rake=0.02, nose_rake=0.08, nose_bow=0.16, tail_bow=0.08, screen_bow=0.16,
        rear_bow=0.07, tumblehome=0.15, ledge=0.05, roof_fall=0.05, arch_radius=0.34, edge=1.7,
    ),
    "limousine": Car(
        wheelbase=3.85, front_overhang=0.92, rear_overhang=1.18, width=1.88, height=1.50,
        cowl=0.66, roof_front=1.36, roof_rear=3.52, rear_base=4.10, nose_height=0.78,
        cowl_height=1.0, belt_height=1.03, tail_height=1.0, roof_fall=0.05, side_bulge=0.05,
        bumper=0.07, edge=0.7,
    ),
    "fastback": Car(
        wheelbase=2.92, front_overhang=0.88, rear_overhang=0.98, width=1.90, height=1.40,
        clearance=0.17, tyre_radius=0.34, nose_height=0.75, cowl_height=0.96, belt_height=1.01,
        tail_height=1.00, cowl=0.42, roof_front=1.22, roof_rear=2.35, rear_base=3.22,
        tumblehome=0.15, screen_bow=0.18, roof_fall=0.03, roof_crown=0.045,
        tail_rake=0.03, arch_radius=0.385, bumper=0.04, edge=1.2,
    ),
}  # fmt: skip


def random_car(seed: int) -> Car:
    """A car between named ones: a random affine mixture of three of them, and some noise.

    Mixtures keep what the measures owe each other; one that does not is drawn again. The same
    seed gives the same car.
    """
    rng = np.random.default_rng(seed)
    names = [field.name for field in fields(Car)]
    table = np.array([[getattr(car, name) for name in names] for car in CARS.values()])
    low, high = table.min(axis=0), table.max(axis=0)
    margin = BEYOND * (high - low)
    while True:
        weights = rng.dirichlet(np.ones(3))
        chosen = rng.choice(len(table), 3, replace=False)
        values = weights @ table[chosen] + rng.normal(0.0, 0.02, len(names)) * (high - low)
        values = np.clip(values, low - margin, high + margin)
        values[names.index("edge")] = max(values[names.index("edge")], 0.0)
        try:
            return Car(**dict(zip(names, values.tolist(), strict=True)))
        except InvalidFeatureError:
            continue
