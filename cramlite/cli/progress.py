"""Progress of a long command, on standard error."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.live import Live

SHOWN = ("candidate", "refused", "twins", "writing", "executing", "searching", "planning")
"""How lines of progress begin that are written where there is no terminal to draw on."""


class Progress:
    """Progress lines on standard error, with the time since the start; on a terminal the last one stays, in its place."""

    def __init__(self, *, quiet: bool) -> None:
        self._begin, self._quiet = time.monotonic(), quiet
        self._live = _live_line() if sys.stderr.isatty() and not quiet else None

    def __call__(self, text: str) -> None:
        line = f"[{time.monotonic() - self._begin:5.1f} s] {text}"
        if self._live is not None:
            from rich.text import Text

            self._live.update(Text(line, no_wrap=True, overflow="ellipsis"), refresh=True)
        elif not self._quiet and text.startswith(SHOWN):
            print(line, file=sys.stderr, flush=True)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        """Clear the last progress line of a terminal, and show its cursor again."""
        if self._live is not None:
            self._live.stop()


def _live_line() -> Live:
    """A line that is drawn when it changes, by no thread: workers may be forked meanwhile."""
    from rich.console import Console
    from rich.live import Live

    line = Live(console=Console(stderr=True), auto_refresh=False, transient=True, redirect_stdout=False, redirect_stderr=False)
    line.start()
    return line
