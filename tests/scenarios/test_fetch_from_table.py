"""Fetching from a table 3 m away: the robot must drive there, and back with what it took."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from cramlite import Budget, Engine, Trace, find_scenario, read_scenario
from cramlite.model import Floats, Pose


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


@pytest.mark.heavy
def test_it_is_fetched(engine: Engine) -> None:
    solution = next(engine.resolve(read_scenario(find_scenario("fetch_from_table"))))
    rollout = solution.candidate.rollout
    assert rollout is not None and solution.candidate.code is not None
    assert solution.candidate.code.language == "json" and '"Drive"' in solution.code
    block, base = rollout.poses["block"], rollout.poses["arm/base"]
    assert math.dist(block[0, :2], block[-1, :2]) > 2.0
    assert base[:, 0].max() > 1.9, "the arm reaches no further than 1.01 m"
    end = solution.candidate.belief.base().position
    assert math.dist(end[:2], (solution.candidate.robot.arm_at(_pose(base[-1]))).position[:2]) < 0.005


def test_an_arm_that_is_bolted_down_cannot(engine: Engine) -> None:
    scenario = read_scenario(find_scenario("fetch_from_table"))
    bolted = scenario.spec.model_copy(update={"robot": scenario.spec.robot.model_copy(update={"type": "ur5e"})})
    trace = Trace()
    assert not list(engine.resolve(replace(scenario, spec=bolted), budget=Budget(expansions=200), trace=trace))
    assert any("m > 1.01 m reach of arm 'ur5e'" in e.reason for e in trace.entries)


@pytest.mark.heavy
def test_who_may_not_drive_cannot(engine: Engine) -> None:
    """Without the two drives the block is out of reach from where the robot starts."""
    scenario = read_scenario(find_scenario("fetch_from_table"))
    assert scenario.spec.tasks is not None
    stays = scenario.spec.model_copy(update={"tasks": scenario.spec.tasks[1:3]})
    trace = Trace()
    assert not list(engine.resolve(replace(scenario, spec=stays), budget=Budget(expansions=300, proofs=1), trace=trace))
    assert any("m > 0.917 m of arm 'ur5e_mobile'" in e.reason for e in trace.entries)


def _pose(row: Floats) -> Pose:

    return Pose(tuple(row[:3]), tuple(row[3:]))
