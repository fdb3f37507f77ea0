"""A long arm that carries something far round: its program is slowed, proven, and ready; as fast as usual it is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.edited import engine, objections, run

from cramlite import read_scenario
from cramlite.engine.real_arm.preflight import Flight, checks
from cramlite.model import MoveJoints
from cramlite.plugin import Candidate

FAR_ROUND = """
scenario: far_round
title: Take a block far beside a long arm
tasks:
  - {task: Grasping, Patient: block}
robot: {type: ur20}
things:
  - {name: floor, model: table, at: {position: [0, 0, -5 mm]}, with: {size: [3.6 m, 3.6 m, 20 mm]}}
  - {name: block, model: block, at: {position: [-0.2, 1.5, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
proof: {twins: 0}
"""


def exceeded(candidate: Candidate) -> list[str]:
    """Limits that preflight says are exceeded, of a run that it is shown."""
    assert candidate.rollout is not None and candidate.code is not None
    flight = Flight(candidate.robot, candidate.code, candidate.rollout, candidate.program)
    return [c.name for c in checks(flight, {}) if not c.passed]


@pytest.mark.heavy
def test_what_is_proven_is_ready_and_what_is_not_ready_is_not_proven(tmp_path: Path) -> None:
    path = tmp_path / "far_round.yaml"
    path.write_text(FAR_ROUND)
    good = next(engine().resolve(read_scenario(path))).candidate
    (step,) = (s for s in good.program.steps if isinstance(s, MoveJoints))
    assert 0.5 < step.speed < 1.05 and "as the tool goes 1.5 m/s at most" in step.comment
    assert objections(run(good, good.code.text if good.code else "")) == {} and exceeded(good) == []
    assert good.code is not None and f"v={step.speed:g})" in good.code.text
    usual = run(good, good.code.text.replace(f"v={step.speed:g})", "v=1.05)"))
    assert set(objections(usual)) == {"tool_speed"} and exceeded(usual) == ["tool speed"]
    slower = run(good, good.code.text.replace(f"v={step.speed:g})", "v=0.5)"))
    assert objections(slower) == {} and exceeded(slower) == []
