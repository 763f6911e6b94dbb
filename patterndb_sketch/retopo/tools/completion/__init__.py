"""Autocompletion: the patches that close against the boundaries around the cursor.

:mod:`.sequence` cuts the boundaries down to a window, :mod:`.cases` has the patch that each
configuration of corners suggests, and :mod:`.suggest` the list of those that can be, largest
first, all in the plane of a local parameterisation (:mod:`patterndb_sketch.retopo.tools.plane`). :mod:`.tool`
takes it from the ground there and back into the network.
"""

from patterndb_sketch.retopo.tools.completion.cases import Suggestion, suggestion
from patterndb_sketch.retopo.tools.completion.sequence import Sequence, Window, sequences
from patterndb_sketch.retopo.tools.completion.suggest import suggested, suggestions
from patterndb_sketch.retopo.tools.completion.tool import (
    Completion,
    autocomplete,
    complete,
    completions,
)

__all__ = [
    "Completion",
    "Sequence",
    "Suggestion",
    "Window",
    "autocomplete",
    "complete",
    "completions",
    "sequences",
    "suggested",
    "suggestion",
    "suggestions",
]
