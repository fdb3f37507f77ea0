"""Interruption and progress of long work: the work asks regularly whether to stop, and reports what it is doing.

Whoever wants to end work passes a function that says so (``pulse``); what takes long calls ``checkpoint`` several times a
second, however deep it is. Nothing but the end of the work depends on it: decisions are the same with and without.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from msgspec import Struct

T = TypeVar("T")
Stop = Callable[[], bool]
ASKED = 0.05
"""Shortest time between two checks whether the work must stop [s]: a twentieth of the second within which work must end."""


class Stopped(BaseException):
    """Exception that is raised inside long work to end it, because the caller no longer wants its result.

    It is no ``Exception``, so that no code takes it for a plugin's defect.
    """


class Work(Struct):
    """Description of the current work, with how much of it is done.

    Args:
        what: in words, such as "program 2 runs".
        whole: how long it is in all, about [s of simulated time]; 0 where that is not known.
        ends: when it will be over, about [s of ``time.monotonic``]; None where that is not known.
        at: how much of ``whole`` is done [s of simulated time].
    """

    what: str
    whole: float = 0.0
    ends: float | None = None
    at: float = 0.0

    def __str__(self) -> str:
        if self.ends is not None:
            return f"{self.what}, about {max(1.0, self.ends - time.monotonic()):.0f} s left"
        if self.whole == 0:
            return self.what
        return f"{self.what}, {max(0.0, self.at):.0f} of about {max(self.whole, self.at):.0f} s"


class Pulse:
    """Checkpoints of one thread's work: at each, the work asks whether it must stop, and reports its progress.

    Args:
        stop: asked at checkpoints; True ends the work.
        tell: called at checkpoints with what is done now.
        outer: that of the work around this one, whose end is the end of both.

    ``ended_in`` is the work that was under way when it was stopped; None where nobody had said any, or it was not.
    """

    def __init__(self, stop: Stop, tell: Callable[[Work | None], None], outer: Pulse | None = None) -> None:
        self._stop, self._tell, self._outer = stop, tell, outer
        self._next = 0.0
        self.work: Work | None = None
        self.ended_in: Work | None = None

    def asked_to_stop(self) -> bool:
        """Check whether this work, or the work of which it is a part, is to stop."""
        return self._stop() or (self._outer is not None and self._outer.asked_to_stop())

    def beat(self) -> None:
        """Raise ``Stopped`` if the work is to stop, else report its progress; at most once every ``ASKED`` seconds.

        Raises:
            Stopped: the work is to end.
        """
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + ASKED
        if self.asked_to_stop():
            self.ended_in = self.work
            raise Stopped
        self._tell(self.work)


_PULSE: ContextVar[Pulse | None] = ContextVar("pulse", default=None)


@contextmanager
def pulse(stop: Stop, tell: Callable[[Work | None], None] = lambda _: None) -> Iterator[Pulse]:
    """Let the work in this block be stopped by one function, and report its progress to another one.

    Inside a generator no ``yield`` may be in the block.

    Args:
        stop, tell: as ``Pulse`` has them.
    """
    its = Pulse(stop, tell, _PULSE.get())
    before = _PULSE.set(its)
    try:
        yield its
    finally:
        _PULSE.reset(before)


@contextmanager
def working(what: str, whole: float = 0.0, ends: float | None = None) -> Iterator[None]:
    """Describe the work of this thread inside a ``with`` block, for the thread's progress reports.

    The arguments are the fields of ``Work``.
    """
    its = _PULSE.get()
    if its is None:
        yield
        return
    before, its.work = its.work, Work(what, whole, ends)
    try:
        yield
    finally:
        its.work = before


def checkpoint(at: float | None = None) -> None:
    """Raise ``Stopped`` if the work is to end; work that takes longer than a tenth of a second must call this regularly.

    Args:
        at: how much of the work is done [s of simulated time]; None where that is not known.

    Raises:
        Stopped: the work is to end.
    """
    its = _PULSE.get()
    if its is None:
        return
    if at is not None and its.work is not None:
        its.work.at = at
    its.beat()


def stop_asked() -> bool:
    """Check whether the work is to end, for callers that must not be left by an exception, such as callbacks of libraries."""
    its = _PULSE.get()
    return its is not None and its.asked_to_stop()


def awaited(future: Future[T]) -> T:
    """Wait for the result of another thread or process, and return it.

    Raises:
        Stopped: the work is to end; the future is cancelled if it has not begun.
    """
    try:
        while not wait((future,), ASKED).done:
            checkpoint()
    except Stopped:
        future.cancel()
        raise
    return future.result()
