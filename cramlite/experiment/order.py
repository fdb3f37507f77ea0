"""Order to run an experiment: its trials, judged here or by others, the folder of results and the number of processes."""

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
    """Trials of an experiment: plain values, so that any process can do each of them."""

    @property
    def folder(self) -> str:
        """Folder of a run directory that holds a folder for each trial."""

    @property
    def result(self) -> type[Any]:
        """Type of a result."""

    @property
    def names(self) -> tuple[str, ...]:
        """Trials that are asked for, in order."""

    def key(self) -> dict[str, Any]:
        """Return the key of the results: files, seeds, code; without number and place of workers."""

    def prepare(self) -> None:
        """Check the needs of all trials, before the first one begins."""

    def run(self, name: str, store: Store, processes: int) -> Any:
        """Run a trial, or its unfinished part, with its twins in a number of processes; return its result."""

    def lost(self, name: str, reason: str) -> Any:
        """Return the result of a trial that was given up."""

    def line(self, name: str, result: Any) -> str:
        """Return a result in a line for people."""

    def report(self, results: dict[str, Any], out: Path) -> Report:
        """Return the report of the results that a run directory holds, each by the name of its trial."""


class Order(Value):
    """Order for a run.

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
        """Store of the run's results."""
        return Store(self.out, self.trials.folder, self.trials.result)
