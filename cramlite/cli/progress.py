"""Progress of a long command, on standard error."""

from __future__ import annotations

import re
import sys
import time
from typing import TYPE_CHECKING

from ..planning.heartbeat import EVERY, NowDone

if TYPE_CHECKING:
    from rich.live import Live

SHOWN = ("candidate", "program", "twin", "writing", "executing")
"""First words of the events that are written to a log, where there is no terminal to draw on."""
STAYS = re.compile(r"program \d+ refused: ")
"""Events that stay on a terminal, above its line of progress."""
RAREST = 60.0
"""Longest pause between two progress lines in a log on the same work [s]; the first pauses are shorter, and each is twice as long as the
one before."""


class Progress:
    """Progress lines on standard error, with the time since the start; on a terminal each takes the place of the one before."""

    def __init__(self, *, quiet: bool) -> None:
        self._begin, self._quiet = time.monotonic(), quiet
        self._said, self._pause = self._begin, 0.0
        self._live = _live_line() if sys.stderr.isatty() and not quiet else None

    def __call__(self, text: str) -> None:
        line = f"[{time.monotonic() - self._begin:5.1f} s] {text}"
        if self._live is not None:
            from rich.text import Text

            if STAYS.match(text):
                self._live.console.print(Text(line))
            self._live.update(Text(line, no_wrap=True, overflow="ellipsis"), refresh=True)
        elif not self._quiet and self._is_due(text):
            print(line, file=sys.stderr, flush=True)

    def _is_due(self, text: str) -> bool:
        """Check whether a progress line is to be printed now, where the output is no terminal.

        An event is printed at once, lines about work that goes on at growing intervals.
        """
        now = time.monotonic()
        if not isinstance(text, NowDone):
            if text.startswith(SHOWN):
                self._said, self._pause = now, 0.0
                return True
            return False
        if now - self._said < self._pause:
            return False
        self._said, self._pause = now, min(RAREST, max(EVERY, 2 * self._pause))
        return True

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        """Clear the last progress line of a terminal, and show its cursor again."""
        if self._live is not None:
            self._live.stop()


def _live_line() -> Live:
    """Terminal line that is redrawn when its text changes, without a thread, since worker processes may be
    forked meanwhile."""
    from rich.console import Console
    from rich.live import Live

    line = Live(console=Console(stderr=True), auto_refresh=False, transient=True, redirect_stdout=False, redirect_stderr=False)
    line.start()
    return line
