"""Robot process that simulates the episodes of a benchmark, and judges them.

Beside what a robot process answers (docs/how-to/drive_a_robot.md) it answers ``reset`` (suite, task, state), ``scene``, ``check`` and
``cameras``, each with one JSON object; one with ``error`` says, in a clause, why it cannot.
"""

from __future__ import annotations

import base64
import binascii
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from msgspec import DecodeError, ValidationError, convert, json

from cramlite import Setting, UserError, data_folder
from cramlite.model import Rollout, Value, Watch

from ..backends.stream.messages import Action, Hello, State
from ..backends.stream.process import LineProcess, RobotProcess
from ..backends.stream.run import stream
from ..simulation.typed_program.machine import load_program

PATIENCE = 60.0
"""Time within which a benchmark must answer before it counts as hung [s]; a reset builds a scene and may take six times as long."""
REST = 1.0
"""Time without an action after which things are at rest [s]."""


class Check(Value):
    """Result of the check of an episode.

    Args:
        success: whether its goal holds now.
        first: the action after which it held for the first time, from 1; None for never.
        steps: actions that were taken.
        changed: the action after which the benchmark changed something; None for never.
        avoided: whether what must not be moved was not; None where nothing must not.
    """

    success: bool
    first: int | None
    steps: int
    changed: int | None = None
    avoided: bool | None = None


class BenchmarkEnvironment(Value):
    """Python environment that a benchmark runs in, as it needs other packages than cramlite.

    Args:
        benchmark: whose it is, for people.
        place: its folder, where nobody says another one.
        variable: environment variable that says another one.
        size: what it takes to make it, e.g. "2.1 GB and a minute or two".
        packages: what is installed in it, as pip is told.
    """

    benchmark: str
    place: str
    variable: str
    size: str
    packages: str

    def python(self, folder: Path | None) -> str:
        """Return the path of the Python interpreter in the benchmark's own environment.

        Args:
            folder: where it is, if not in its usual place.

        Raises:
            UserError: the environment is not there; the message says the command that makes it.
        """
        where = folder or Path(os.environ.get(self.variable) or self.place).expanduser()
        python = where / "bin" / "python"
        if not python.exists():
            raise UserError(
                f"{self.benchmark}'s environment is not installed: there is no '{python}'. It takes {self.size}: "
                f"python3 -m venv {where} && {where}/bin/pip install {self.packages}"
            )
        return str(python)


class BenchmarkProcess:
    """Process that simulates episodes of a benchmark and judges them; each episode is attempted once.

    Its script may import the shipped benchmarks' shared modules.

    Args:
        command: starts it.
        page: where it is written what it must answer.
        robot: type of the robot that it simulates.
        joints: of the robot.
        patience: how long it may take to answer [s].

    Raises:
        UserError: it cannot be started.
    """

    def __init__(self, command: Sequence[str], page: str, robot: str, joints: int = 7, patience: float = PATIENCE) -> None:
        self.patience = patience
        self.lines = LineProcess("benchmark", command, page, data_folder("experiments"))
        self.robot = RobotProcess(self.lines, robot, joints, patience)
        self.last: Action | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the benchmark's process."""
        self.robot.__exit__()

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode and return the name of its task.

        Raises:
            UserError: there is no such suite, task or state; the process died, hangs or answers what is no answer.
        """
        said = self.ask({"ask": "reset", "suite": suite, "task": task, "state": state}, 6 * self.patience)
        if not isinstance(said.get("task"), str):
            raise self.lines.wrong("answered 'reset' without 'task', the name of the task")
        self.last = None
        return str(said["task"])

    def scene(self, *, model: bool = True) -> dict[str, Any]:
        """Return the benchmark's description of its present world; without ``model``, only the parts that change: poses and goal."""
        return self.ask({"ask": "scene"} if model else {"ask": "scene", "model": False}, self.patience)

    def check(self) -> Check:
        """Ask the benchmark whether the goal holds now, and return its answer."""
        said = self.ask({"ask": "check"}, self.patience)
        try:
            return convert(said, Check)
        except ValidationError as error:
            raise self.lines.wrong(f"answered 'check' with what is no result: {error}") from None

    def picture(self) -> bytes:
        """Return the picture of the process's first camera, as PNG; empty without a working camera."""
        try:
            shown: dict[str, Any] = next(iter(self.ask({"ask": "cameras"}, self.patience).values()), {})
            return base64.b64decode(shown["png"], validate=True)
        except (UserError, KeyError, TypeError, binascii.Error):
            return b""

    def play(self, program: str, setting: Setting, watch: Watch | None = None) -> Rollout:
        """Stream a typed program's actions to the simulated robot, and return its states as a rollout. A hand
        that holds a payload goes on pressing it."""
        return stream(load_program(program, setting.robot), setting.robot, self, watch, setting.world.robots[0])

    def rest(self) -> None:
        """Let the robot hold still for ``REST`` seconds, so that things come to rest."""
        if self.last is not None:
            self.hold(round(REST * self.hello().rate))

    def hold(self, actions: int) -> None:
        """Let the robot hold still for a number of actions, its hand as it was told last."""
        last = self.last
        if last is None:
            return
        still = Action(opening=last.opening, grip=last.grip, joints=last.joints, delta=None if last.delta is None else (0.0,) * 6)
        for _ in range(actions):
            self.step(still)

    @property
    def name(self) -> str:
        """Return the process's name for error messages."""
        return self.lines.name

    def hello(self) -> Hello:
        """Return what a client must know of the robot: its type, the kind of its actions, their rate and their limits."""
        return self.robot.hello()

    def step(self, action: Action) -> State:
        """Send an action and return the state of the robot after it."""
        self.last = action
        return self.robot.step(action)

    def ask(self, ask: dict[str, Any], patience: float) -> dict[str, Any]:
        """Send a request and return the answer.

        Raises:
            UserError: it refuses, has died, does not answer within ``patience`` [s], or answers what is no object.
        """
        line = self.lines.ask(json.encode(ask) + b"\n", patience)
        try:
            said = json.decode(line)
        except (DecodeError, UnicodeDecodeError) as error:
            raise self.lines.wrong(f"answered {line[:80]!r}, which is no JSON: {error}") from None
        if not isinstance(said, dict):
            raise self.lines.wrong(f"answered {line[:80]!r}, which is no object")
        if "error" in said:
            raise UserError(f"The benchmark refuses '{ask['ask']}': {said['error']}.".replace("?.", "?"))
        return said
