"""The child process of :mod:`ingest.read.isolated`: ``python -m ingest.read.child vtk FILE``.

Writes the packed polygons to stdout, or exits with REFUSED and the reason there.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ingest.read.isolated import REFUSED, LibraryError, pack

# The libraries alone take up to 1.3 GiB of addresses, more with more cores; a mesh takes a few
# times its file's size, compressed ones more.
_ADDRESS_BYTES = 6 * 2**30
_ADDRESS_BYTES_PER_FILE_BYTE = 32


def main(library: str, path: str) -> int:
    # What a library prints must not end up in the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    _bound(Path(path).stat().st_size)
    try:
        if library == "vtk":
            from ingest.read.vtk import polygons
        else:
            from ingest.read.usd import polygons
        code, data = 0, pack(polygons(path))
    except LibraryError as error:
        code, data = REFUSED, str(error).encode("utf-8", "backslashreplace")
    with os.fdopen(answer, "wb") as pipe:
        pipe.write(data)
    return code


def _bound(file_bytes: int) -> None:
    """Bound this process's memory, where the system can, and leave no core files behind."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    wanted = _ADDRESS_BYTES + _ADDRESS_BYTES_PER_FILE_BYTE * file_bytes
    if most == resource.RLIM_INFINITY or wanted < most:
        resource.setrlimit(resource.RLIMIT_AS, (wanted, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    code = main(*sys.argv[1:])
    # Not sys.exit: the libraries' own clean-up may crash, with the answer already given.
    os._exit(code)
