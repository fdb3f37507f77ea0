"""Programs that must not run on: refused before the start, or stopped by a limit, each with its line and a clear reason."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import Run

from cramlite.model import Program, Repeat, RobotMount, Wait, World, write_program
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.execute import execute
from cramlite_plugins.ur_controller.client_program import can_run, execute_client
from cramlite_plugins.ur_controller.urscript.interpreter import Limits
from cramlite_plugins.ur_controller.virtual_robot import VirtualRobot

EMPTY = World((), (RobotMount("arm", "ur5e"),))
ROBOTS = {"ur5e": UR5E}
BEFORE = {  # refused before anything moves
    "calls an unknown function": ("  mvoel(1)", "line 2: there is no function 'mvoel'; did you mean 'movel'?"),
    "calls one with too few values": ("  movej()", "line 2: 'movej"),
    "nests without end": ("  x = " + "(" * 500, "line 2: nested more than"),
    "is one endless expression": ("  x = 1" + " + 1" * 5000, "line 2: an expression or block is too long"),
    "reads what nobody wrote": ("  x = y", "line 2: 'y' is assigned nowhere"),
}
WHILE = {  # stopped by a limit
    "loops for ever": ("  while True:\n    x = 1\n  end", "line 2: 50000 statements without .* an endless loop"),
    "recurses without end": ("  def f():\n    f()\n  end\n  f()", "line 3: .*endless recursion"),
    "recurses by turns": ("  def f():\n    g()\n  end\n  def g():\n    f()\n  end\n  f()", "endless recursion"),
    "lengthens a text without end": ('  s = "ab"\n  while True:\n    s = str_cat(s, s)\n    sync()\n  end', "line 4: .*longest"),
    "starts threads without end": (
        "  thread t():\n    while True:\n      sync()\n    end\n  end\n  while True:\n    run t()\n  end", "line 8: .*threads",
    ),
    "opens a socket elsewhere": ('  socket_open("192.168.0.7", 80)', "192.168.0.7:80 refused: only the gripper's server"),
    "opens another port here": ('  socket_open("127.0.0.1", 22)', "line 2: socket to 127.0.0.1:22 refused"),
    "asks for a name elsewhere": ('  socket_open("example.com", 63352)', "line 2: socket to example.com:63352 refused"),
    "waits for ever": ("  while True:\n    sync()\n  end", "the program still ran after 1 s"),
    "sleeps for ever": ("  sleep(1e9)", "line 2: the program still ran after 1 s"),
    "waits for a gripper that never answers": (
        '  socket_open("127.0.0.1", 63352, "g")\n  x = socket_read_byte_list(3, "g", 0)\n  sleep(5)', "still ran after 1 s",
    ),
}  # fmt: skip


def program(body: str) -> str:
    return f"def p():\n{body}\nend\n"


@pytest.mark.parametrize("what", BEFORE)
def test_it_is_refused_before_the_start(what: str, tmp_path: Path, run: Run) -> None:
    body, said = BEFORE[what]
    path = tmp_path / "p.script"
    path.write_text(program(body))
    for command in (("check", path), ("execute", path, "--world", "grasp_one_thing")):
        ran = run(*command)
        assert ran.code == 2 and said in ran.err and ran.err.count("\n") == 1, ran.err


def test_what_only_another_controller_has_is_named_by_check_and_does_not_run(tmp_path: Path, run: Run) -> None:
    path = tmp_path / "p.script"
    path.write_text(program("  set_tool_wrench_guard(1)\n  modbus_get_error(1)"))
    checked = run("check", path)
    assert checked.code == 0 and f"{path}:2: cannot run here: there is no function 'set_tool_wrench_guard' here" in checked.out
    assert f"{path}:3: cannot run here: the controller model does not have UR's function 'modbus_get_error'" in checked.out
    ran = run("execute", path, "--world", "grasp_one_thing")
    assert ran.code == 2 and "line 2: there is no function 'set_tool_wrench_guard' here" in ran.err and "1 more place" in ran.err


@pytest.mark.parametrize("what", WHILE)
def test_it_is_stopped_by_a_limit(what: str) -> None:
    body, said = WHILE[what]
    rollout = execute(program(body), EMPTY, ROBOTS, mount="arm", time_limit=1.0, limits=Limits(slice=50_000))
    assert rollout.outcome in ("error", "timeout")
    assert re.search(said, rollout.reason), rollout.reason
    assert abs(rollout.joints[-1] - rollout.joints[0]).max() < 5e-3, "nothing moved"


def test_none_of_it_stops_one_that_is_well() -> None:
    calls = "  def f(n):\n    if n > 0:\n      f(n - 1)\n    end\n  end\n  f(50)\n"
    body = calls + '  i = 0\n  while i < 20:\n    sync()\n    i = i + 1\n  end\n  socket_open("127.0.0.1", 63352)'
    done = execute(program(body), EMPTY, ROBOTS, mount="arm", time_limit=1.0, limits=Limits(slice=50_000))
    assert done.outcome == "finished", done.reason


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("  while True:\n    x = 1\n  end", "endless loop"),
        ("  def f():\n    f()\n  end\n  f()", "endless recursion"),
        ('  socket_open("192.168.0.7", 80)', "socket to 192.168.0.7:80 refused"),
        ("  no_such_function()", "there is no function 'no_such_function'"),
    ],
)
def test_the_virtual_controller_stops_it_and_takes_the_next_program(body: str, said: str) -> None:
    log: list[str] = []
    robot = VirtualRobot(EMPTY, ROBOTS, "arm", log.append)
    robot.receive(program(body))
    for _ in range(5):
        robot.cycle()
    assert not robot.running and any(said in line for line in log), log
    robot.receive(program('  textmsg("the next one")'))
    for _ in range(3):
        robot.cycle()
    assert any("the next one" in line for line in log)


def test_one_that_waits_for_ever_is_ended_by_the_next() -> None:
    log: list[str] = []
    robot = VirtualRobot(EMPTY, ROBOTS, "arm", log.append)
    robot.receive(program("  while True:\n    sync()\n  end"))
    for _ in range(5):
        robot.cycle()
    assert robot.running
    robot.receive(program('  textmsg("the next one")'))
    robot.cycle()
    assert any("replaced by a new program" in line for line in log) and any("the next one" in line for line in log)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("body", "outcome", "said"),
    [
        ("import time\nwhile True:\n    time.sleep(0.1)\n", "timeout", "still ran after 1 s"),
        ("def f():\n    f()\nf()\n", "error", "RecursionError"),
        ("import sys\nsys.exit(3)\n", "error", "exit code 3"),
    ],
)
def test_a_python_program_that_never_talks_to_the_robot_is_ended_too(body: str, outcome: str, said: str) -> None:
    """A Python program is known to be one for ur_rtde by its import, which is in a text here."""
    text = f'"""from rtde_control import RTDEControlInterface"""\n{body}'
    if can_run():
        pytest.skip(can_run())
    rollout = execute_client(text, EMPTY, ROBOTS, mount="arm", time_limit=1.0)
    assert rollout.outcome == outcome and said in rollout.reason


def test_a_typed_program_that_repeats_without_end_is_refused(tmp_path: Path, run: Run) -> None:
    steps = (Repeat((Wait(1.0),), 10**9, origin="again"),)
    typed = Program("p", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, steps, (), mass=0.925, center=(0, 0, 0.05))
    path = tmp_path / "p.json"
    path.write_text(write_program(typed))
    ran = run("check", path)
    assert ran.code != 0 and "again" in ran.out + ran.err and "1000" in ran.out + ran.err
