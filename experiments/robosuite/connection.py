"""robosuite as a benchmark: its process, its environment, and its episodes as scenarios."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cramlite import Engine, Setting
from cramlite.model import World
from cramlite_plugins.backends.stream.process import RobotProcess
from cramlite_plugins.benchmarks.benchmark_process import PATIENCE, BenchmarkEnvironment, BenchmarkProcess
from cramlite_plugins.benchmarks.benchmark_scene import scene_model, scene_setting

SCRIPT = Path(__file__).parent / "simulator.py"
ENVIRONMENT = BenchmarkEnvironment(
    "robosuite", "~/.local/share/cramlite/robosuite", "CRAMLITE_ROBOSUITE", "1 GB and a minute or two", "robosuite==1.5.2 mujoco==3.3.0"
)
ROBOTS = {"panda": ("libero_panda", 7), "ur5e": ("robosuite_ur5e", 6)}
"""End of a suite's name -> the robot's type in cramlite, and the number of joints of its arm."""


class Robosuite(BenchmarkProcess):
    """robosuite's simulator and its success checks.

    Args:
        environment: folder of its Python environment, if not in its usual place.

    Raises:
        UserError: the environment is not there; the message says the command that makes it.
    """

    def __init__(self, environment: Path | None = None, patience: float = PATIENCE) -> None:
        command = [ENVIRONMENT.python(environment), str(SCRIPT)]
        super().__init__(command, "docs/how-to/robosuite.md", *ROBOTS["panda"], patience)

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode of a suite, whose name ends with the robot's, and return the name of its task."""
        kind, joints = ROBOTS.get(suite.rpartition("_")[2], ("", 0))
        if kind:
            self.robot = RobotProcess(self.lines, kind, joints, self.patience)
        return super().reset(suite, task, state)

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Write the scene and scenario of an episode; return the scenario's file, and the ``Setting`` of
        the search: world, robot and backend."""
        scene = self.scene()
        robot: dict[str, Any] = {"type": self.robot.robot, "at": {"position": scene["base"], "yaw": f"{scene['yaw']} deg"}}
        model = scene_model(engine, folder, scene, self.hello(), twins, robot=robot)
        return scene_setting(engine, model, folder, scene, self.hello(), lambda _: list(scene["goal"]), now)


def connect(environment: Path | None) -> Robosuite:
    """Return the benchmark; it is installed at ``~/.local/share/cramlite/robosuite``, or where ``CRAMLITE_ROBOSUITE`` says."""
    return Robosuite(environment)
