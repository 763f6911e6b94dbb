"""Statistical shape models: principal components of registered shapes, edited by their curves."""

from patterndb_sketch.features.shapemodel.edit import Edit, edit, moved
from patterndb_sketch.features.shapemodel.errors import ErrorTable, error_table
from patterndb_sketch.features.shapemodel.model import ShapeModel

__all__ = ["Edit", "ErrorTable", "ShapeModel", "edit", "error_table", "moved"]
