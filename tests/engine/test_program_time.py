"""How long a program runs is known well before it runs."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from cramlite import Solution
from cramlite.engine.proof.program_time import TARE, about
from cramlite.model import AnyStep, Fallback, Monitor, MoveJoints, Parallel, Repeat, SetGripper, Wait, ZeroSensor

Proven = Callable[[str], Solution]


def of_steps(solution: Solution, *steps: AnyStep) -> float:
    return about(replace(solution.program, steps=steps), solution.setting.robot)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["grasp_one_thing", "take_off_hanger_tasks"])
def test_of_programs_that_ran(proven: Proven, name: str) -> None:
    solution = proven(name)
    assert solution.candidate.rollout is not None
    ran = solution.candidate.rollout.times[-1] - 2.0  # which the world has to come to rest
    assert abs(about(solution.program, solution.setting.robot) - ran) < 0.25 * ran


def test_of_steps(proven: Proven) -> None:
    solution = proven("grasp_one_thing")
    start = solution.program.start
    there = (start[0] + 1.0, *start[1:])
    move = MoveJoints((there, start), 0.5, 1.0)
    assert of_steps(solution) == 0.0
    assert of_steps(solution, Wait(3.0), ZeroSensor()) == pytest.approx(3.0 + TARE)
    assert of_steps(solution, move) == pytest.approx(2 * (1.0 / 0.5 + 0.5 / 1.0))
    assert of_steps(solution, SetGripper(0.0, 0.001, 20.0, timeout=3.0)) == 3.0
    assert of_steps(solution, Repeat((Wait(2.0),), 3), Monitor((Wait(1.0),))) == pytest.approx(7.0)
    assert of_steps(solution, Parallel(((Wait(2.0),), (Wait(5.0),))), Fallback(((Wait(1.0),), (Wait(9.0),)))) == pytest.approx(6.0)
