"""URScript functions of time and chance.

Names and parameters: the URScript manual (e-Series 5.x), modules "internals" and "urmath".
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from .urscript.builtins import Library
from .urscript.values import ScriptError, StructValue, show


class Clock:
    """URScript's ``time`` and ``random``: the simulated time, and random numbers that are the same in every
    run.

    Args:
        clock: the time since the controller started [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock, self.chance = clock, random.Random(0)

    def library(self) -> Library:
        """Return the functions that a program may call."""
        return {"time": self.time, "random": self.random}

    def time(self, mode: Any = 0) -> StructValue:
        """Return the time since the controller started as struct(sec, nanosec); mode 2, which asks for the
        date on a real controller, gets the same."""
        if mode not in (0, 2):
            raise ScriptError(f"time's mode is 0 or 2, not {show(mode)}")
        seconds, nano = divmod(round(self.clock() * 1e9), 1_000_000_000)
        return StructValue(sec=seconds, nanosec=nano)

    def random(self) -> float:
        """Return a random number from 0 to 1; the random generator starts from the same seed in every run."""
        return self.chance.random()
