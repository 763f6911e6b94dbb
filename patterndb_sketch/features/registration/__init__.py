"""Feature curves that meet, templates of quads that follow them, and templates laid onto models.

Read joints (drawn curves that meet), template, boxes (the built-in templates), mapping (the
membrane and the model's hits), register.
"""

from patterndb_sketch.features.registration.boxes import box_template, template_of_name
from patterndb_sketch.features.registration.joints import (
    CurveJoint,
    FeatureCurves,
    JoinedFeatures,
    join_features,
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
    "Feature",
    "FeatureChain",
    "FeatureCurves",
    "JoinedFeatures",
    "Registration",
    "Template",
    "TemplatePart",
    "box_template",
    "join_features",
    "register",
    "template_of_name",
]
