"""Trials on a Dask cluster: each is handed out when a worker is free, and its result is received once, even if workers die.

Only this process writes into the directory of the run. A trial counts when its files have arrived; until then it is handed out again:
by Dask where a worker is lost, by this process where the scheduler is, by the next command where this process is.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

from ..base.errors import UserError
from .cluster_tasks import Arrived, trial_task
from .order import LOCAL, Order
from .progress import Progress
from .store import Store

OWN = "dask"
CONNECT = 10
"""Time within which a scheduler must answer [s]; one that does not answer counts as absent."""
RESTART = 60
"""Longest time that a lost scheduler may take to come back [s]."""
LOSSES = 5
"""Number of consecutive losses of a scheduler, without a finished trial in between, after which the run is given up."""
ASK_AGAIN = 2.0
"""Time between two counts of the workers, which come and go [s]."""


def check_executor(executor: str) -> str:
    """Check and return ``--executor``, which says where trials run: 'local', 'dask' or 'dask://HOST:PORT'.

    Raises:
        UserError: it is neither this machine nor a cluster, or Dask is not installed.
    """
    if executor == LOCAL:
        return executor
    if executor != OWN and not re.fullmatch(r"dask://([\w.-]+|\[[0-9a-fA-F:]+\]):\d{1,5}", executor):
        raise UserError(
            f"--executor is '{executor}'; it is 'local' (processes of this machine), 'dask' (a Dask cluster of its own on this machine), "
            "or 'dask://HOST:PORT', the address of a cluster's scheduler."
        )
    if find_spec("distributed") is None:
        raise UserError("--executor dask needs the package distributed, which is not installed: pip install 'cramlite[distributed]'.")
    return executor


def run_on_cluster(order: Order, left: Sequence[str], key: dict[str, Any], store: Store, progress: Progress) -> None:
    """Run trials on a Dask cluster until all results have arrived.

    Args:
        left: names of the trials.
        key: of the run.
        store: where what arrives is written.

    Raises:
        UserError: there is no scheduler at the address, or a worker would give other results.
    """
    found = set[str]()
    losses, patience = 0, CONNECT
    while left := [name for name in left if name not in found]:
        found.clear()
        try:
            with connected(order.executor, order.workers, patience) as client:
                if client.dashboard_link and find_spec("bokeh"):
                    progress.say(f"live progress: {client.dashboard_link}")
                for name, result in _handed_out(client, order, left, key, store):
                    found.add(name)
                    progress.one(order.trials.line(name, result))
        except (CancelledError, OSError) as error:
            losses = 1 if found else losses + 1
            if losses >= LOSSES:
                lost = f"The scheduler of '{order.executor}' was lost {losses} times in a row"
                raise UserError(f"{lost}; arrived results are kept.") from error
            progress.say(f"the scheduler was lost; {len(left) - len(found)} trials are handed out again when it is back")
            patience = RESTART


@contextmanager
def connected(executor: str, workers: int, patience: float = CONNECT) -> Iterator[Any]:
    """Connect to a Dask cluster's scheduler, or start a cluster, and yield the client.

    Args:
        executor: "dask" starts a cluster of ``workers`` processes here, which ends with this block.
        patience: within which the scheduler must answer [s].

    Raises:
        UserError: it does not.
    """
    import logging
    import warnings

    from distributed import Client, LocalCluster

    if executor == OWN:
        options = {"n_workers": workers, "threads_per_worker": 1, "host": "127.0.0.1", "silence_logs": logging.ERROR}
        with warnings.catch_warnings():  # the live page has another port where its usual one is taken; which one is said
            warnings.filterwarnings("ignore", message=r"(?s)\s*Port \d+ is already in use")
            cluster = LocalCluster(**options)
        with cluster, Client(cluster) as client:
            yield client
        return
    address = executor.replace("dask://", "tcp://", 1)
    try:
        client = Client(address, timeout=patience)
    except Exception as error:  # of the network, or of something else that answers there
        said = next(iter(str(error).splitlines()), "")[:200]
        raise UserError(
            f"There is no Dask scheduler at '{executor}' ({type(error).__name__}: {said}). Start one with 'dask scheduler', or correct the "
            "address; finished trials are kept."
        ) from error
    with client:
        yield client


def _handed_out(client: Any, order: Order, left: Sequence[str], key: dict[str, Any], store: Store) -> Iterator[tuple[str, Any]]:
    """Yield trials with their results, one trial at a time for each thread of a worker and none queued.

    Dask blames a worker's death on all trials that were given to the worker.
    """
    pool, todo = client.get_executor(pure=False), deque(left)
    waiting: dict[Future[Arrived], str] = {}
    try:
        while todo or waiting:
            places = max(1, sum(client.nthreads().values()))
            while todo and len(waiting) < places:
                name = todo.popleft()
                waiting[pool.submit(trial_task, order, name, key)] = name
            for future in wait(waiting, ASK_AGAIN, FIRST_COMPLETED).done:
                name = waiting.pop(future)
                yield name, _received(future, order, name, store)
    finally:
        for future in waiting:
            future.cancel()


def _received(future: Future[Arrived], order: Order, name: str, store: Store) -> Any:
    """Return the result of a trial after writing the files that its worker sent; a trial whose workers
    died again and again gets a failure as its result."""
    from distributed.scheduler import KilledWorker

    try:
        arrived = future.result()
    except KilledWorker as error:
        lost = order.trials.lost(name, f"the process died {error.allowed_failures + 1} times (out of memory, or killed)")
        store.save(name, lost)
        return lost
    store.receive(name, arrived.files)
    return arrived.result
