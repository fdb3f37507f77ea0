"""Progress of an experiment, printed as lines for people."""

from __future__ import annotations

import time
from collections.abc import Callable


class Progress:
    """Progress report: a line for each trial, with the remaining time estimated from the time passed so
    far."""

    def __init__(self, total: int, left: int, say: Callable[[str], None]) -> None:
        self.total, self.left, self.say, self.begin, self.done = total, left, say, time.monotonic(), 0

    def one(self, line: str) -> None:
        """Report one finished trial with the number done, the time passed and the time left."""
        self.done += 1
        passed = time.monotonic() - self.begin
        rest = passed / self.done * (self.left - self.done)
        count = f"[{self.total - self.left + self.done}/{self.total}]"
        self.say(f"{count} {line}; {clock(passed)} passed, about {clock(rest)} left")


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"
