"""Request to run an experiment: its trials, the folder of the results, and the number of processes."""

from __future__ import annotations

from collections.abc import Hashable
from pathlib import Path
from typing import Any, Protocol

from msgspec import field

from ..base.errors import UserError
from ..base.value import Value
from .figure import Number, Published
from .store import Store

LOCAL = "local"


class Report(Value):
    """Report of a run.

    Args:
        data: as JSON values.
        text: for the terminal.
        files: name -> content, to be written into the run directory.
        numbers, title, seeds, cpu_s, given, beside: of the figure.
        kept: file -> content, to be stored elsewhere.
        failure: threshold that is not reached, in a paragraph; "" if there is none.
    """

    data: Any
    text: str
    files: dict[str, str]
    numbers: list[Number]
    title: str
    seeds: str
    cpu_s: float
    given: str | None = None
    beside: tuple[Published, ...] = ()
    kept: dict[Path, str] = field(default_factory=dict)
    failure: str = ""


class Trials(Hashable, Protocol):
    """Interface of an object that describes an experiment's trials, and is sent to the processes that run them."""

    @property
    def folder(self) -> str:
        """Folder of a run directory that holds a folder for each trial."""

    @property
    def result(self) -> type[Any]:
        """Type of a trial's result."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the trials that the run was asked for, in order."""

    def key(self) -> dict[str, Any]:
        """Return the key that identifies the results of this experiment: the files, seeds and code that they come from.

        Number and place of workers are no part of it.
        """

    def prepare(self) -> None:
        """Check that all trials can run, before the first one begins."""

    def run(self, name: str, store: Store, processes: int) -> Any:
        """Run a trial, or the part of it that is not done yet, and return the trial's result.

        The trial's twins run in a number of processes.
        """

    def lost(self, name: str, reason: str) -> Any:
        """Return the result for a trial that was given up."""

    def line(self, name: str, result: Any) -> str:
        """Format a trial's result as one line for people."""

    def report(self, results: dict[str, Any], out: Path) -> Report:
        """Return the report of a run from the results of its trials, by the trials' names."""


class Order(Value):
    """Request to run an experiment's trials in a run directory.

    Args:
        out: run directory.
        workers: processes.
        executor: "local" for processes of this machine, "dask" or "dask://HOST:PORT" for a cluster (``cluster.connected``).

    Raises:
        UserError: no worker.
    """

    trials: Trials
    out: Path
    workers: int = 2
    executor: str = LOCAL

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UserError(f"--workers is {self.workers}; it takes at least 1 process.")

    @property
    def store(self) -> Store:
        """Store in which the experiment's run keeps the results of its trials."""
        return Store(self.out, self.trials.folder, self.trials.result)
