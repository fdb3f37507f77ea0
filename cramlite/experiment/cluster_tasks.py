"""Trials of an experiment as tasks of a Dask cluster. What stands here happens on a worker."""

from __future__ import annotations

import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..plugin.selection import PluginChoice
from .bench import Trial
from .results import DemonstrationResult
from .results_key import results_key
from .trial import run_trial


class Arrived(Value):
    """Trial that ran on a worker: its result, and its files by their names in the directory of a run."""

    result: DemonstrationResult
    files: dict[str, bytes]


def trial_task(trial: Trial, short: bool, key: dict[str, Any]) -> Arrived:
    """Run a trial in a folder of the worker's own, and send back what it wrote.

    Args:
        short: whether the run is a short one.
        key: of the run, as whoever asks for it has it.

    Raises:
        UserError: this worker has other files or another code.
    """
    _require_same(trial, short, key)
    with tempfile.TemporaryDirectory(prefix="cramlite-trial-") as folder:
        place = Path(folder)
        result = run_trial(replace(trial, directory=place))
        paths = (p for p in place.rglob("*") if p.is_file())
        return Arrived(result, {p.relative_to(place).as_posix(): p.read_bytes() for p in paths})


@lru_cache(maxsize=64)
def _own_key(path: Path, set_name: str, short: bool, without: str | None, plugins: PluginChoice) -> dict[str, Any]:
    return results_key(path, set_name, short=short, without=without, plugins=plugins)


def _require_same(trial: Trial, short: bool, key: dict[str, Any]) -> None:
    """Refuse a trial whose results would be those of other files or another code; once a process, for each run."""
    import socket

    try:
        own = _own_key(trial.experiment, trial.set_name, short, trial.without, trial.plugins)
    except (UserError, OSError) as error:
        raise UserError(f"The worker on '{socket.gethostname()}' cannot use the experiment '{trial.experiment}': {error}") from error
    if own != key:
        other = ", ".join(k for k in key if own.get(k) != key[k])
        raise UserError(
            f"The worker on '{socket.gethostname()}' would give other results than this machine (different: {other}): every machine needs "
            f"the same version of cramlite, its plugins, and '{trial.experiment.parent}' with the same files. Nothing of it was counted."
        )
