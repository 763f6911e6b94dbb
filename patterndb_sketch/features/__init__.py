"""Feature curves of models of any quality: sketched, snapped, and registered to templates.

After the paper on a sketching interface for feature curve recovery of free-form surfaces.

Read splines (B-splines through samples), initial (a stroke's first curve), ribs (the model's
outlines across it), fishbone (what pulls the curve along its ribs, and the cut), snap (both
together), strokes and drag (what users do), registration (templates of quads laid on models along
curves), shapemodel (statistics of registered shapes), session and files (documents).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.files.networkjson import read_curves, write_curves
    from patterndb_sketch.features.files.shapearrays import read_shapes, write_shapes
    from patterndb_sketch.features.files.strokesjson import read_strokes
    from patterndb_sketch.features.registration.register import Registration, register
    from patterndb_sketch.features.registration.template import Template
    from patterndb_sketch.features.shapemodel.edit import ShapeEdit, edit, pull_feature
    from patterndb_sketch.features.shapemodel.model import ShapeModel
    from patterndb_sketch.features.snap import FeatureCurve, Snap, SnapSettings
    from patterndb_sketch.features.strokes import FeatureStroke, RecoveredCurve, recover_curve

__all__ = [
    "FeatureCurve",
    "FeatureStroke",
    "InvalidFeatureError",
    "RecoveredCurve",
    "Registration",
    "ShapeEdit",
    "ShapeModel",
    "Snap",
    "SnapSettings",
    "Template",
    "edit",
    "pull_feature",
    "read_curves",
    "read_shapes",
    "read_strokes",
    "recover_curve",
    "register",
    "write_curves",
    "write_shapes",
]

#: The module that defines each public name.
_HOMES = {
    "FeatureCurve": "patterndb_sketch.features.snap",
    "FeatureStroke": "patterndb_sketch.features.strokes",
    "InvalidFeatureError": "patterndb_sketch.features.errors",
    "RecoveredCurve": "patterndb_sketch.features.strokes",
    "Registration": "patterndb_sketch.features.registration.register",
    "ShapeEdit": "patterndb_sketch.features.shapemodel.edit",
    "ShapeModel": "patterndb_sketch.features.shapemodel.model",
    "Snap": "patterndb_sketch.features.snap",
    "SnapSettings": "patterndb_sketch.features.snap",
    "Template": "patterndb_sketch.features.registration.template",
    "edit": "patterndb_sketch.features.shapemodel.edit",
    "pull_feature": "patterndb_sketch.features.shapemodel.edit",
    "read_curves": "patterndb_sketch.features.files.networkjson",
    "read_shapes": "patterndb_sketch.features.files.shapearrays",
    "read_strokes": "patterndb_sketch.features.files.strokesjson",
    "recover_curve": "patterndb_sketch.features.strokes",
    "register": "patterndb_sketch.features.registration.register",
    "write_curves": "patterndb_sketch.features.files.networkjson",
    "write_shapes": "patterndb_sketch.features.files.shapearrays",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
