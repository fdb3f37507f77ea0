"""speedj, speedl, servoj and tool_contact in a program's text."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_programs import script


def test_speedl_goes_at_its_speed_and_stops() -> None:
    rollout = script("  speedl([0, 0, 0.05, 0, 0, 0], a=0.5, t=1.0)\n  stopl(1.0)")
    assert rollout.outcome == "finished", rollout.reason
    height = rollout.poses["effector"][:, 2]
    # Half a way during each ramp of 0.1 s and 0.05 s.
    assert height[-1] - height[0] == pytest.approx(0.05 * (1.0 - 0.05 + 0.025), abs=0.004)


def test_speedj_without_a_stop_would_go_on() -> None:
    stopped = script("  speedj([0.2, 0, 0, 0, 0, 0], 1.0, 0.5)\n  stopj(2.0)\n  sleep(0.5)")
    goes_on = script("  speedj([0.2, 0, 0, 0, 0, 0], 1.0, 0.5)\n  sleep(0.5)")
    moved = [float(r.joints[-1, 0] - r.joints[0, 0]) for r in (stopped, goes_on)]
    assert moved[0] == pytest.approx(0.09, abs=0.02) and moved[1] == pytest.approx(0.18, abs=0.02)


def test_servoj_follows_targets_that_change() -> None:
    body = """  q = get_actual_joint_positions()
  i = 0
  while i < 100:
    q[0] = q[0] + 0.002
    servoj(q, t=0.008)
    i = i + 1
  end
  stopj(2.0)"""
    rollout = script(body)
    assert rollout.outcome == "finished", rollout.reason
    assert rollout.joints[-1, 0] - rollout.joints[0, 0] == pytest.approx(0.2, abs=0.06)
    assert np.abs(np.diff(rollout.joints[:, 0])).max() < 0.02


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("servoj(get_actual_joint_positions(), gain=5)", "gain 5 not in 100"),
        ("speedl([0, 0, 1, 0, 0, 0], a=0)", "positive acceleration"),
        ("servoc(get_actual_tcp_pose())", "not modelled"),
        ("get_target_waypoint()", "not modelled"),
        ("force_mode_set_gain_scaling(9)", "0 .. 2"),
        ("set_gravity([0, 9.81, 0])", "gravity here"),
        ("ft_rtde_input_enable(True)", "no external force sensor"),
        ("protective_stop()", "asked for it"),
    ],
)
def test_what_the_controller_does_not_do_is_said(call: str, said: str) -> None:
    rollout = script(f"  {call}")
    assert rollout.outcome in ("error", "protective stop") and said in rollout.reason


@pytest.mark.heavy
@pytest.mark.parametrize(("down", "found"), [(-0.03, True), (0.03, False)])
def test_tool_contact_finds_the_table_and_nothing_in_the_air(down: float, found: bool) -> None:
    body = f"""  zero_ftsensor()
  i = 0
  touched = 0
  while i < 1800 and touched == 0:
    speedl([0, 0, {down}, 0, 0, 0], a=0.5, t=get_steptime())
    touched = tool_contact()
    i = i + 1
  end
  stopl(2.0)
  if touched > 0:
    textmsg("touched")
  end"""
    rollout = script(body)
    assert ([m.text for m in rollout.messages] == ["touched"]) is found, rollout.reason
