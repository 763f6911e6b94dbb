"""Statistical shape models: principal components of registered shapes, edited by their curves.

Read model, then edit, and shaping (a shape while it is made: pulls, what is held, the way back).
"""

from patterndb_sketch.features.shapemodel.edit import ShapeEdit, edit, pull_feature
from patterndb_sketch.features.shapemodel.model import ErrorTable, ShapeModel, measure_errors

__all__ = [
    "ErrorTable",
    "ShapeEdit",
    "ShapeModel",
    "edit",
    "measure_errors",
    "pull_feature",
]
