"""Executing processes that share a list of runs; the answers come in the order of the list, for any number of processes."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from queue import SimpleQueue
from typing import TYPE_CHECKING, TypeVar

from ..base.errors import UserError
from ..base.pulse import awaited
from ..plugin.selection import PluginChoice
from .executor import Executor, ExecutorDied

if TYPE_CHECKING:
    from ..model.rollout import Rollout
    from ..model.world import World

DEATHS = 2
"""A run whose process died this often is given up."""
T = TypeVar("T")


def processes_here() -> int:
    """Return how many processes can work at once on this machine."""
    own = getattr(os, "sched_getaffinity", None)  # not everywhere
    return len(own(0)) if own is not None else os.cpu_count() or 1


def in_order(submit: Callable[[World, int], Future[T]], places: Iterator[tuple[World, int]], ahead: int) -> Iterator[Future[T]]:
    """Submit one run after another, lazily, and yield them in this order; those that nobody asks for are cancelled.

    Args:
        ahead: so many are under way beside the one that is waited for.
    """
    waiting: deque[Future[T]] = deque()
    try:
        while True:
            while len(waiting) <= ahead and (place := next(places, None)) is not None:
                waiting.append(submit(*place))
            if not waiting:
                return
            yield waiting.popleft()
    finally:
        for left in waiting:
            left.cancel()


class ExecutorGroup:
    """Group of executing processes, started when they are first needed.

    Args:
        plugins: of the engine.
        count: processes.
    """

    def __init__(self, plugins: PluginChoice, count: int) -> None:
        self._all = [Executor(plugins) for _ in range(count)]
        self._idle: SimpleQueue[Executor] = SimpleQueue()
        for one in self._all:
            self._idle.put(one)
        self._threads = ThreadPoolExecutor(count, thread_name_prefix="executor")
        self._closed = False
        self._spent: list[float] = []

    @property
    def seconds(self) -> float:
        """CPU time of the runs so far [s], with the start of their processes."""
        return sum(self._spent)

    def start(self) -> None:
        """Start the processes before there is anything to do."""
        for one in self._all:
            one.start()

    def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Iterator[Rollout | str]:
        """Run a text in one world with its seed after another, lazily.

        Yields:
            What happened in each, in order; or why nothing did, as a clause.
        """
        for run in in_order(lambda world, seed: self._threads.submit(self._run, text, world, seed), places, len(self._all)):
            yield awaited(run)

    def close(self) -> None:
        """End the processes, whatever they are at: nobody asks any more."""
        self._closed = True
        for one in self._all:
            one.kill()
        self._threads.shutdown(cancel_futures=True)
        for one in self._all:
            one.close()

    def _run(self, text: str, world: World, seed: int) -> Rollout | str:
        executor = self._idle.get()
        try:
            return self._survived(lambda: executor.run(text, world, seed))
        finally:
            self._idle.put(executor)

    def _survived(self, run: Callable[[], tuple[Rollout, float]]) -> Rollout | str:
        """What a run gives; tried again where its process died."""
        for _ in range(DEATHS):
            if self._closed:
                break
            try:
                rollout, seconds = run()
            except ExecutorDied:
                continue
            except UserError as error:
                return str(error)
            self._spent.append(seconds)
            return rollout
        return f"the process that executes it died {DEATHS} times (out of memory, or killed)"
