"""A cancel is heard wherever work takes time: within a run, a twin, a path query, a planner's process; and in all of a resolution."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import pytest

from cramlite import Engine, Solution, Trace, find_scenario, read_scenario
from cramlite.base.pulse import Stopped, pulse
from cramlite.engine.proof.executor_group import ExecutorGroup
from cramlite.model import Collision, RobotMount, World
from cramlite.planning.symbolic.pddl import PddlText
from cramlite.planning.symbolic.symbolic_planner import _end, fast_downward
from cramlite.plugin.selection import INSTALLED
from cramlite_plugins.motion_planning.planner import Path, plan

WORLD = World((), (RobotMount("arm", "ur5"),))
SHORT = "def p():\n  sleep(0.1)\nend\np()\n"
LONG = "def p():\n" + 20 * "  sleep(100)\n" + "end\np()\n"
"""2000 s of simulated time: a minute of CPU time and more."""
SOON = 30.0
"""Seconds of a busy machine within which work has ended that would take minutes."""
Proven = Callable[[str], Solution]


def after(seconds: float) -> Callable[[], bool]:
    """A stop that comes so many seconds from now."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end


@contextmanager
def ended_soon() -> Iterator[None]:
    """The block is left by a stop, and soon."""
    began = time.monotonic()
    with pytest.raises(Stopped):
        yield
    assert time.monotonic() - began < SOON


def test_within_a_run() -> None:
    knowledge = Engine().knowledge
    with ended_soon(), pulse(after(0.5)):
        knowledge.simulator.execute(LONG, WORLD, knowledge.robots, mount="arm", seed=0)


def test_within_a_twin_whose_processes_end_with_it() -> None:
    group = ExecutorGroup(INSTALLED, 1)
    next(group.runs(SHORT, iter([(WORLD, 0)])))  # its process is there by now
    with ended_soon():
        try:
            with pulse(after(0.5)):
                next(group.runs(LONG, iter([(WORLD, 0)])))
        finally:
            group.close()
    assert all(one.pid is None for one in group._all)


PARENT = f"""
from cramlite.engine.proof.executor import Executor
from cramlite.model import RobotMount, World
one = Executor()
one.run({SHORT!r}, World((), (RobotMount("arm", "ur5"),)), 0)
print("ready", flush=True)
one.run({LONG!r}, World((), (RobotMount("arm", "ur5"),)), 0)
"""


def test_processes_end_with_a_parent_that_was_killed() -> None:
    with subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None and parent.stderr is not None
        assert parent.stdout.readline() == "ready\n"
        time.sleep(0.5)
        began = time.monotonic()
        parent.send_signal(signal.SIGKILL)
        parent.stderr.read()  # until nobody has it any more
        assert time.monotonic() - began < SOON


class Halves:
    """Joint space of two halves with a wall between them: no path leads from one to the other."""

    limits = ((-3.0, 3.0), (-3.0, 3.0))

    def free(self, q: Sequence[float]) -> bool:
        return abs(q[0]) > 0.1

    def line_free(self, a: Sequence[float], b: Sequence[float]) -> bool:
        return self.free(a) and self.free(b) and a[0] * b[0] > 0

    def line_probed(self, a: Sequence[float], b: Sequence[float], apart: float = 0.05) -> bool:
        return self.line_free(a, b)

    def blocked(self, a: Sequence[float], b: Sequence[float]) -> float | None:
        return None if self.line_free(a, b) else 0.5

    def why(self, q: Sequence[float]) -> str:
        return "" if self.free(q) else "in the wall"

    def blocking(self, q: Sequence[float]) -> tuple[str, ...]:
        return ()

    def collision(self, q: Sequence[float]) -> Collision | None:
        return None

    def relaxed(self, anchors: Sequence[Sequence[float]]) -> Halves:
        return self

    def tip(self, q: Sequence[float]) -> Sequence[float]:
        return (*q, 0.0)


def test_within_a_path_query() -> None:
    halves = Halves()
    assert isinstance(plan(halves, (1.0, 0.0), [(2.0, 0.0)], seed=0), Path)  # type: ignore[arg-type]
    with ended_soon(), pulse(after(0.3)):
        plan(halves, (-1.0, 0.0), [(1.0, 0.0)], seed=0, samples=10**8)  # type: ignore[arg-type]


