"""Parallel run of an experiment: demonstrations spread over processes, nothing done twice or lost."""

from __future__ import annotations

import multiprocessing
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from ..base.errors import UserError
from ..base.resources import find_scenario
from ..base.run_directory import RunDirectory, content_key
from ..base.value import Value
from ..plugin.selection import INSTALLED, PluginChoice
from ..scenario.scenario import read_scenario
from ..version import VERSION
from .bench import Trial, bench
from .results import DemonstrationResult
from .spec import Demonstration, Experiment
from .store import LOCK, Store, code_key, locked
from .trial import run_trial
from .worker_pool import worker_pool

DEATHS = 2
"""A demonstration whose worker died this often is given up, and counts as failed."""


class Order(Value):
    """Order for a run: which demonstrations of an experiment, where to, and with how many processes.

    Args:
        set_name, short, without: which demonstrations, only the first of each object, what is taken away.
        out: the run directory.
        workers: processes.
        pictures: draw how each execution ended.
        plugins: of the engine.
    """

    experiment: Experiment
    set_name: str
    out: Path
    workers: int
    short: bool = False
    without: str | None = None
    pictures: bool = True
    plugins: PluginChoice = INSTALLED

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
        UserError: the directory holds something else, is in use or damaged, or cannot be written.
        KeyboardInterrupt: the workers were stopped; what is finished is kept.
    """
    directory = RunDirectory(order.out, run_key(order))
    lock = locked(order.out)
    try:
        store = Store(order.out)
        found = {d.name: r for d in order.demonstrations if (r := store.demonstration(d.name)) is not None}
        deaths: dict[str, int] = {}
        while left := [d for d in order.demonstrations if d.name not in found]:
            found |= _round(order, store, left, deaths, say)
        directory.finish()
        return tuple(found[d.name] for d in order.demonstrations)
    finally:
        lock.close()


def run_key(order: Order) -> dict[str, Any]:
    """Return what the results depend on: files, seeds, code. How many workers there are is none of it."""
    experiment = order.experiment
    place = bench(experiment.path.resolve(), order.set_name, order.without, order.plugins)
    chosen = experiment.choose(order.set_name)
    scenario = read_scenario(find_scenario(str(experiment.beside(chosen.scenario or experiment.spec.scenario))))
    ablation = experiment.ablation(order.without)
    files = [experiment.path, scenario.path]
    files += [experiment.beside(f) for f in (ablation.plugin, ablation.rules) if f]
    folders = [
        Path(__file__).resolve().parents[1],
        *(Path(i.file).resolve().parent for i in place.engine.registry.infos),
    ]
    return {
        "cramlite": VERSION, "experiment": experiment.spec.experiment, "set": order.set_name, "short": order.short,
        "without": order.without, "scenario": content_key(*files), "code": code_key(folders),
    }  # fmt: skip


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
        _stop(pool)
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


def _stop(pool: ProcessPoolExecutor) -> None:
    """End the workers at once: what they write, they write whole."""
    pool.shutdown(wait=False, cancel_futures=True)
    for child in multiprocessing.active_children():
        child.terminate()


class Progress:
    """Progress report: a line for each demonstration, with the remaining time at this pace."""

    def __init__(self, total: int, left: int, say: Callable[[str], None]) -> None:
        self.total, self.left, self.say, self.begin, self.done = total, left, say, time.monotonic(), 0

    def one(self, result: DemonstrationResult) -> None:
        """Report one finished demonstration."""
        self.done += 1
        passed = time.monotonic() - self.begin
        rest = passed / self.done * (self.left - self.done)
        good = [sum(getattr(r, stage) for r in result.results) for stage in ("planned", "simulated", "succeeded")]
        self.say(
            f"[{self.total - self.left + self.done}/{self.total}] {result.name}: {result.candidates} candidates, "
            f"{'/'.join(map(str, good))} planned/simulated/executed{'; ' + result.reason if result.reason else ''}; "
            f"{_clock(passed)} passed, about {_clock(rest)} left"
        )


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


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
