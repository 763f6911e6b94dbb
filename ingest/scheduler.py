"""How a scheduler is named: the address of one, or so many processes of this machine.

Stands alone because a command line asks it before anything slow is imported.
"""

from __future__ import annotations

import re
import socket
from urllib.parse import urlsplit

from patterndb.errors import ClusterError

#: Seconds in which a machine that is there takes or refuses a connection.
CONNECT_SECONDS = 3.0

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


def reach_scheduler(address: str) -> None:
    """Raise ClusterError where nothing takes a connection at the address of a scheduler.

    Dask itself tries for as long as it waits for an answer.
    """
    parts = urlsplit(address)
    # Only Dask can connect by ucx.
    if parse_scheduler(address) is not None or parts.scheme == "ucx":
        return
    try:
        if parts.hostname is None:
            raise ValueError("there is no name of a machine in it")
        socket.create_connection((parts.hostname, parts.port or 0), CONNECT_SECONDS).close()
    except (OSError, ValueError) as error:
        raise explain_unreachable(address, error) from error


def explain_unreachable(address: str, error: Exception) -> ClusterError:
    """Explain that no scheduler answers."""
    return ClusterError(
        f"no Dask scheduler answers at {address}; start one ('dask scheduler'), or see to the "
        f"network between ({error})"
    )
