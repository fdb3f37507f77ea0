"""Process that answers each line with a line, and the robot that it controls."""

from __future__ import annotations

import math
import os
import shlex
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from queue import Empty, Queue
from typing import Self

from cramlite.plugin import ProcessGone, UserError

from .messages import PROTOCOL, Action, AskEnd, AskHello, Hello, Said, State, encoded, understood

PATIENCE = 10.0
"""A process that does not answer within this time hangs [s]; before its first answer it has six times as long."""
LONGEST = 1 << 22
"""Largest length of a line [bytes]; a longer line is not accepted as an answer."""


class LineProcess:
    """Child process that is sent lines of text and answers each with one line.

    Args:
        kind: what it is called in errors, e.g. "robot process".
        command: the program and its arguments.
        page: where it is written what it must answer.
        modules: folder of modules that it may import, if it is a Python.

    Raises:
        UserError: the program cannot be started.
    """

    def __init__(self, kind: str, command: Sequence[str], page: str, modules: Path | None = None) -> None:
        self.name, self.page = f"{kind} '{shlex.join(command)}'", page
        # a file, not a pipe: nobody need read it while the process runs
        self.errors = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.errors, env=_surroundings(modules)
            )
        except (OSError, ValueError) as error:
            self.errors.close()
            raise UserError(f"The {self.name} cannot be started: {error}. Say a command that runs in a shell.") from None
        self.lines: Queue[bytes] = Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def ask(self, line: bytes, patience: float) -> bytes:
        """Send a line to the process, and return the line with which it answers.

        Raises:
            ProcessGone: the process has died, or does not answer within ``patience`` [s].
        """
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(line)
            self.process.stdin.flush()
            answer = self.lines.get(timeout=patience)
        except OSError:
            answer = b""
        except Empty:
            raise self.gone(f"has not answered for {patience:g} s; it was ended") from None
        if not answer:
            raise self.gone(self._death())
        return answer

    def wrong(self, what: str) -> UserError:
        """End the robot process, and return an error that says what the process did wrong."""
        return UserError(self._ended(what))

    def gone(self, what: str) -> ProcessGone:
        """End the process, and return an error that says how the connection was lost."""
        return ProcessGone(self._ended(what))

    def _ended(self, what: str) -> str:
        """Return a message that the robot's process failed, and kill the process if it still runs."""
        if self.process.poll() is None:
            self.process.kill()
        end = "" if what.endswith((".", "!")) else "."
        return f"The {self.name} {what}{end} What it must answer: {self.page}."

    def close(self, last: bytes, patience: float) -> None:
        """Send a last line, and wait for the process to end; kill it if it does not."""
        try:
            if self.process.stdin and self.process.poll() is None:
                self.process.stdin.write(last)
                self.process.stdin.close()
            self.process.wait(patience)
        except (OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        finally:
            self.errors.close()

    def _read(self) -> None:
        """Put each line that the process writes into the queue of its answers, and an empty one when its output
        ends."""
        assert self.process.stdout is not None
        for line in iter(lambda: self.process.stdout.readline(LONGEST), b""):  # type: ignore[union-attr]
            self.lines.put(line)
        self.lines.put(b"")

    def _death(self) -> str:
        """Say how the process ended, with the last line that it wrote to standard error."""
        try:
            code: object = self.process.wait(1.0)
        except subprocess.TimeoutExpired:
            return "has closed its output"
        self.errors.seek(0)
        last = self.errors.read().decode(errors="replace").strip().splitlines()[-1:]
        return f"ended with exit code {code}" + (f": {last[0].strip()}" if last else ", and wrote no reason to standard error")


class RobotProcess:
    """Robot that is commanded and read through a process that speaks JSON lines.

    Args:
        lines: the process.
        robot: type of the robot that a program is for.
        joints: how many it has.
        patience: how long the process may take to answer [s].
    """

    def __init__(self, lines: LineProcess, robot: str, joints: int, patience: float = PATIENCE) -> None:
        self.lines, self.robot, self.joints, self.patience = lines, robot, joints, patience

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.lines.close(encoded(AskEnd()), self.patience)

    @property
    def name(self) -> str:
        """Return the process's name for error messages."""
        return self.lines.name

    def hello(self) -> Hello:
        """Ask the robot process to describe its robot, and return the description.

        Raises:
            UserError: it is another one, or speaks another protocol.
        """
        said = self._answer(AskHello(robot=self.robot), Hello, 6 * self.patience)
        if said.protocol != PROTOCOL:
            raise self.lines.wrong(f"speaks protocol {said.protocol}, cramlite speaks {PROTOCOL}")
        if said.robot != self.robot:
            raise self.lines.wrong(f"drives a '{said.robot}', and the program is for a '{self.robot}'")
        if wrong := _out_of_range(said):
            raise self.lines.wrong(f"says a {wrong}")
        return said

    def step(self, action: Action) -> State:
        """Send an action and return the state of the robot after it.

        Raises:
            UserError: the process died, hangs or answers what is no answer.
        """
        return self._answer(action, State, self.patience)

    def _answer(self, ask: AskHello | Action, kind: type[Said], patience: float) -> Said:
        line = self.lines.ask(encoded(ask), patience)
        try:
            return understood(line, kind, self.joints)
        except UserError as error:
            raise self.lines.wrong(str(error)) from None


def _out_of_range(hello: Hello) -> str:
    """Name the first implausible value in a robot process's description of its robot, with the allowed range;
    "" if there is none."""
    ranges = {
        "rate": (hello.rate, 1.0, 1000.0, "Hz"), "lag": (hello.lag, 0.0, 1.0, "s"), "inertia": (hello.inertia, 0.0, 0.1, "s2"),
        "hesitation": (hello.hesitation, 0.0, 10.0, "s"), "settling": (hello.settling, 0.0, 10.0, "s"),
        "tolerance": (min(hello.tolerance), 1e-6, math.inf, ""), "largest delta": (min(hello.most or (1.0,)), 1e-6, math.inf, ""),
        "tolerance of the fingers": (1.0 if hello.fingers is None else hello.fingers, 1e-6, math.inf, "m"),
    }  # fmt: skip
    for name, (value, low, high, unit) in ranges.items():
        if not low <= value <= high:
            return f"{name} of {value:g} {unit}".strip() + (f", outside {low:g} .. {high:g}" if high < math.inf else ", which is too small")
    return ""


def _surroundings(modules: Path | None) -> dict[str, str] | None:
    """Return this process's environment variables with a folder appended to PYTHONPATH; None if no folder is given."""
    if modules is None:
        return None
    found = [os.environ.get("PYTHONPATH", ""), str(modules)]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, found))}
