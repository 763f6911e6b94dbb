"""How a scheduler is named: the address of one, or so many processes of this machine.

Stands alone because a command line asks it before anything slow is imported.
"""

from __future__ import annotations

import re

_ADDRESS = re.compile(r"(?:tcp|tls|ucx|ws|wss)://\S+:[0-9]+")
_LOCAL = re.compile(r"local:([0-9]{1,4})")


def parse_scheduler(text: str) -> int | None:
    """The number of processes that ``local:N`` asks for, or None for the address of a scheduler.

    Raises ValueError for what is neither.
    """
    local = _LOCAL.fullmatch(text)
    if local and int(local[1]):
        return int(local[1])
    if not _ADDRESS.fullmatch(text):
        raise ValueError(
            f"{text!r} is no scheduler; give an address like tcp://10.0.0.5:8786, or local:4 for "
            "processes of this machine"
        )
    return None
