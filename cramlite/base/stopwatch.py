"""CPU time by stage, of this thread and of child processes that have ended."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


class Stopwatch:
    """Stopwatch of CPU time by stage [s]; the time of a stage inside another is counted for the inner
    stage only."""

    def __init__(self) -> None:
        self._spent: dict[str, float] = {}
        self._open: list[float] = []

    def restart(self) -> None:
        """Reset the CPU time of every stage to zero."""
        self._spent = {}

    def read(self) -> dict[str, float]:
        """Return the CPU time by stage [s]."""
        return {name: round(seconds, 3) for name, seconds in sorted(self._spent.items())}

    def add(self, stage: str, seconds: float) -> None:
        """Add the CPU time [s] that a process still running has spent on a stage."""
        self._spent[stage] = self._spent.get(stage, 0.0) + seconds

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the CPU time of a ``with`` block, without that of timed blocks inside it, to a stage's total."""
        begin = _now()
        self._open.append(0.0)
        try:
            yield
        finally:
            whole, inner = _now() - begin, self._open.pop()
            self.add(stage, whole - inner)
            if self._open:
                self._open[-1] += whole

    def over(self, stage: str, items: Iterable[T]) -> Iterator[T]:
        """Yield items, and add the CPU time of computing each to a stage."""
        rest = iter(items)
        while True:
            with self(stage):
                item = next(rest, None)
            if item is None:
                return
            yield item

    def around(self, wrapped: Any, **stages: str) -> Any:
        """Wrap an object so that the CPU time of some methods is counted; ``stages`` maps method to stage."""
        return _Timed(wrapped, self, stages)


class _Timed:
    def __init__(self, wrapped: Any, watch: Stopwatch, stages: dict[str, str]) -> None:
        self._wrapped, self._watch, self._stages = wrapped, watch, stages

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._wrapped, name)
        return _counted(found, self._watch, self._stages[name]) if name in self._stages else found


def _counted(function: Callable[..., Any], watch: Stopwatch, stage: str) -> Callable[..., Any]:
    def counted(*arguments: Any, **options: Any) -> Any:
        with watch(stage):
            return function(*arguments, **options)

    return counted


def _now() -> float:
    return time.thread_time() + _of_children()


if sys.platform == "win32":

    def _of_children() -> float:
        """CPU time of child processes that have ended [s]; 0 on Windows, which does not count it."""
        return 0.0

else:
    import resource

    def _of_children() -> float:
        """CPU time of child processes that have ended [s]."""
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return children.ru_utime + children.ru_stime
