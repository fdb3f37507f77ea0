"""Lines for people while a search is silent: what is tried, how often, and what refuses."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .diagnosis import nearest_miss
from .trace import Trace

EVERY = 5.0
"""Seconds of silence before a line."""

REFUSED = ("refused", "impossible", "failed")


@contextmanager
def heartbeat(trace: Trace, say: Callable[[str], None], every: float = EVERY) -> Iterator[Callable[[str], None]]:
    """Say what a search does whenever it has been silent, from a thread of its own.

    Args:
        trace: of the search, which fills it meanwhile.
        say: takes a line; it is called from that thread, too.
        every: seconds of silence.

    Yields:
        What the search says its own lines to; each begins the silence anew.
    """
    ended, last = threading.Event(), [time.monotonic()]

    def heard(text: str) -> None:
        last[0] = time.monotonic()
        say(text)

    def beat() -> None:
        while not ended.wait(max(0.05, last[0] + every - time.monotonic())):
            if time.monotonic() - last[0] >= every:
                heard(searching_text(trace))

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield heard
    finally:
        ended.set()
        thread.join()


def searching_text(trace: Trace) -> str:
    """Return a line on a search that goes on: what was asked last, how often it was, and what refuses most."""
    entries = list(trace.entries)
    asked = next((e for e in reversed(entries) if e.kind in ("action", "compound", "object", "location", "motion")), None)
    if asked is None:
        return "searching: no question was asked yet"
    times = sum(e.designator == asked.designator and e.outcome == "chosen" for e in entries)
    said = f"searching: {asked.designator}, tried {times} times in candidate {asked.candidate}; {len(entries)} decisions"
    reasons = Counter((e.reason, e.plugin) for e in entries if e.outcome in REFUSED)
    if not reasons:
        return f"{said}, none refused"
    ((reason, plugin), count), *_ = reasons.most_common(1)
    return f"{said}, {reasons.total()} refused, most often ({count}): {reason} [{plugin}]"


def interrupted_text(trace: Trace) -> str:
    """Return the nearest miss of a search that was interrupted."""
    miss = nearest_miss(trace.entries)
    found = "nothing was refused yet"
    if miss is not None:
        found = f"nearest miss: candidate {miss.candidate}, {miss.designator}: {miss.reason} [{miss.plugin}]"
    return f"the search was interrupted after {len(trace.entries)} decisions; {found}"
