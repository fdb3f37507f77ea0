"""Parallel run of an experiment: trials spread over processes, nothing done twice or lost."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from ..base.errors import UserError
from ..base.run_directory import RunDirectory
from .cluster import run_on_cluster
from .cluster_tasks import run_trial
from .order import LOCAL, Order
from .progress import Progress
from .store import BEGUN, MOVED, Store, locked
from .worker_pool import stop_workers, worker_pool

DEATHS = 2
"""Number of worker deaths after which a trial is given up, and counts as failed."""
STOPPED = "the process that played it ended after the robot had moved (killed, out of memory, or stopped by hand); it is not played again"
MOST_LOST = 3
"""Number of trials that could not begin, after which no further trials are tried."""


def run_experiment(order: Order, say: Callable[[str], None]) -> dict[str, Any]:
    """Run the trials of an experiment that have no result in its run directory yet.

    Args:
        say: is told a line for each trial.

    Returns:
        All results that the directory holds by the names of their trials, those of earlier runs among them; the same for any number of
        workers.

    Raises:
        UserError: a trial could not begin; the directory holds something else, is in use or damaged, or cannot be written; or there is
            no such cluster. What is finished is kept.
        KeyboardInterrupt: the workers were stopped; what is finished is kept.
    """
    key = order.trials.key()
    directory = RunDirectory(order.out, key)
    lock = locked(order.out)
    try:
        store = order.store
        _settle(order, store, say)
        if left := _left(order, store):
            order.trials.prepare()
            if order.executor != LOCAL:
                run_on_cluster(order, left, key, store, Progress(len(order.trials.names), len(left), say))
            _run_all(order, store, say)
        directory.finish()
        return store.results()
    finally:
        lock.close()


def _left(order: Order, store: Store) -> list[str]:
    """Return the names of the trials that have no result yet.

    Raises:
        UserError: a result is damaged.
    """
    found = store.results()
    return [name for name in order.trials.names if name not in found]


def _settle(order: Order, store: Store, say: Callable[[str], None]) -> None:
    """Store a failure for each trial whose process ended after the robot had moved, because a trial has one
    attempt only."""
    for name in store.marked(MOVED):
        _give_up(order, store, name, STOPPED, say)


def _give_up(order: Order, store: Store, name: str, reason: str, say: Callable[[str], None]) -> None:
    result = order.trials.lost(name, reason)
    store.save(name, result)
    store.unmark(name, BEGUN, MOVED)
    say(order.trials.line(name, result))


def _run_all(order: Order, store: Store, say: Callable[[str], None]) -> None:
    """Hand out the trials until each has a result; a trial that repeatedly kills its worker gets a failure.

    Raises:
        UserError: some could not begin.
    """
    deaths = Counter[str]()
    while left := _left(order, store):
        for name in store.marked(BEGUN):  # of a run that was killed
            store.unmark(name)
        if lost := _round(order, left, say):
            raise UserError(f"{len(lost)} of {len(left)} trials could not begin, the first one: {lost[0]} Finished ones are kept in "
                            f"'{order.out}'; start the same command again for the rest.")  # fmt: skip
        for name in store.marked(BEGUN):
            deaths[name] += 1
            say(f"a worker died during {name} ({deaths[name]} of {DEATHS}); the trial is begun anew, unless its robot had moved")
            if deaths[name] >= DEATHS:
                _give_up(order, store, name, f"the process died {DEATHS} times (out of memory, or killed)", say)
        _settle(order, store, say)


def _round(order: Order, left: Sequence[str], say: Callable[[str], None]) -> list[str]:
    """Hand out trials until all have ended or a worker dies; return the errors of the trials that could not
    begin."""
    progress, lost = Progress(len(order.trials.names), len(left), say), list[str]()
    pool = worker_pool(min(order.workers, len(left)))
    try:
        waiting = {pool.submit(run_trial, order, name): name for name in left}
        for future in as_completed(waiting):
            progress.one(_line(order, waiting[future], future, lost))
            if len(lost) == MOST_LOST:
                break
        else:
            pool.shutdown()
    except BrokenProcessPool:
        pass
    finally:
        stop_workers(pool)
    return lost


def _line(order: Order, name: str, future: Future[Any], lost: list[str]) -> str:
    """Format a trial that has ended as one line for people."""
    try:
        return order.trials.line(name, future.result())
    except UserError as error:
        lost.append(str(error))
        return f"{name}: not begun: {error}"


def speak(text: str) -> None:
    """Print a line for people on standard error."""
    print(text, file=sys.stderr, flush=True)
