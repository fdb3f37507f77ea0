"""The process that executes texts: it says what ``execute`` says, and a dead one is noticed and replaced."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from cramlite import Engine
from cramlite.experiment import twins
from cramlite.experiment.executor import Executor, ExecutorDied
from cramlite.experiment.stopwatch import Stopwatch
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
        there, seconds = executor.run(TEXT, ".script", WORLD, 3)
        assert seconds > 0 and there.outcome == here.outcome == "finished"
        assert np.array_equal(there.joints, here.joints) and np.array_equal(there.wrench, here.wrench)
    assert [m.text for m in there.messages] == [m.text for m in here.messages]


def test_what_is_no_program_is_said_and_the_next_one_runs(executor: Executor) -> None:
    with pytest.raises(UserError, match="execution of a program broke"):
        executor.run("{", ".json", WORLD, 0)
    assert executor.run(TEXT, ".script", WORLD, 0)[0].outcome == "finished"


def test_a_dead_one_is_replaced(executor: Executor) -> None:
    executor.run(TEXT, ".script", WORLD, 0)
    assert executor._process is not None
    executor._process.kill()
    with pytest.raises(ExecutorDied, match="ended with -9"):
        executor.run(TEXT, ".script", WORLD, 0)
    assert executor.run(TEXT, ".script", WORLD, 0)[0].outcome == "finished"


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
    candidate = SimpleNamespace(code=SimpleNamespace(text=TEXT, suffix=".script"))
    rollout = twins._run(cast(Any, place), cast(Any, candidate), WORLD, 0)
    assert (rollout is not None) == found == ("execute" in place.watch.read())

