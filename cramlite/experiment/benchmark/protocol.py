"""Protocol of a benchmark, and the import of the file in which an experiment defines its benchmark."""

from __future__ import annotations

import hashlib
import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Protocol

from ...base.errors import UserError
from ...engine.engine import Engine
from ...engine.setting import Setting
from ...model.run.readings import Watch
from ...model.run.rollout import Rollout
from ...model.world.world import World

CONNECT = "connect"
"""Function of an experiment's file that returns its benchmark, or says how its environment is installed."""


class CheckResult(Protocol):
    """Result of the benchmark's check: whether and when the goal of an episode held."""

    @property
    def success(self) -> bool:
        """Whether the episode's goal holds at the present state."""

    @property
    def first(self) -> int | None:
        """Number of the action after which the goal first held, from 1; None if it never did."""

    @property
    def steps(self) -> int:
        """Number of actions that the benchmark's simulator has taken."""

    @property
    def avoided(self) -> bool | None:
        """Whether no obstacle was moved that must stay where it is; None in tasks without such obstacles."""

    @property
    def changed(self) -> int | None:
        """Number of the action after which the benchmark changed its world; None if it never did."""


class Benchmark(Protocol):
    """Process that simulates the episodes of a benchmark and judges them.

    ``cramlite_plugins.benchmarks.benchmark_process.BenchmarkProcess`` has all of it but ``setting``. Whatever is not as it must be is a
    ``UserError``.
    """

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode and return the name of its task."""

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Write the present episode and its goal as a scenario into a folder; return the scenario's file, and
        the ``Setting`` of the search: world, robot and backend.

        Args:
            now: the world as it was read last, of watched suites alone: what its robot holds.
        """

    def play(self, program: str, setting: Setting, watch: Watch | None = None) -> Rollout:
        """Run a program in the benchmark's simulator to its end, or until it is stopped by ``watch``, which gets the poses and forces of
        each moment."""

    def rest(self) -> None:
        """Take no action until the things in the benchmark's world are at rest."""

    def check(self) -> CheckResult:
        """Check whether the episode's goal holds in the present state of the benchmark's world, and when it
        first held."""

    def picture(self) -> bytes:
        """Return the picture of the benchmark's camera as PNG; empty without a camera."""

    def close(self) -> None:
        """End the benchmark's process."""


def connect(file: Path, environment: Path | None) -> Benchmark:
    """Connect to an experiment's benchmark.

    Args:
        file: of the experiment, whose function ``connect`` does it; it may import files beside it (``from .goals import ...``).
        environment: where the benchmark is installed; None for its usual place.

    Raises:
        UserError: there is no such file, it cannot be imported, has no such function, or that fails; the benchmark is not installed.
    """
    function = getattr(module_of(file), CONNECT, None)
    if not callable(function):
        raise UserError(f"'{file}' has no function '{CONNECT}(environment)' that returns the benchmark of its experiment.")
    try:
        benchmark: Benchmark = function(environment)
    except UserError:
        raise
    except Exception as error:
        raise UserError(f"'{file}': its function '{CONNECT}' failed: {type(error).__name__}: {error}.") from error
    return benchmark


def module_of(file: Path) -> ModuleType:
    """Import a file of an experiment as a module in a package of its folder, so that it may import files beside it.

    Raises:
        UserError: there is no such file, or it cannot be imported.
    """
    if not file.is_file():
        raise UserError(f"There is no '{file}', which the experiment names as its benchmark.")
    folder = file.resolve().parent
    name = f"cramlite_benchmark_{hashlib.blake2b(str(folder).encode(), digest_size=6).hexdigest()}"
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(folder)]
        sys.modules[name] = package
    try:
        return importlib.import_module(f"{name}.{file.stem}")
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise UserError(f"'{file}', which the experiment names as its benchmark, cannot be imported: {why}.") from error
