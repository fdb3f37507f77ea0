"""Worker processes of an experiment."""

from __future__ import annotations

import multiprocessing
import signal
import sys
import threading
from concurrent.futures import ProcessPoolExecutor

from ..base.process_group import begin_group, end_group, end_own_group


def worker_pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of processes, each started when there is work for it. They ignore Ctrl-C, and end with this
    process, with all their children."""
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_begin)


def stop_workers(pool: ProcessPoolExecutor) -> None:
    """End the workers of a pool at once, with their child processes; no file is left half-written."""
    workers = multiprocessing.active_children()
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        _kill(worker)
    for worker in workers:
        worker.join()


def _kill(worker: multiprocessing.process.BaseProcess) -> None:
    """End a worker and its process group; a worker that has not begun has no group yet."""
    if worker.pid is None:
        return
    try:
        end_group(worker.pid)
    except OSError:
        worker.kill()


def _begin() -> None:
    """Prepare a worker: prints of plugins go to standard error, and the worker ends when its parent process
    does."""
    sys.stdout = sys.stderr
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    begin_group()
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            end_own_group()

    threading.Thread(target=follow, daemon=True).start()
