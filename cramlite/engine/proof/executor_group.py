"""Group of processes that run program texts in parallel; the results of a list of runs come in the list's order."""

from __future__ import annotations

import os
import threading
import weakref
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from queue import Empty, LifoQueue
from typing import TYPE_CHECKING, TypeVar

from ...base.errors import UserError
from ...base.pulse import awaited
from ...plugin.selection import PluginChoice
from .executor import Executor, ExecutorDied

if TYPE_CHECKING:
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...plugin.catalogue import Knowledge

DEATHS = 2
"""Number of times that a run is tried if its process dies."""
T = TypeVar("T")


def processes_here() -> int:
    """Return the number of processes that can work at once on this machine."""
    own = getattr(os, "sched_getaffinity", None)  # not everywhere
    return len(own(0)) if own is not None else os.cpu_count() or 1


def in_order(submit: Callable[[World, int], Future[T]], places: Iterator[tuple[World, int]], ahead: int) -> Iterator[Future[T]]:
    """Submit runs one after another, lazily, and yield their futures in this order.

    Runs that were submitted, and whose results the caller does not take, are cancelled.

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
    """Group of executing processes, which start when they are first needed, and end when nobody uses the
    group any more.

    Several lists of runs may be under way at once; each has the runs that are its own.

    Args:
        plugins: of the engine.
        count: processes.
    """

    def __init__(self, plugins: PluginChoice, count: int) -> None:
        self._all = [Executor(plugins) for _ in range(count)]
        self._idle: LifoQueue[Executor] = LifoQueue()  # the one that ran last is the first to run again
        for one in reversed(self._all):
            self._idle.put(one)
        self._threads = ThreadPoolExecutor(count, thread_name_prefix="executor")
        self._spent: list[float] = []
        self._end = weakref.finalize(self, _ended, self._all, self._threads, os.getpid())

    @property
    def seconds(self) -> float:
        """CPU time of the runs so far [s], with the start of their processes."""
        return sum(self._spent)

    def start(self, count: int) -> None:
        """Start at most ``count`` idle processes before there is anything to run."""
        with self._idle_ones(count) as idle:
            for one in idle:
                one.start()

    def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Generator[Rollout | str]:
        """Run a program text in several worlds, each with its seed, lazily; when the caller stops iterating, the runs
        under way are ended.

        Yields:
            What happened in each, in order; or why nothing did, as a clause.
        """
        mine = _List()
        try:
            for run in in_order(lambda world, seed: self._threads.submit(self._run, mine, text, world, seed), places, len(self._all)):
                yield awaited(run)
        finally:
            mine.leave()

    def stop(self) -> None:
        """End all processes; the next request starts new ones.

        A run of another list that is interrupted by this is begun anew.
        """
        for one in self._all:
            one.end()

    def close(self) -> None:
        """End all processes at once, also those in the middle of a run."""
        self._end()

    @contextmanager
    def _idle_ones(self, count: int) -> Iterator[list[Executor]]:
        """Reserve at most ``count`` idle processes during a ``with`` block, so that no run is given to them."""
        idle: list[Executor] = []
        with suppress(Empty):
            while len(idle) < count:
                idle.append(self._idle.get_nowait())
        try:
            yield idle
        finally:
            for one in reversed(idle):
                self._idle.put(one)

    def _run(self, mine: _List, text: str, world: World, seed: int) -> Rollout | str:
        executor = self._idle.get()
        try:
            with mine.running(executor):
                return self._survived(mine, lambda: executor.run(text, world, seed))
        finally:
            self._idle.put(executor)

    def _survived(self, mine: _List, run: Callable[[], tuple[Rollout, float]]) -> Rollout | str:
        """Outcome of a run; a run whose process died is tried again."""
        for _ in range(DEATHS):
            if mine.left or not self._end.alive:
                break
            try:
                rollout, seconds = run()
            except ExecutorDied:
                continue
            except UserError as error:
                return str(error)
            self._spent.append(seconds)
            return rollout
        return f"the process that executes the run died {DEATHS} times (out of memory, or killed)"


def group_of(knowledge: Knowledge) -> ExecutorGroup:
    """Make a group of executing processes, one for each core, with the plugins of an engine."""
    return ExecutorGroup(PluginChoice.of(knowledge.registry), processes_here())


class _List:
    """Executing processes that are at work on one list of runs, so that all these runs can be interrupted together."""

    def __init__(self) -> None:
        self._lock, self._running, self.left = threading.Lock(), list[Executor](), False

    @contextmanager
    def running(self, executor: Executor) -> Iterator[None]:
        """Register an executing process during a ``with`` block, so that ``leave`` interrupts its run."""
        with self._lock:
            self._running.append(executor)
        try:
            yield
        finally:
            with self._lock:
                self._running.remove(executor)

    def leave(self) -> None:
        """Interrupt the runs under way, since the caller no longer wants their results."""
        with self._lock:
            self.left = True
            for one in self._running:
                one.interrupt()


def _ended(processes: Sequence[Executor], threads: ThreadPoolExecutor, owner: int) -> None:
    """End the processes of a group that nobody uses any more; do nothing in a process that was forked from
    their owner."""
    if os.getpid() != owner:
        return
    threads.shutdown(wait=False, cancel_futures=True)  # this may be one of them
    for one in processes:
        one.end()
