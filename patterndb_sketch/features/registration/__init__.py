"""Curve networks, templates of quads that follow them, and templates laid onto models.

Read curvenetwork (drawn curves that meet), template, boxes (the built-in templates), mapping (the
membrane and the model's hits), register.
"""

from patterndb_sketch.features.registration.boxes import box_template, template_of_name
from patterndb_sketch.features.registration.curvenetwork import (
    CurveJoint,
    DrawnNetwork,
    FeatureNetwork,
    resolve_network,
)
from patterndb_sketch.features.registration.register import Feature, Registration, register
from patterndb_sketch.features.registration.template import (
    ChainStep,
    FeatureChain,
    Template,
    TemplatePart,
)

__all__ = [
    "ChainStep",
    "CurveJoint",
    "DrawnNetwork",
    "Feature",
    "FeatureChain",
    "FeatureNetwork",
    "Registration",
    "Template",
    "TemplatePart",
    "box_template",
    "register",
    "resolve_network",
    "template_of_name",
]
