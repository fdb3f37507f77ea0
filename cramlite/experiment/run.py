"""Parallel run of an experiment: demonstrations spread over processes, nothing done twice or lost."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from ..base.errors import UserError
from ..base.run_directory import RunDirectory
from ..base.value import Value
from ..plugin.selection import INSTALLED, PluginChoice
from .bench import Trial
from .cluster import LOCAL, run_on_cluster
from .progress import Progress
from .results import DemonstrationResult
from .results_key import results_key
from .spec import Demonstration, Experiment
from .store import LOCK, Store, locked
from .trial import run_trial
from .worker_pool import stop_workers, worker_pool

DEATHS = 2
"""A demonstration whose worker died this often is given up, and counts as failed."""


class Order(Value):
    """Order for a run: which demonstrations of an experiment, where to, and with how many processes of whom.

    Args:
        set_name, short, without: which demonstrations, only the first of each object, what is taken away.
        out: the run directory.
        workers: processes.
        pictures: draw how each execution ended.
        plugins: of the engine.
        executor: "local" for processes of this machine, "dask" or "dask://HOST:PORT" for a cluster (``cluster.connected``).
    """

    experiment: Experiment
    set_name: str
    out: Path
    workers: int
    short: bool = False
    without: str | None = None
    pictures: bool = True
    plugins: PluginChoice = INSTALLED
    executor: str = LOCAL

    @property
    def demonstrations(self) -> tuple[Demonstration, ...]:
        """Demonstrations of the run, in order."""
        return self.experiment.demonstrations(self.set_name, short=self.short)

    def trial(self, one: Demonstration) -> Trial:
        """Return the trial of a demonstration."""
        path = self.experiment.path.resolve()
        return Trial(
            path,
            self.set_name,
            one,
            self.out.resolve(),
            self.without,
            self.pictures,
            self.plugins,
        )


def run_experiment(order: Order, say: Callable[[str], None]) -> tuple[DemonstrationResult, ...]:
    """Run the demonstrations of an experiment that have no result yet.

    Args:
        say: is told a line for each demonstration.

    Returns:
        The results of all demonstrations, in order, those of earlier runs among them; the same for any number of workers.

    Raises:
        UserError: the directory holds something else, is in use or damaged, or cannot be written; or there is no such cluster.
        KeyboardInterrupt: the workers were stopped; what is finished is kept.
    """
    key = run_key(order)
    directory = RunDirectory(order.out, key)
    lock = locked(order.out)
    try:
        store = Store(order.out)
        found = {d.name: r for d in order.demonstrations if (r := store.demonstration(d.name)) is not None}
        left = [d for d in order.demonstrations if d.name not in found]
        if order.executor != LOCAL and left:
            progress = Progress(len(order.demonstrations), len(left), say)
            trials = [order.trial(d) for d in left]
            found |= run_on_cluster(order.executor, order.workers, trials, order.short, key, store, progress)
        deaths: dict[str, int] = {}
        while left := [d for d in order.demonstrations if d.name not in found]:
            found |= _round(order, store, left, deaths, say)
        directory.finish()
        return tuple(found[d.name] for d in order.demonstrations)
    finally:
        lock.close()


def run_key(order: Order) -> dict[str, Any]:
    """Return what the results depend on: files, seeds, code. How many workers there are, and where, is none of it."""
    path = order.experiment.path.resolve()
    return results_key(path, order.set_name, short=order.short, without=order.without, plugins=order.plugins)


def _round(
    order: Order, store: Store, left: Sequence[Demonstration], deaths: dict[str, int], say: Callable[[str], None]
) -> dict[str, DemonstrationResult]:
    """Hand out what is left, until it is done or a worker dies."""
    for name in store.unfinished():  # of a run that was killed
        store.unmark(name)
    progress = Progress(len(order.demonstrations), len(left), say)
    found: dict[str, DemonstrationResult] = {}
    pool = worker_pool(min(order.workers, len(left)))
    try:
        for result in _results(pool, [order.trial(d) for d in left]):
            found[result.name] = result
            progress.one(result)
    except BrokenProcessPool:
        found |= _buried(order, store, deaths, say)
    except BaseException:
        stop_workers(pool)
        raise
    pool.shutdown()
    return found


def _results(pool: Executor, trials: Sequence[Trial]) -> Any:
    waiting: list[Future[DemonstrationResult]] = [pool.submit(run_trial, t) for t in trials]
    for done in as_completed(waiting):
        yield done.result()


def _buried(
    order: Order, store: Store, deaths: dict[str, int], say: Callable[[str], None]
) -> dict[str, DemonstrationResult]:
    """A worker died, and the pool with it: what it was at is tried again, or given up."""
    given_up = {}
    by_name = {d.name: d for d in order.demonstrations}
    for name in store.unfinished():
        deaths[name] = deaths.get(name, 0) + 1
        say(f"a worker died at or beside {name} ({deaths[name]} of {DEATHS}); finished pieces are kept")
        if deaths[name] >= DEATHS:
            one = by_name[name]
            reason = f"worker: the process died {DEATHS} times (out of memory, or killed)"
            given_up[name] = DemonstrationResult(name, one.object, one.seed, 0, 0, 0, (), reason)
            store.save(name, "result", given_up[name])
        store.unmark(name)
    return given_up


def speak(text: str) -> None:
    """Print a line for people on standard error."""
    print(text, file=sys.stderr, flush=True)


def check_workers(workers: int) -> int:
    """Check the number of worker processes, and return it.

    Raises:
        UserError: less than one.
    """
    if workers < 1:
        raise UserError(f"--workers is {workers}; it takes at least 1 process.")
    return workers


__all__ = ["LOCK", "Order", "run_experiment"]
