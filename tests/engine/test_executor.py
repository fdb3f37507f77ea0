"""The process that executes texts: it says what ``execute`` says, and a dead one is noticed and replaced."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from cramlite import Engine
from cramlite.base.stopwatch import Stopwatch
from cramlite.engine.proof.executor import Executor, ExecutorDied
from cramlite.experiment.demonstrations import twins
from cramlite.model import RobotMount, World
from cramlite.plugin import UserError

TEXT = "def p():\n  textmsg('here')\n  movej([0.1, -1.5, 1.5, -1.5, -1.5, 0.0], a=4, v=2)\nend\np()\n"
WORLD = World((), (RobotMount("arm", "ur5"),))


@pytest.fixture(scope="module")
def executor() -> Iterator[Executor]:
    found = Executor()
    yield found
    found.close()


def test_it_finds_what_this_process_finds(executor: Executor) -> None:
    knowledge = Engine().knowledge
    here = knowledge.simulator.execute(TEXT, WORLD, knowledge.robots, mount="arm", seed=3)
    for _ in range(2):  # the second time nothing of the first is left
        there, seconds = executor.run(TEXT, WORLD, 3)
        assert seconds > 0 and there.outcome == here.outcome == "finished"
        assert there.world == WORLD and np.isclose(there.times[1], 0.02)
        assert np.array_equal(there.joints, here.joints) and np.array_equal(there.wrench, here.wrench)
    assert [m.text for m in there.messages] == [m.text for m in here.messages]


def test_what_is_no_program_is_said_and_the_next_one_runs(executor: Executor) -> None:
    with pytest.raises(UserError, match="execution of a program was broken off"):
        executor.run("{", WORLD, 0)
    assert executor.run(TEXT, WORLD, 0)[0].outcome == "finished"


def test_a_dead_one_is_replaced(executor: Executor) -> None:
    executor.run(TEXT, WORLD, 0)
    assert executor.pid is not None
    os.kill(executor.pid, signal.SIGKILL)
    with pytest.raises(ExecutorDied, match="process that executes programs ended"):
        executor.run(TEXT, WORLD, 0)
    assert executor.run(TEXT, WORLD, 0)[0].outcome == "finished"


PARENT = """
import time
from cramlite.engine.proof.executor import Executor
from cramlite.model import RobotMount, World

executor = Executor()
executor.run("def p():\\nend\\np()\\n", World((), (RobotMount("arm", "ur5"),)), 0)
print(executor.pid, flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
def test_it_ends_when_its_parent_is_killed(tmp_path: Path) -> None:
    (tmp_path / "parent.py").write_text(PARENT)
    parent = subprocess.Popen([sys.executable, tmp_path / "parent.py"], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = Path("/proc") / parent.stdout.readline().strip()
    assert child.is_dir()
    parent.kill()
    parent.communicate()
    for _ in range(100):
        if not child.exists() or "Z" in (child / "stat").read_text().rpartition(")")[2].split()[0]:
            return
        time.sleep(0.1)
    raise AssertionError("it goes on without its parent")


@pytest.mark.parametrize(("deaths", "found"), [(1, True), (2, False)])
def test_a_text_that_kills_twice_is_given_up(executor: Executor, deaths: int, found: bool) -> None:
    class Dying:
        left = deaths

        def run(self, *what: Any) -> Any:
            self.left -= 1
            if self.left >= 0:
                raise ExecutorDied
            return executor.run(*what)

    place = SimpleNamespace(executor=Dying(), watch=Stopwatch())
    candidate = SimpleNamespace(written=SimpleNamespace(text=TEXT, suffix=".script"))
    rollout = twins._run(cast(Any, place), cast(Any, candidate), WORLD, 0)
    assert (rollout is not None) == found == ("execute" in place.watch.read())

