"""The editor: what a window, a script and a test drive.

:mod:`.editor` has the state and its history, :mod:`.table` the tools that calls name,
:mod:`.arguments` what they may say.
"""

from patterndb_sketch.retopo.editor.editor import Call, Editor, Outcome
from patterndb_sketch.retopo.editor.table import TOOLS
from patterndb_sketch.retopo.state import DEPTH, State

__all__ = ["DEPTH", "TOOLS", "Call", "Editor", "Outcome", "State"]
