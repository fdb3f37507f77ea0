"""The processes that an engine keeps: used again, freed of runs that nobody needs, and gone when it is."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.pulse import Stopped, pulse
from cramlite.engine.proof.executor_group import ExecutorGroup, _List
from cramlite.model import RobotMount, World
from cramlite.plugin.selection import INSTALLED

WORLD = World((), (RobotMount("arm", "ur5"),))
SHORT = "def p():\n  sleep(0.1)\nend\np()\n"
LONG = "def p():\n" + 20 * "  sleep(100)\n" + "end\np()\n"
SOON = 30.0
"""Seconds of a busy machine within which a run has ended that would take a minute of CPU time."""
pytestmark = pytest.mark.heavy


def after(seconds: float) -> Callable[[], bool]:
    """A stop that comes so many seconds from now."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end


def alive(pid: int | None) -> bool:
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and "Z" not in stat.read_text().rpartition(")")[2].split()[0]


def pids(group: ExecutorGroup) -> set[int]:
    return {one.pid for one in group._all if one.pid is not None}


@pytest.fixture
def group() -> Iterator[ExecutorGroup]:
    with closing(ExecutorGroup(INSTALLED, 2)) as found:
        yield found


def test_a_list_that_is_left_ends_its_run_and_its_process_runs_the_next(group: ExecutorGroup) -> None:
    next(group.runs(SHORT, iter([(WORLD, 0)])))
    before = pids(group)
    with closing(group.runs(LONG, iter([(WORLD, 0)]))) as runs, pytest.raises(Stopped), pulse(after(1.0)):
        next(runs)
    began = time.monotonic()
    assert not any(isinstance(run, str) for run in group.runs(SHORT, iter([(WORLD, k) for k in range(4)])))
    assert time.monotonic() - began < SOON and before <= pids(group)


def test_a_stop_leaves_no_process_and_loses_nothing(group: ExecutorGroup) -> None:
    next(group.runs(SHORT, iter([(WORLD, 0)])))
    before = pids(group)
    group.stop()
    assert before and not any(map(alive, before)) and not pids(group)
    assert not isinstance(next(group.runs(SHORT, iter([(WORLD, 0)]))), str)


def test_an_engine_keeps_its_processes_until_it_is_gone() -> None:
    scenario, engine = read_scenario(find_scenario("tasks/picking_up")), Engine()
    first = next(engine.resolve(scenario, setting=engine.setting(scenario, twins=1)))
    before = pids(engine.executors)
    second = next(engine.resolve(scenario, setting=engine.setting(scenario, twins=1)))
    assert first.verdict == second.verdict and len(before) == 1 and pids(engine.executors) == before
    assert Engine().executors is not engine.executors
    del engine, first, second
    gc.collect()
    assert not any(map(alive, before))


def test_a_group_may_be_gone_while_a_run_is_under_way() -> None:
    group = ExecutorGroup(INSTALLED, 1)
    next(group.runs(SHORT, iter([(WORLD, 0)])))
    before, run = pids(group), group._threads.submit(group._run, _List(), LONG, WORLD, 0)
    time.sleep(0.5)
    group.close()
    assert isinstance(run.result(SOON), str) and not any(map(alive, before))
    other = ExecutorGroup(INSTALLED, 1)
    ended = other._threads.submit(other._end)  # as where the last one who has it is a thread of its own
    assert ended.result(SOON) is None
