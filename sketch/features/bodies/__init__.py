"""Car-like bodies whose feature curves are known, clean and in the state that models come in."""

from sketch.features.bodies.body import (
    COMPONENTS,
    Body,
    NamedCurve,
    body,
    build,
    random_body,
)
from sketch.features.bodies.car import CARS, Car, random_car
from sketch.features.bodies.degrade import EXTERIOR, INTERIOR, SURFACE, Mess, degrade
from sketch.features.bodies.network import BOXES, CORNERS, Box, BoxEdge, BoxFace, Corner
from sketch.features.bodies.strokes import stroke

__all__ = [
    "BOXES",
    "CARS",
    "COMPONENTS",
    "CORNERS",
    "EXTERIOR",
    "INTERIOR",
    "SURFACE",
    "Body",
    "Box",
    "BoxEdge",
    "BoxFace",
    "Car",
    "Corner",
    "Mess",
    "NamedCurve",
    "body",
    "build",
    "degrade",
    "random_body",
    "random_car",
    "stroke",
]
