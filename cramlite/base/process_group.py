"""Process groups: a process is ended with all child processes that it started (POSIX groups, Windows process trees)."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess


def begin_group() -> None:
    """Put this process into a group of its own, so that a terminal's Ctrl-C goes to the parent alone and
    all child processes can be ended with it. Windows has no such groups."""
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)


def end_group(pid: int) -> None:
    """End a process at once, with all processes that it started.

    Args:
        pid: of a process that began a group, or that was started in a session of its own.

    Raises:
        OSError: it has ended, or began no group.
    """
    if hasattr(os, "killpg"):
        os.killpg(pid, signal.SIGKILL)
    else:
        _end_tree(pid)


def _end_tree(pid: int) -> None:
    """End a process and its children by Windows' own command, which fails for a process that has ended."""
    ended = subprocess.run(["taskkill", "/F", "/T", "/PID", str(pid)], capture_output=True, check=False)
    if ended.returncode:
        raise ProcessLookupError(pid)


def end_own_group() -> None:
    """End this process at once, with all processes that it started."""
    with contextlib.suppress(OSError):
        end_group(os.getpid())
    os._exit(1)
