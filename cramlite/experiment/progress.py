"""Progress of an experiment in lines for people."""

from __future__ import annotations

import time
from collections.abc import Callable

from .results import DemonstrationResult


class Progress:
    """Progress report: a line for each demonstration, with the remaining time at this pace."""

    def __init__(self, total: int, left: int, say: Callable[[str], None]) -> None:
        self.total, self.left, self.say, self.begin, self.done = total, left, say, time.monotonic(), 0

    def one(self, result: DemonstrationResult) -> None:
        """Report one finished demonstration."""
        self.done += 1
        passed = time.monotonic() - self.begin
        rest = passed / self.done * (self.left - self.done)
        good = [sum(getattr(r, stage) for r in result.results) for stage in ("planned", "simulated", "succeeded")]
        self.say(
            f"[{self.total - self.left + self.done}/{self.total}] {result.name}: {result.candidates} candidates, "
            f"{'/'.join(map(str, good))} planned/simulated/executed{'; ' + result.reason if result.reason else ''}; "
            f"{clock(passed)} passed, about {clock(rest)} left"
        )


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"
