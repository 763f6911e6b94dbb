"""Car-like bodies whose feature curves are known, clean and in the state that models come in.

Examples, tests and benchmarks recover those curves. A program finds this package if the folder
examples/ is on its path. Read car (the measures), coons (curves and surfaces of any kind), outline
(those of a car), curves (the named curves and their rounding), layout (the pieces that are meshed),
body (the clean mesh, and strokes on it), clutter and degrade (the faults that found models have).
The network of named curves is that of the box templates
(:mod:`patterndb_sketch.features.registration.boxes`).
"""

from bodies.body import COMPONENTS, Body, NamedCurve, body, build, random_body, stroke
from bodies.car import CARS, Car, random_car
from bodies.degrade import EXTERIOR, INTERIOR, SURFACE, Mess, degrade

__all__ = [
    "CARS",
    "COMPONENTS",
    "EXTERIOR",
    "INTERIOR",
    "SURFACE",
    "Body",
    "Car",
    "Mess",
    "NamedCurve",
    "body",
    "build",
    "degrade",
    "random_body",
    "random_car",
    "stroke",
]
