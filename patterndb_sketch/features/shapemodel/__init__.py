"""Statistical shape models: principal components of registered shapes, edited by their curves.

Read model, then edit.
"""

from patterndb_sketch.features.shapemodel.edit import ShapeEdit, edit, pull_feature
from patterndb_sketch.features.shapemodel.model import ErrorTable, ShapeModel, measure_errors

#: The name that the guide showed.
moved = pull_feature

__all__ = [
    "ErrorTable",
    "ShapeEdit",
    "ShapeModel",
    "edit",
    "measure_errors",
    "moved",
    "pull_feature",
]
