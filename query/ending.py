"""The flag by which a query is ended: a time limit, cancel() or Ctrl-C sets it.

The flag is a (1,) uint8 array, so that kernels, which hold no lock, see it as well; 1 ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from query.errors import QueryEndedError

#: (1,) uint8, 1 once nobody waits for the answer any more.
EndFlag = NDArray[np.uint8]

#: The flag of what nobody ends.
NEVER: EndFlag = np.zeros(1, np.uint8)


def refuse_if_ended(flag: EndFlag) -> None:
    """Raise QueryEndedError where the flag is set."""
    if flag[0]:
        raise QueryEndedError("the query was ended")
