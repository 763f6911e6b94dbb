"""The flag by which a query is ended: a time limit, cancel() or Ctrl-C sets it.

The flag is a (1,) uint8 array, so that the compiled core, which holds no lock, sees it as well; 1
ends.
"""

from __future__ import annotations

from concurrent.futures import Future, wait
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.deadline import LOOK_SECONDS
from query.errors import QueryEndedError

#: (1,) uint8, 1 once nobody waits for the answer any more.
EndFlag = NDArray[np.uint8]

#: The flag of what nobody ends.
NEVER: EndFlag = np.zeros(1, np.uint8)


def refuse_if_ended(flag: EndFlag) -> None:
    """Raise QueryEndedError where the flag is set."""
    if flag[0]:
        raise QueryEndedError("the query was ended")


def wait_unless_ended(task: Future[Any], flag: EndFlag) -> bool:
    """Wait until a task is done, and return True; False as soon as the flag is set before that.

    Ctrl-C ends it as well. The task goes on then, and its caller sees that it comes to an end.
    """
    while not task.done():
        if flag[0]:
            return False
        wait([task], LOOK_SECONDS)
    return True
