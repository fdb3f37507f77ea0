"""Errors of arm, sensor and gripper in the closed loop: the controller is told one thing, and physics does another."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.edited import proven, run
from msgspec.structs import replace

from cramlite.model import Disturbance, Floats, Pose, RobotMount, Rollout, World
from cramlite_plugins.objects import products_and_fixtures as models
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.controller.arm_errors import ArmErrors
from cramlite_plugins.simulator.execute import execute

HOME = np.array(UR5E.home)
WORLD = World((models.table("floor", Pose((0, 0, -0.005))),), (RobotMount("arm", "ur5e"),))
THERE = [round(float(v), 4) for v in HOME + np.array([0.2, 0, 0, 0, 0, 0.5])]
ASK = f"""def p():
  movej({THERE}, a=1, v=0.5)
  sleep(0.5)
  textmsg(get_actual_joint_positions())
  zero_ftsensor()
  textmsg(force())
  movej({[*THERE[:4], THERE[4] + 1.5, THERE[5]]}, a=1, v=1)
  sleep(0.5)
  textmsg(force())
end
p()
"""


def ran(**off: object) -> Rollout:
    return execute(ASK, replace(WORLD, disturbance=Disturbance(**off)), {"ur5e": UR5E}, mount="arm", seed=1)  # type: ignore[arg-type]


CALM = ran()


def said(rollout: Rollout) -> list[str]:
    assert rollout.outcome == "finished", rollout.reason
    return [m.text for m in rollout.messages]


def told(rollout: Rollout) -> Floats:
    return np.array([float(v) for v in said(rollout)[0].strip("[]").split(",")])


def test_nothing_off_changes_not_a_bit() -> None:
    off = ran(joint_zeros=(0.0,) * 6, links=((0.0, 0.0, 0.0),) * 6)
    for name in ("joints", "wrench", "force", "opening"):
        assert np.array_equal(getattr(off, name), getattr(CALM, name))
    assert off.messages == CALM.messages


def test_joints_stand_beside_what_their_encoders_say() -> None:
    zeros = (0.003, -0.002, 0.0, 0.0, 0.001, 0.0)
    off = ran(joint_zeros=zeros)
    assert np.allclose(told(off), told(CALM), atol=2e-4)  # encoders are where they were sent
    k = len(CALM.times) // 4
    assert np.allclose(off.joints[k:] - CALM.joints[k:], zeros, atol=5e-4)


def test_play_leaves_the_joint_behind_its_encoder() -> None:
    off = ran(backlash=0.002)
    behind = CALM.joints[-1] - off.joints[-1]
    assert behind[0] == pytest.approx(0.001, abs=2e-4) and behind[4] == pytest.approx(0.001, abs=2e-4)
    assert np.allclose(told(off), told(CALM), atol=2e-4)


@pytest.mark.parametrize("cycles", [0, 1, 3])
def test_measurements_are_as_late_as_was_said(cycles: int) -> None:
    arm = ArmErrors(Disturbance(latency=0.008 * cycles, backlash=1e-9), np.zeros(6), 0.008)
    for k in range(1, 10):
        reading = arm.measured(np.full(6, float(k)), np.full(6, float(k)))
        assert arm.told[0] == max(k - cycles, 0) and reading[0] == max(k - cycles, 1)


def test_what_is_late_is_seen_late_by_the_program() -> None:
    late = ran(latency=0.04)  # two samples of a rollout
    aligned, not_aligned = (np.abs(late.force[12:60] - CALM.force[12 - k : 60 - k]).max() for k in (2, 0))
    assert aligned < 0.2 * not_aligned


def test_a_tare_takes_a_zero_that_is_off_but_not_what_turns_with_the_wrist() -> None:
    after = [float(v) for v in said(CALM)[1:]]
    off = [float(v) for v in said(ran(force_bias=(3.0, 0.0, 0.0)))[1:]]
    assert off == pytest.approx(after, abs=1e-6)
    turned = [float(v) for v in said(ran(force_turning=(0.0, 0.0, 3.0)))[1:]]
    assert turned[0] == pytest.approx(after[0], abs=1e-6) and abs(turned[1] - after[1]) > 1.0


def test_the_gripper_holds_with_another_force_than_was_ordered() -> None:
    candidate = proven("grasping")
    assert candidate.code is not None
    forces = []
    for share in (1.0, 0.5):
        world = replace(candidate.world, disturbance=Disturbance(gripper_force=share))
        rollout = run(candidate, candidate.code.text, world).rollout
        assert rollout is not None
        forces.append(max(t.force for t in rollout.touches[-1] if t.a == "effector/left"))
    assert forces[1] == pytest.approx(forces[0] / 2, rel=0.15)
