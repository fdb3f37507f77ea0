"""Folder of problems that stands for a Python environment of LIBERO, in which they are the suite ``drawn``.

So any version of cramlite can be given the same problems: only the path of the environment is another one.
"""

from __future__ import annotations

import sys
from pathlib import Path

TEXT, STATE = "problem.bddl", "state.txt"
"""Files of a problem: as LIBERO has it, and its initial state."""
COPIED = Path("bin") / "launch.py"


def make_environment(folder: Path, python: str = sys.executable) -> None:
    """Make a folder of problems an environment, with ``bin/python``, that runs the benchmark on the Python of
    the benchmark's own environment."""
    launch = folder.resolve() / COPIED
    launch.parent.mkdir(parents=True, exist_ok=True)
    launch.write_bytes((Path(__file__).parent / "launch.py").read_bytes())
    script = launch.parent / "python"
    script.write_text(f'#!/bin/sh\nexec "{python}" "{launch}" "$@"\n', encoding="utf-8")
    script.chmod(0o755)
