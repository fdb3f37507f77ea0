"""Execution of program texts in a process of its own, which is given a text, a world and a seed, and nothing else.

It does what ``cramlite execute`` does, for one text after another, so that a process need not be started for each (1 s of CPU
time, measured; the execution itself takes 3 s).
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from typing import TYPE_CHECKING

from msgspec import Struct

from ..base.errors import UserError
from ..plugin.selection import INSTALLED, PluginChoice

if TYPE_CHECKING:
    from ..model.rollout import Rollout
    from ..model.world import World
    from ..plugin.catalogue import Knowledge


class ExecutorDied(Exception):
    """The executing process died during an execution: killed, out of memory, or a crash."""


class Executor(Struct):
    """Executing process; started when it is first asked, and again when it died.

    Args:
        plugins: of its engine.
    """

    plugins: PluginChoice = INSTALLED
    _pool: ProcessPoolExecutor | None = None
    _spent: float = 0.0

    def run(self, text: str, world: World, seed: int) -> tuple[Rollout, float]:
        """Run a text in a world; return what happened, and the CPU time it took [s].

        The first run's time includes the start of the process.

        Raises:
            ExecutorDied: the process did; the next call starts another one.
            UserError: the text is no program for the world's robot.
        """
        pool = self._pool = self._pool or worker_pool(1)
        try:
            rollout, now = pool.submit(_execute, self.plugins, text, world, seed).result()
        except BrokenProcessPool as error:
            self.close()
            raise ExecutorDied("the process that executes programs ended") from error
        except UserError as error:
            raise UserError(f"The execution of a program broke: {error}") from error
        seconds, self._spent = now - self._spent, now
        return rollout, seconds

    def close(self) -> None:
        """End the process when it has done what it was asked; the next run starts another one."""
        if self._pool is not None:
            self._pool.shutdown()
        self._pool, self._spent = None, 0.0


@lru_cache(maxsize=1)
def _knowledge(plugins: PluginChoice) -> Knowledge:
    """Built once in the process that executes."""
    from ..plugin.catalogue import Knowledge

    return Knowledge(plugins.registry())


def _execute(plugins: PluginChoice, text: str, world: World, seed: int) -> tuple[Rollout, float]:
    """In the other process: the rollout, and all CPU seconds of the process so far."""
    knowledge = _knowledge(plugins)
    rollout = knowledge.simulator.execute(text, world, knowledge.robots, mount=world.robots[0].name, seed=seed)
    return rollout, time.process_time()


def worker_pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of processes that start afresh, each when there is work for it; they leave Ctrl-C to this one, and end
    when it does."""
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_begin)


def _begin() -> None:
    """What plugins print is no answer of this command; nobody is left to work for when the parent is gone."""
    sys.stdout = sys.stderr
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
