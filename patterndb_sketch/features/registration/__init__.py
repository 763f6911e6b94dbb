"""Curve networks, templates of quads that follow them, and templates laid onto models."""

from patterndb_sketch.features.registration.boxes import box_template, template_of_name
from patterndb_sketch.features.registration.curvenetwork import CurveNetwork, DrawnNetwork, resolved
from patterndb_sketch.features.registration.meeting import Joint
from patterndb_sketch.features.registration.register import Feature, Registration, register
from patterndb_sketch.features.registration.template import Chain, Part, Step, Template

__all__ = [
    "Chain",
    "CurveNetwork",
    "DrawnNetwork",
    "Feature",
    "Joint",
    "Part",
    "Registration",
    "Step",
    "Template",
    "box_template",
    "register",
    "resolved",
    "template_of_name",
]
