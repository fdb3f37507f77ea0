"""Execution of Python programs that drive a controller over its ports, by ur_rtde or by sockets of their own.

The program is a process of its own, which is given its text and an address: its first argument, and ``CRAMLITE_ROBOT_HOST``.
What happens is recorded on the controller's side. Both run in wall time, so that two runs of one program differ a little,
unlike those of URScript.
"""

from __future__ import annotations

import importlib.util
import itertools
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path

from msgspec.structs import replace

from cramlite.model import Robot, Rollout, World
from cramlite.plugin import UserError

from ..simulation.recording.recorder import Peaks, Recorder
from .client_text import CLIENTS
from .network import serve
from .registers import Registers
from .virtual_robot import VirtualRobot

LINE = "input_int_register_18"  # where programs say in which line they are (backends/ur_rtde_arm.py)
HOST = "CRAMLITE_ROBOT_HOST"
"""Environment variable with the controller's address."""
ABORT = "cramlite abort: "
AFTER = 1.0  # how long to go on recording after the program's end [s]
STOPPED = 5.0  # a program whose robot has stopped ends by itself within this time [s]


def can_run(text: str = "import rtde_control") -> str:
    """Explain why a client program cannot be run on this computer; "" if it can."""
    names = {found[1] for found in CLIENTS.finditer(text)} - {"socket", "rtde"}
    if names and importlib.util.find_spec("rtde_control") is None:
        return "the package ur-rtde is not installed in this Python (it has wheels for 3.11 and 3.12): pip install ur-rtde"
    return ""


def execute_client(
    text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int = 0, time_limit: float = 300.0
) -> Rollout:
    """Run a program against the robot of a world, on ports of a free loopback address.

    Returns:
        A rollout whose outcome is "finished", "halted" (the reason is the program's last message), "protective stop",
        "timeout" or "error"; ``lines`` are those that the program tells through a register.

    Raises:
        UserError: ur_rtde is not installed, or the world has no such robot.
    """
    if missing := can_run(text):
        raise UserError(f"The program cannot be run: {missing}.")
    run = _Run(world, robots, mount, seed, time_limit)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.py"
        path.write_text(text, encoding="utf-8")
        for number in itertools.count():
            host = f"127.{1 + os.getpid() % 250}.{1 + os.getpid() // 250 % 250}.{10 + number}"
            try:
                why = serve(run.robot, host, seconds=0, idle=0, ready=lambda _, h=host: run.begin(path, h), each=run.each)  # type: ignore[misc]
                break
            except UserError:  # a port of this address is taken
                if number == 9:
                    raise
            finally:
                run.kill()
    return run.rollout(why)


class _Run:
    """One execution: controller, recorder, and the program's process."""

    def __init__(self, world: World, robots: Mapping[str, Robot], mount: str, seed: int, time_limit: float) -> None:
        self.robot = VirtualRobot(world, robots, mount, self.say, seed=seed)
        self.recorder = Recorder(self.robot.compiled, mount, wrench=False)
        self.time_limit = time_limit
        self.process: subprocess.Popen[str] | None = None
        self.said: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.errors: list[str] = []
        self.readers: list[threading.Thread] = []
        self.peaks = Peaks(self.recorder.period)
        self.ended = self.stopped = -1.0

    @property
    def line(self) -> int:
        registers: Registers = self.robot.registers
        return int(registers.fields.get(LINE, 0))

    def say(self, text: str) -> None:
        """Drop a message of the controller's own log."""

    def begin(self, program: Path, host: str) -> None:
        """Start the client's program, when the ports are open."""
        self.process = subprocess.Popen(
            [sys.executable, str(program), host], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, HOST: host, "PYTHONUNBUFFERED": "1"},
        )
        assert self.process.stdout is not None and self.process.stderr is not None
        for stream, take in ((self.process.stdout, self.said.put), (self.process.stderr, self.errors.append)):
            self.readers.append(threading.Thread(target=lambda s, t: [t(x) for x in s], args=(stream, take), daemon=True))
            self.readers[-1].start()

    def each(self) -> str:
        """Record the control cycle that has just ended; return how the client's program ended, "" while it
        runs."""
        robot = self.robot
        self.observe()
        if self.process is None:
            return ""
        if self.ended < 0 and self.process.poll() is not None:
            self.ended = robot.time
            for reader in self.readers:
                reader.join(1.0)
        self.hear()
        if robot.stopped and self.stopped < 0:
            self.stopped = robot.time
        if self.ended >= 0:
            return "ended" if robot.time > self.ended + AFTER else ""
        if robot.time > self.time_limit or (self.stopped >= 0 and robot.time > self.stopped + STOPPED + 60):
            return "timeout"
        return ""

    def observe(self) -> None:
        """Record the forces and the state of a control cycle."""
        self.peaks.see(self.robot.time, self.robot.arm)
        self.recorder.observe(self.robot.data, self.line)

    def hear(self) -> None:
        """Record the client's output, with the time at which it was read."""
        while not self.said.empty():
            self.recorder.message(self.robot.time, self.said.get().rstrip("\n"), self.line)

    def kill(self) -> None:
        """End the program's process."""
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def rollout(self, why: str) -> Rollout:
        """Return the record of the run with its outcome."""
        outcome, reason = self._outcome(why)
        return replace(self.recorder.rollout(outcome, reason), **self.peaks.arrays())

    def _outcome(self, why: str) -> tuple[str, str]:
        if self.robot.stopped:
            return "protective stop", f"line {self.line}: {self.robot.stopped}"
        if why == "timeout" or self.process is None:
            return "timeout", f"line {self.line}: the program still ran after {self.time_limit:g} s"
        if self.process.returncode == 0:
            return "finished", ""
        last = [m.text for m in self.recorder.messages if m.text.startswith(ABORT)]
        if last:
            return "halted", last[-1].removeprefix(ABORT)
        error = next((e.strip() for e in reversed(self.errors) if e.strip()), f"exit code {self.process.returncode}")
        return "error", f"line {self.line}: {error}"
