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
"""Longest time without a message from the program before the robot stops [s] (``backends/ur_rtde``, 0.5 Hz), and longest braking time
[s]."""
SILENT, ENDS = 5.0, 5.0
"""Time after which a program takes a controller with a stopped clock for lost [s], and longest time until the program then ends [s]."""
SLOW = 0.005
"""Largest speed of a joint that counts as standing [rad/s]."""
STANDS = 0.3
"""Time of standing after which an arm has come to rest [s]."""
_numbers = count(1)


def client_of(program: Path, folder: Path) -> Path:
    """Write the ur_rtde Python program of a typed program."""
    text = emit(read_program(program.read_text()).program, UR5E).text
    path = folder / "client.py"
    path.write_text(text, encoding="utf-8")
    return path


@contextmanager
def controlled(client: Path, world: str, folder: Path) -> Iterator[tuple[subprocess.Popen[Any], subprocess.Popen[str], Any]]:
    """Start a controller, the client program that drives it, and a reader of the robot's state; end all of them afterwards."""
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
    """Wait until the arm has moved for ``moment`` [s of the controller]; return the time for which it has moved, or had moved when the
    program ended."""
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
    """Kill the client program during its run, and return the time until the arm is at rest [s of the controller]; None if the program
    had ended before."""
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
    """Kill the controller during a run, and return the time until its client program ends [s], the program's exit code and last line;
    None if the program had ended before."""
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
    """Start an execution and kill it after some seconds; return whether it still ran then."""
    running = subprocess.Popen([*COMMAND, *map(str, command), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        running.wait(seconds)
    except subprocess.TimeoutExpired:
        running.kill()
        running.wait()
        return True
    return False


def lost(out: Path) -> str:
    """Return the first part of an execution's record that cannot be read, with the reason; "" if all recorded parts can be read."""
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
