"""Process of Fast Downward's driver, run as a script: it ends, with all its children, when its parent does.

    python driver_process.py DRIVER ARGUMENTS...

Its standard input is a pipe that only that process could write to, whose end thus comes with the end of that process.
"""

from __future__ import annotations

import os
import runpy
import sys
import threading
from pathlib import Path


def _follow() -> None:
    """Wait for the end of standard input, then end this process and its children."""
    while os.read(0, 1):
        pass
    end_own_group()


if __name__ == "__main__":
    driver = sys.argv[1]
    sys.path[0] = str(Path(driver).parent)
    from cramlite.base.process_group import end_own_group

    threading.Thread(target=_follow, daemon=True).start()
    sys.argv = sys.argv[1:]
    runpy.run_path(driver, run_name="__main__")