def test_waiting_for_the_path_query_of_another_thread() -> None:
    asked = threading.Event()

    def other() -> None:
        with pytest.raises(Stopped), pulse(asked.is_set):
            plan(Halves(), (-1.0, 0.0), [(1.0, 0.0)], seed=0, samples=10**8)  # type: ignore[arg-type]

    thread = threading.Thread(target=other)
    thread.start()
    time.sleep(0.5)
    try:
        with ended_soon(), pulse(after(0.3)):
            plan(Halves(), (-1.0, 0.0), [(1.0, 0.0)], seed=0, samples=10**8)  # type: ignore[arg-type]
    finally:
        asked.set()
        thread.join()


COUNTER = """(define (domain counter) (:requirements :adl) (:types bit) (:predicates (set ?x - bit))
  (:action flip :parameters (?x - bit) :effect (and (when (set ?x) (not (set ?x))) (when (not (set ?x)) (set ?x))))
  (:action two :parameters (?x ?y - bit) :precondition (not (= ?x ?y)) :effect (and
    (when (set ?x) (not (set ?x))) (when (not (set ?x)) (set ?x)) (when (set ?y) (not (set ?y))) (when (not (set ?y)) (set ?y)))))
"""


def test_within_a_planner() -> None:
    names = [f"b{k}" for k in range(40)]
    goal = " ".join(f"(set {n})" for n in names)
    problem = f"(define (problem all) (:domain counter) (:objects {' '.join(names)} - bit) (:init) (:goal (and {goal})))"
    with ended_soon(), pulse(after(0.1)):
        fast_downward(PddlText(COUNTER, problem, {}, {}), shortest=True)


def test_a_process_is_ended_with_those_that_it_started() -> None:
    with subprocess.Popen(["sh", "-c", "sleep 300 & sleep 300"], stdout=subprocess.PIPE, start_new_session=True) as process:
        _end(process)
        assert process.stdout is not None
        assert process.stdout.read() == b""  # until nobody has it any more
        assert process.returncode == -signal.SIGKILL


@pytest.mark.heavy
def test_a_resolution_ends_within_the_proof_of_its_program(proven: Proven) -> None:
    trace, asked = Trace(), threading.Event()
    lines: list[str] = []

    def progress(text: str) -> None:
        lines.append(text)
        if text.startswith("program 1: "):
            asked.set()

    scenario = read_scenario(find_scenario("grasp_one_thing"))
    assert next(Engine().resolve(scenario, trace=trace, progress=progress, stop=asked.is_set), None) is None
    assert "stopped by the caller" in {e.reason for e in trace.entries if e.kind == "stop"}
    assert not [e for e in trace.entries if e.kind == "proof"]
    assert next(Engine().resolve(scenario, stop=lambda: False)).code == proven("grasp_one_thing").code, "who asks changes nothing"


def test_work_of_others_around_it_ends_it_too() -> None:
    scenario = read_scenario(find_scenario("grasp_one_thing"))
    trace = Trace()
    with pytest.raises(Stopped), pulse(lambda: True):
        next(Engine().resolve(scenario, trace=trace), None)
    assert [e.kind for e in trace.entries] == ["stop"]


@pytest.mark.heavy
def test_the_lines_say_what_is_done(proven: Proven) -> None:
    solution, lines = proven("grasp_one_thing"), list[str]()
    next(Engine().resolve(read_scenario(find_scenario("grasp_one_thing")), progress=lines.append))
    told = [line for line in lines if line.startswith(("candidate", "program"))]
    assert solution.candidate.rollout is not None
    ran = solution.candidate.rollout.times[-1] - 2.0  # which the world has to come to rest
    (said,) = (line for line in told if line.startswith("program 1: "))
    steps, about = len(solution.program.steps), float(said.split()[-2])
    assert told[0].startswith("candidate 1: ") and said.startswith(f"program 1: {steps} steps run for about ")
    assert abs(about - ran) < 0.25 * ran, f"{about} is said, {ran} it takes"
