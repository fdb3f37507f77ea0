"""Heartbeat of a search: every few seconds the search tells its current work, and asks whether the caller
wants it to end."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import TypeVar

from ..base.pulse import Pulse, Stop, Stopped, Work, pulse
from .diagnosis import nearest_miss
from .trace import Entry, Trace
from .what_to_try import what_to_try

T = TypeVar("T")
EVERY = 5.0
"""Time between two progress lines of a search [s]."""
ASKED_FOR = ("action", "compound", "object", "location", "motion")
REFUSED = ("refused", "impossible")
BEHIND = {"proof": "searching: what to do otherwise after the last program", "sequence": "searching: another sequence of tasks"}
"""Progress line after a program was refused or a task sequence ended, shown until the search resolves the next designator."""


class NowDone(str):
    """Progress line on the current work, which the next one replaces; lines of other types are events, and
    are shown once."""

    __slots__ = ()


class Heartbeat:
    """Heartbeat of a search: it tells progress, and asks whether to stop.

    Args:
        trace: of the search, which fills it meanwhile.
        say: takes a line for people; it is called from the thread that searches.
        stop: asked meanwhile; True ends the search.
        tasks: how many the sequence has that is tried; 0 where none is yet.
        every: seconds between two lines.
    """

    def __init__(
        self, trace: Trace, say: Callable[[str], None], stop: Stop, tasks: int = 0, every: float = EVERY
    ) -> None:
        self._trace, self._say, self._stop, self._tasks, self._every = trace, say, stop, tasks, every
        self._last = time.monotonic()

    def __call__(self) -> AbstractContextManager[Pulse]:
        """Return a context in which the caller is regularly told of progress and asked whether to stop."""
        return pulse(self._stop, self._tell)

    def over(self, items: Iterable[T]) -> Iterator[T]:
        """Yield the items of an iterable, with progress lines while each is computed; when the caller stops the
        search, the items end and the trace records it.

        Raises:
            Stopped: the work around this is to end.
        """
        rest = iter(items)
        while (item := self._next(rest)) is not None:
            yield item

    def _next(self, items: Iterator[T]) -> T | None:
        with self() as its:
            try:
                its.beat()
                return next(items, None)
            except Stopped:
                self._trace.stopped(its.ended_in.what if its.ended_in and self._tasks else "")  # else it plans
                if not self._stop():
                    raise
                return None

    def _tell(self, work: Work | None) -> None:
        now = time.monotonic()
        if now - self._last >= self._every:
            self._last = now
            self._say(NowDone(work or searching_text(self._trace, self._tasks)))


def searching_text(trace: Trace, tasks: int = 0) -> str:
    """Return a progress line of a search: the last question, and the most frequent reason of refusals since
    the last program or task sequence.

    Args:
        tasks: how many the sequence has that is tried; 0 where that is not known.
    """
    recent = _recent(trace.entries)
    asked = next((e for e in reversed(recent) if e.kind in ASKED_FOR), None)
    if asked is None:
        ended = trace.entries[-len(recent) - 1].kind if len(trace.entries) > len(recent) else ""
        return BEHIND.get(ended, "searching: no question was asked yet")
    task = next((e.numbers["task"] for e in reversed(recent) if "task" in e.numbers), 0)
    where = f", task {task:.0f} of {tasks}" if task and tasks else ""
    said = f"searching: {asked.designator}{where}, candidate {asked.candidate}; {len(trace.entries)} decisions"
    total, most = _refused(recent)
    return f"{said}; refused {total} times, {most}" if total else said


def _recent(entries: list[Entry]) -> list[Entry]:
    """Return the trace entries after the last program that ran or task sequence that ended, whichever is
    later."""
    entries = list(entries)
    ends = (k for k in range(len(entries) - 1, -1, -1) if entries[k].kind in ("proof", "sequence"))
    return entries[next(ends, -1) + 1 :]


def _on_the_way(entries: Iterable[Entry]) -> str:
    """Return words on how many alternatives were refused before a program ran, and the most frequent reason;
    "" if none."""
    total, most = _refused(entries)
    return f"; {total} alternatives were refused before it ran, {most}" if total else ""


def _refused(entries: Iterable[Entry]) -> tuple[int, str]:
    """Return the number of refused alternatives, and the most frequent reason."""
    reasons = Counter((e.reason, e.plugin) for e in entries if e.outcome in REFUSED)
    if not reasons:
        return 0, ""
    ((reason, plugin), count), *_ = reasons.most_common(1)
    return reasons.total(), f"most often ({count}): {reason} [{plugin}]"


def interrupted_text(trace: Trace) -> str:
    """Describe an interrupted search: the work that it was at, its nearest miss, and a remedy.

    Once a program runs, only programs count as misses; before, the number of refusals is told.
    """
    runs = next((e.text for e in trace.entries if e.kind == "stop" and e.text), "")
    entries = [e for e in trace.entries if e.kind == "proof" or not runs]
    miss = nearest_miss(entries)
    found = f"no program was refused yet{_on_the_way(trace.entries)}" if runs else "nothing was refused yet"
    if miss is not None:
        found = f"nearest miss: candidate {miss.candidate}, {miss.designator}: {miss.reason} [{miss.plugin}]"
    tries = "".join(f"\n  To try: {said}" for said in what_to_try(entries, 1))
    where = f" ({runs})" if runs else ""
    return f"the search was interrupted after {len(trace.entries)} decisions{where}; {found}{tries}"
