"""Processes of an execution that are killed by SIGKILL at a moment, and what became of the others and of what was recorded."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

from cramlite import UserError
from cramlite.engine.recovery.time_line import read_time_line
from cramlite.model.program.program_json import read_program
from cramlite.model.run.rollout import load_rollout
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.scenario.worlds import read_world
from cramlite_plugins.backends.ur_rtde.emit import emit
from cramlite_plugins.robots.ur5e import UR5E

COMMAND = [sys.executable, "-m", "cramlite"]
WATCHDOG, BRAKING = 2.0, 0.7
"""The robot stops if it has not heard from the program for so long [s] (``backends/ur_rtde``, 0.5 Hz), and brakes within so long."""
SILENT, ENDS = 5.0, 5.0
"""A program takes a controller whose clock stands still for so long for gone [s], and then ends within so long [s]."""
SLOW = 0.005
"""A joint that turns slower than this stands [rad/s]."""
STANDS = 0.3
"""An arm that stands for so long has come to rest [s]."""
_numbers = count(1)


def client_of(program: Path, folder: Path) -> Path:
    """Write the program of ur_rtde for a typed one."""
    text = emit(read_program(program.read_text()).program, UR5E).text
    path = folder / "client.py"
    path.write_text(text, encoding="utf-8")
    return path


@contextmanager
def controlled(client: Path, world: str, folder: Path) -> Iterator[tuple[subprocess.Popen[Any], subprocess.Popen[str], Any]]:
    """A controller, the program that drives it, and a reader of the robot's state; ended afterwards."""
    import rtde_receive

    host = f"127.{2 + os.getpid() % 200}.{next(_numbers)}.9"
    log = folder / f"controller_{host}.log"
    with log.open("w") as out:
        controller = subprocess.Popen([*COMMAND, "controller", "--world", world, "--host", host], stdout=out, stderr=out)
        driver = None
        try:
            until = time.monotonic() + 120.0
            while "Ready" not in log.read_text():
                assert controller.poll() is None and time.monotonic() < until, log.read_text()
                time.sleep(0.05)
            receive = rtde_receive.RTDEReceiveInterface(host)
            driver = subprocess.Popen([sys.executable, client, host], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            yield controller, driver, receive
        finally:
            for process in filter(None, (driver, controller)):
                process.kill()
                process.wait()


def moved_for(driver: subprocess.Popen[str], receive: Any, moment: float) -> float:
    """Wait until the arm has been under way for so long [s of the controller]; return how long it has, or had when the program ended."""
    began = None
    while driver.poll() is None:
        now = receive.getTimestamp()
        if began is None and max(map(abs, receive.getActualQd())) > SLOW:
            began = now
        if began is not None and now - began >= moment:
            return float(now - began)
        time.sleep(0.005)
    return 0.0 if began is None else float(receive.getTimestamp() - began)


def killed_client(client: Path, world: str, folder: Path, moment: float) -> float | None:
    """Return after how long the arm stands for good once its program was killed [s of the controller]; None where it had ended."""
    with controlled(client, world, folder) as (_, driver, receive):
        moved_for(driver, receive, moment)
        if driver.poll() is not None:
            return None
        driver.kill()
        at = moving = float(receive.getTimestamp())
        while (now := float(receive.getTimestamp())) - at < WATCHDOG + BRAKING + 2 * STANDS:
            if max(map(abs, receive.getActualQd())) > SLOW:
                moving = now
            time.sleep(0.005)
        return moving - at


def killed_controller(client: Path, world: str, folder: Path, moment: float) -> tuple[float, int, str] | None:
    """Return after how long the program ends once its controller was killed [s], its exit code and last line; None where it had ended."""
    with controlled(client, world, folder) as (controller, driver, receive):
        moved_for(driver, receive, moment)
        if driver.poll() is not None:
            return None
        controller.kill()
        at = time.monotonic()
        with suppress(Exception):
            receive.disconnect()
        said, _ = driver.communicate(timeout=120.0)
        return time.monotonic() - at, driver.returncode, (said.strip().splitlines() or [""])[-1]


def killed_executor(command: list[Any], out: Path, seconds: float) -> bool:
    """Begin an execution, and kill it after so long; whether it ran until then."""
    running = subprocess.Popen([*COMMAND, *map(str, command), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        running.wait(seconds)
    except subprocess.TimeoutExpired:
        running.kill()
        running.wait()
        return True
    return False


def lost(out: Path) -> str:
    """Say what of a record cannot be read; "" where all that is there can."""
    knowledge = Knowledge(Registry())
    rounds = sorted(p for p in out.glob("round_*") if p.is_dir())
    for folder in rounds:
        try:
            load_rollout(folder / "rollout.npz", read_world(str(folder / "world.json"), knowledge, 0))
            knowledge.episodes.read(folder / "episode")
        except (UserError, OSError) as error:
            return f"{folder.name}: {error}"
    if not (out / "time_line.json").exists():
        return "no time line" if len(rounds) > 1 else ""
    told = {m.round for m in read_time_line(out)}
    return "" if len(told) >= len(rounds) - 1 else f"{len(rounds)} rounds, and the time line has {len(told)}"
