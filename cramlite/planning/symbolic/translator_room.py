"""Memory use of Fast Downward's translator while it runs, read from Linux's folder /proc."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

UNITS = {"K": 10, "M": 20, "G": 30}
"""Suffix of a memory size, with its exponent of two."""
LEFT = 1 << 20
"""Python takes memory from the system in pieces of this size [bytes] (``ARENA_SIZE`` of CPython's ``obmalloc``)."""
PROCESSES = Path("/proc")


def is_full(group: int, room: str) -> bool:
    """Check whether Fast Downward's translator, one of a group of processes, has used up the memory that it
    may have.

    One was then seen to go on for six minutes in one line of its own, with requests for memory that all failed, instead of ending
    (Python 3.11; the cause is not known). False on systems without ``/proc``.

    Args:
        group: of processes.
        room: that it may have, such as "64M".
    """
    if not hasattr(os, "getpgid"):
        return False
    most = (int(room[:-1]) << UNITS[room[-1]]) - LEFT
    for place in PROCESSES.glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError):
            if os.getpgid(int(place.name)) == group and b"fast_downward.translate" in (place / "cmdline").read_bytes():
                return int((place / "statm").read_text(encoding="ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE") > most
    return False
