"""Car-like bodies whose feature curves are known, clean and in the state that models come in."""

from patterndb_sketch.features.bodies.body import (
    COMPONENTS,
    Body,
    NamedCurve,
    body,
    build,
    random_body,
)
from patterndb_sketch.features.bodies.car import CARS, Car, random_car
from patterndb_sketch.features.bodies.degrade import EXTERIOR, INTERIOR, SURFACE, Mess, degrade
from patterndb_sketch.features.bodies.network import BOXES, CORNERS, Box, BoxEdge, BoxFace, Corner
from patterndb_sketch.features.bodies.strokes import stroke

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
