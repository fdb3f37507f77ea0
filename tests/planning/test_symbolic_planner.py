"""Fast Downward is ended by counted work where it would go on and on, and says so; and with whoever started it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run

from cramlite.base.errors import NoSolution
from cramlite.planning.symbolic import symbolic_planner
from cramlite.planning.symbolic.pddl import PddlText
from cramlite.planning.symbolic.symbolic_planner import fast_downward

DOMAIN = """(define (domain lamps) (:requirements :adl) (:types lamp) (:predicates (lit ?x - lamp))
  (:action two :parameters (?x ?y - lamp) :precondition (not (= ?x ?y)) :effect (and
    (when (lit ?x) (not (lit ?x))) (when (not (lit ?x)) (lit ?x)) (when (lit ?y) (not (lit ?y))) (when (not (lit ?y)) (lit ?y)))))
"""
"""Lamps of which any two are switched at once: an odd number of them is never lit, which only a search through all states shows."""


def lamps(count: int, lit: int) -> PddlText:
    """The problem that the first so many lamps shall be lit, and no other."""
    names = [f"l{k}" for k in range(count)]
    goal = " ".join(f"(lit {n})" if k < lit else f"(not (lit {n}))" for k, n in enumerate(names))
    problem = f"(define (problem some) (:domain lamps) (:objects {' '.join(names)} - lamp) (:init) (:goal (and {goal})))"
    return PddlText(DOMAIN, problem, {}, {})


def test_a_search_that_would_go_on_and_on_is_ended_by_counted_states() -> None:
    said = list[str]()
    assert fast_downward(lamps(32, 1), progress=said.append).plan is None
    assert "no plan among the states that fit into 64M of memory" in said


def test_a_plan_and_that_there_is_none_are_found_within_that() -> None:
    said = list[str]()
    assert (fast_downward(lamps(32, 2), progress=said.append).plan or "").startswith("(two l")
    assert fast_downward(lamps(8, 1), progress=said.append).plan is None
    assert not said


def test_a_goal_without_the_planner_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch, run: Run, tmp_path: Path) -> None:
    monkeypatch.setattr(symbolic_planner, "find_spec", lambda name: None)
    ran = run("resolve", "hang_up_a_product", "--out", tmp_path / "run")
    assert ran.code == 2 and "pip install up-fast-downward" in ran.err and "Traceback" not in ran.err


GRID = """(define (domain grid) (:types cell) (:predicates (near ?a ?b ?c ?d - cell) (there))
  (:action go :parameters (?a ?b ?c ?d - cell) :precondition (and) :effect (and (near ?a ?b ?c ?d) (there))))
"""
"""A domain with as many actions as cells to the fourth power, all of which the translator writes down."""


def grid(cells: int) -> PddlText:
    """The problem to be there, for which any action will do."""
    names = " ".join(f"c{k}" for k in range(cells))
    goal = "(and (there) (near c0 c1 c0 c1))"
    return PddlText(GRID, f"(define (problem all) (:domain grid) (:objects {names} - cell) (:init) (:goal {goal}))", {}, {})


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="neither limits memory")
def test_a_problem_too_large_for_its_translator_is_refused_with_what_to_try(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(symbolic_planner, "TRANSLATOR_ROOM", "100M")
    assert (fast_downward(grid(3)).plan or "").endswith("(go c0 c1 c0 c1)\n; cost = 2 (unit cost)\n")
    with pytest.raises(NoSolution, match=r"takes more than 100M of memory .* Ask for less at a time"):
        fast_downward(grid(40))


STUCK = """
import resource, sys, time
resource.setrlimit(resource.RLIMIT_AS, (200 << 20, 200 << 20))
kept, size = [], int(sys.argv[2]) << 20
try:
    while size:
        kept.append(bytearray(1 << 16))
        size -= 1 << 16
except MemoryError:
    pass
print("made", flush=True)
time.sleep(60)
"""
"""A process that takes so many megabytes [MB], or all that it may have, and then goes on without end."""


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="neither limits memory")
@pytest.mark.parametrize(("size", "code"), [(20, None), (400, symbolic_planner.TOO_LARGE)])
def test_a_translator_that_goes_on_without_memory_is_ended(size: int, code: int | None, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("TRANSLATOR_ROOM", "200M"), ("LOOK", 0.05), ("LONGEST", 1.0 if code is None else 60.0)):
        monkeypatch.setattr(symbolic_planner, name, value)
    command = [sys.executable, "-c", STUCK, "fast_downward.translate", str(size)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdout is not None and process.stdout.readline() == b"made\n"
        assert symbolic_planner._wait(process, time.monotonic()) == code
        assert process.returncode is not None


PARENT = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
from cramlite.planning.symbolic.pddl import PddlText
from cramlite.planning.symbolic.symbolic_planner import fast_downward
fast_downward(PddlText({domain!r}, {problem!r}, {{}}, {{}}))
"""


def planners(folder: Path) -> list[int]:
    """Processes that have the folder among their arguments."""
    found = []
    for one in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str(folder).encode() in (one / "cmdline").read_bytes() and b"translate" in (one / "cmdline").read_bytes():
                found.append(int(one.name))
    return found


def within(seconds: float, holds: Callable[[], bool]) -> bool:
    """Whether something holds within a time."""
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return holds()


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="needs /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_translator_outlives_its_parent(tmp_path: Path, number: signal.Signals) -> None:
    large = grid(60)
    text = PARENT.format(domain=large.domain, problem=large.problem)
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-c", text], env=environment, stderr=subprocess.DEVNULL) as parent:
        assert within(20.0, lambda: len(planners(tmp_path)) == 2), "the driver and the translator run"
        parent.send_signal(number)
        assert parent.wait(20.0)
    assert within(10.0, lambda: not planners(tmp_path))
