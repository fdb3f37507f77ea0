"""A robot process: another program, which is sent a line and answers with a line."""

from __future__ import annotations

import shlex
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from queue import Empty, Queue
from typing import Self

from cramlite.plugin import UserError

from .messages import PROTOCOL, Action, AskEnd, AskHello, Hello, Said, State, encoded, understood

PATIENCE = 10.0
"""A process that does not answer within this time hangs [s]; before its first answer it has six times as long."""
LONGEST = 65_536
"""Characters of a line; what is longer is no answer."""


class RobotProcess:
    """Process of a robot that takes actions.

    Args:
        command: the program and its arguments.
        robot: type of the robot that a program is for.
        joints: how many it has.

    Raises:
        UserError: the program cannot be started.
    """

    def __init__(self, command: Sequence[str], robot: str, joints: int, patience: float = PATIENCE) -> None:
        self.name, self.robot, self.joints, self.patience = shlex.join(command), robot, joints, patience
        # a file, not a pipe: nobody need read it while the process runs
        self.errors = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.errors)
        except (OSError, ValueError) as error:
            self.errors.close()
            raise UserError(f"The robot process '{self.name}' cannot be started: {error}. Say a command that runs in a shell.") from None
        self.lines: Queue[bytes] = Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def hello(self) -> Hello:
        """Ask what robot there is.

        Raises:
            UserError: it is another one, or speaks another protocol.
        """
        said = self._answer(AskHello(robot=self.robot), Hello, 6 * self.patience)
        if said.protocol != PROTOCOL:
            raise self._wrong(f"speaks protocol {said.protocol}, cramlite speaks {PROTOCOL}")
        if said.robot != self.robot:
            raise self._wrong(f"drives a '{said.robot}', and the program is for a '{self.robot}'")
        if not (1 <= said.rate <= 1000 and 0 <= said.lag <= 1 and min(said.tolerance) > 0 and min(said.most or (1, 1)) > 0):
            raise self._wrong("says a rate outside 1 .. 1000 Hz, a lag outside 0 .. 1 s, or a limit or tolerance that is not positive")
        return said

    def step(self, action: Action) -> State:
        """Send an action and return what the robot feels after it.

        Raises:
            UserError: the process died, hangs or answers what is no answer.
        """
        return self._answer(action, State, self.patience)

    def close(self) -> None:
        """Say that it is over; a process that does not end by itself is ended."""
        try:
            if self.process.stdin and self.process.poll() is None:
                self.process.stdin.write(encoded(AskEnd()))
                self.process.stdin.close()
            self.process.wait(self.patience)
        except (OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        finally:
            self.errors.close()

    def _answer(self, ask: AskHello | Action, kind: type[Said], patience: float) -> Said:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(encoded(ask))
            self.process.stdin.flush()
            line = self.lines.get(timeout=patience)
        except OSError:
            line = b""
        except Empty:
            raise self._wrong(f"has not answered for {patience:g} s; it was ended") from None
        if not line:
            raise self._wrong(self._death())
        try:
            return understood(line, kind, self.joints)
        except UserError as error:
            raise self._wrong(str(error)) from None

    def _read(self) -> None:
        """Lines as they come; an empty one at the end."""
        assert self.process.stdout is not None
        for line in iter(lambda: self.process.stdout.readline(LONGEST), b""):  # type: ignore[union-attr]
            self.lines.put(line)
        self.lines.put(b"")

    def _death(self) -> str:
        """How it ended, with the last line that it wrote to standard error."""
        try:
            code: object = self.process.wait(1.0)
        except subprocess.TimeoutExpired:
            return "has closed its output"
        self.errors.seek(0)
        last = self.errors.read().decode(errors="replace").strip().splitlines()[-1:]
        return f"ended with exit code {code}" + (f": {last[0].strip()}" if last else ", and wrote no reason to standard error")

    def _wrong(self, what: str) -> UserError:
        if self.process.poll() is None:
            self.process.kill()
        end = "" if what.endswith((".", "!")) else "."
        return UserError(f"The robot process '{self.name}' {what}{end} What it must answer: docs/how-to/drive_a_robot.md.")
