"""The small judge as cramlite sees it: LIBERO's connection, with another process behind it.

``SMALL_JUDGE`` holds words for that process: what shall go wrong, and when.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from cramlite.experiment.judged.judge import module_of
from cramlite_plugins.judges.judge_process import JudgeProcess

HERE = Path(__file__).parent
PATIENCE = 20.0
"""A judge that does not answer within this time hangs [s]; before its first answer it has six times as long."""
LIBERO = module_of(HERE.parents[2] / "experiments" / "libero" / "connection.py")


class SmallJudge(LIBERO.Libero):  # type: ignore[misc,name-defined]
    """LIBERO's connection to the small judge."""

    def __init__(self) -> None:
        command = [sys.executable, str(HERE / "judge.py"), *os.environ.get("SMALL_JUDGE", "").split()]
        JudgeProcess.__init__(self, command, "here", "libero_panda", 7, patience=float(os.environ.get("SMALL_PATIENCE", PATIENCE)))


def connect(environment: Path | None) -> SmallJudge:
    """Return the judge; it needs no environment."""
    del environment
    return SmallJudge()
