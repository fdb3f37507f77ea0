"""Execution of a single trial inside a worker process, or as a task of a Dask cluster."""

from __future__ import annotations

import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..engine.proof.executor_group import processes_here
from .order import LOCAL, Order, Trials
from .store import BEGUN, MOVED


class Arrived(Value):
    """Trial that ran on a worker: its result, and its files by their names in the directory of a run."""

    result: Any
    files: dict[str, bytes]


def run_trial(order: Order, name: str) -> Any:
    """Run a trial, or the part of it that is not done yet.

    Each finished piece is written at once, so that this process may die at any time.

    Raises:
        UserError: it could not begin, or a file cannot be read or written.
    """
    store = order.store
    if (done := store.read(name, "result", store.result)) is not None:
        return done
    store.mark(name)  # it stays if this process dies
    try:
        store.save(name, result := order.trials.run(name, store, processes_here() if order.executor == LOCAL else 1))
        store.unmark(name, MOVED)
    finally:
        store.unmark(name, BEGUN)
    return result


def trial_task(order: Order, name: str, key: dict[str, Any]) -> Arrived:
    """Run a trial in a folder of the worker's own, and send back its files.

    Args:
        key: of the run, as whoever asks for it has it.

    Raises:
        UserError: this worker has other files or another code.
    """
    _require_same(order.trials, key)
    with tempfile.TemporaryDirectory(prefix="cramlite-trial-") as folder:
        place = Path(folder)
        result = run_trial(replace(order, out=place), name)
        paths = (p for p in place.rglob("*") if p.is_file())
        return Arrived(result, {p.relative_to(place).as_posix(): p.read_bytes() for p in paths})


@lru_cache(maxsize=64)
def _own_key(trials: Trials) -> dict[str, Any]:
    return trials.key()


def _require_same(trials: Trials, key: dict[str, Any]) -> None:
    """Refuse a trial if this worker's files or code differ from those of the run.

    The comparison is made once for each process and run.
    """
    import socket

    try:
        own = _own_key(trials)
    except (UserError, OSError) as error:
        raise UserError(f"The worker on '{socket.gethostname()}' cannot use the experiment: {error}") from error
    if own != key:
        other = ", ".join(k for k in key if own.get(k) != key[k])
        raise UserError(
            f"The worker on '{socket.gethostname()}' would give other results than this machine (different: {other}): every machine needs "
            "the same version of cramlite, its plugins, and the experiment's folder with the same files. None of its results was counted."
        )
