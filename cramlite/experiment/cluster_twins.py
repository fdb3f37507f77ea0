"""Runs in twins of a trial that is a task of a Dask cluster: further tasks of the cluster, or the trial's own work."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.pulse import awaited
from ..engine.executor_group import in_order
from ..plugin.catalogue import Knowledge
from ..plugin.selection import PluginChoice

if TYPE_CHECKING:
    from concurrent.futures import Future

    from ..model.rollout import Rollout
    from ..model.world import World


def twin_task(plugins: PluginChoice, text: str, world: World, seed: int) -> tuple[Rollout | str, float]:
    """Run a text in a world; return what happened, or why nothing did, and the CPU time it took [s]."""
    knowledge, begin = _knowledge(plugins), time.thread_time()
    try:
        rollout = knowledge.simulator.execute(text, world, knowledge.robots_of(world), mount=world.robots[0].name, seed=seed)
    except UserError as error:
        return f"The execution of a program broke: {error}", time.thread_time() - begin
    return rollout, time.thread_time() - begin


@lru_cache(maxsize=2)
def _knowledge(plugins: PluginChoice) -> Knowledge:
    return Knowledge(plugins.registry())


class OwnRuns:
    """Runs in twins one after another, where the trial itself runs.

    Args:
        plugins: of the engine.
    """

    def __init__(self, plugins: PluginChoice) -> None:
        self._plugins = plugins
        self.seconds = 0.0
        """CPU time of the runs so far [s]."""

    def start(self) -> None:
        """Do nothing: there is nobody else."""

    def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Iterator[Rollout | str]:
        """Run a text in one world with its seed after another, lazily; yield what happened."""
        for world, seed in places:
            rollout, seconds = twin_task(self._plugins, text, world, seed)
            self.seconds += seconds
            yield rollout

    def close(self) -> None:
        """Do nothing: nothing is under way."""


class ClusterRuns:
    """Runs in twins as further tasks of the cluster that a trial is a task of.

    While the trial waits for them it leaves its place in the worker to other tasks (Dask's ``worker_client``).

    Args:
        plugins: of the engine.
    """

    def __init__(self, plugins: PluginChoice) -> None:
        self._plugins = plugins
        self.seconds = 0.0
        """CPU time of the runs so far [s]."""

    def start(self) -> None:
        """Do nothing: workers run already."""

    def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Iterator[Rollout | str]:
        """Run a text in one world with its seed after another, lazily; yield what happened in their order."""
        from distributed import worker_client
        from distributed.scheduler import KilledWorker

        with worker_client() as client:
            pool = client.get_executor(pure=False)

            def submit(world: World, seed: int) -> Future[tuple[Rollout | str, float]]:
                future: Future[tuple[Rollout | str, float]] = pool.submit(twin_task, self._plugins, text, world, seed)
                return future

            for run in in_order(submit, places, max(1, sum(client.nthreads().values()))):
                try:
                    rollout, seconds = awaited(run)
                except KilledWorker as error:
                    yield f"the process that executes it died {error.allowed_failures + 1} times (out of memory, or killed)"
                    continue
                self.seconds += seconds
                yield rollout

    def close(self) -> None:
        """Do nothing: what nobody waits for was cancelled."""
