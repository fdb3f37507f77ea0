"""Lock on an open file, released when its process ends, however it ends."""

from __future__ import annotations

import sys
from typing import IO

FAR = 2**30
"""Offset of the byte that is locked on Windows [byte]. It lies far beyond the file's content, since a locked byte cannot be read there."""

if sys.platform == "win32":
    import msvcrt

    def lock(file: IO[str]) -> None:
        """Lock a file for this process, without waiting.

        Raises:
            OSError: another process has it.
        """
        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        file.seek(0)

else:
    import fcntl

    def lock(file: IO[str]) -> None:
        """Lock a file for this process, without waiting.

        Raises:
            OSError: another process has it.
        """
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
