"""The memory of this process: whether it may have enough, and what the C library keeps of it."""

from __future__ import annotations

import ctypes
import sys

from patterndb.errors import AddressSpaceError

#: Bytes of address space (ulimit -v) below which no verb is run: a query takes 240 MB at its peak,
#: and where OpenBLAS gets no memory (150 MB) it ends the process.
LEAST_ADDRESS_SPACE = 256 << 20


def refuse_small_address_space() -> None:
    """Raise AddressSpaceError where a limit leaves too little for a query."""
    if sys.platform == "win32":
        return
    import resource

    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < LEAST_ADDRESS_SPACE:
        raise AddressSpaceError(
            f"this process may use {limit >> 20} MB of address space (ulimit -v), and needs "
            f"{LEAST_ADDRESS_SPACE >> 20}; raise the limit"
        )


def return_freed_memory() -> None:
    """Give it back to the system, where the C library is told how (glibc's ``malloc_trim``).

    For after work whose many small and middling pieces are all gone: of half a gigabyte of them
    hundreds of megabytes stay otherwise.
    """
    if sys.platform != "linux":
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
