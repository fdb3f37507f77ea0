"""What programs of others do beside moving along lines: inputs and outputs, settings, arcs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.short_programs import down, script

from cramlite.model import Pose
from cramlite_plugins.simulation.controller.trajectories import circular_motion

START = "p[" + ", ".join(f"{v:.6f}" for v in (*down(0.5, 0.0, 0.3).position, *down(0.5, 0.0, 0.3).rotvec)) + "]"


def said(body: str) -> list[str]:
    rollout = script(body)
    assert rollout.outcome == "finished", rollout.reason
    return [m.text for m in rollout.messages]


def test_outputs_are_kept_and_inputs_read_low_and_that_is_said() -> None:
    lines = said(
        "  set_standard_digital_out(1, True)\n  set_configurable_digital_out(2, True)\n  set_tool_digital_out(1, True)\n"
        "  textmsg(get_standard_digital_out(1) and get_digital_out(10) and get_digital_out(17) and not get_digital_out(2))\n"
        "  set_standard_analog_out(1, 0.25)\n  textmsg(get_analog_out(1))\n  set_flag(3, True)\n  textmsg(get_flag(3))\n"
        "  write_output_integer_register(2, 7)\n  textmsg(read_output_integer_register(2))\n"
        "  if get_standard_digital_in(4) == False:\n    textmsg(get_tool_analog_in(1) + get_standard_analog_in(0))\n  end\n"
        "  x = get_standard_digital_in(4)\n"
    )
    outputs = ["standard_digital_out(1)", "configurable_digital_out(2)", "tool_digital_out(1)"]
    assert lines[:3] == [f"{name} is on" for name in outputs]
    assert lines[3:7] == ["True", "0.25", "True", "7"]
    assert next(line for line in lines if "wired" in line) == "get_standard_digital_in(4) reads False: nothing is wired to the inputs here"
    assert sum("get_standard_digital_in" in line for line in lines) == 1 and lines[-1] == "0"


def test_a_digital_output_is_logged_when_it_changes() -> None:
    lines = said("  set_tool_digital_out(0, True)\n  set_tool_digital_out(0, True)\n  set_tool_digital_out(0, False)\n")
    assert lines == ["tool_digital_out(0) is on", "tool_digital_out(0) is off"]


def test_inverse_kinematics_far_from_its_seed_is_the_nearest_solution() -> None:
    near = "[1.7, -1.45, 1.78, -1.91, -1.57, 1.7]"  # halfway around the base
    pose = "p[-0.5, -0.2, 0.2, 0, 3.1416, 0]"
    solved = f"  q = get_inverse_kin({pose}, qnear={near})\n"
    assert said(f"{solved}  textmsg(pose_dist(get_forward_kin(q), {pose}) < 0.001 and q[2] > 0)\n") == ["True"]


@pytest.mark.parametrize(
    ("call", "why"),
    [
        ("get_standard_digital_in(8)", "8 is not in 0 .. 7"),
        ("set_tool_digital_out(2, True)", "2 is not in 0 .. 1"),
        ("set_analog_out(0, 5)", "a share of the output's range"),
        ("x = time(1)", "mode is 0 or 2"),
    ],
)
def test_what_there_is_not_is_an_error(call: str, why: str) -> None:
    rollout = script(f"  {call}")
    assert rollout.outcome == "error" and why in rollout.reason


def test_the_settings_that_pendants_write_first_change_nothing() -> None:
    assert said(
        "  set_standard_digital_input_action(0, \"default\")\n  set_runstate_standard_digital_outputs([0])\n"
        "  tool_wrench_limit_disable()\n  motion_version_set(2)\n  set_payload_mass(0.925)\n  set_payload_cog([0, 0, 0.06])\n"
        "  modbus_add_signal(\"192.168.0.9\", 255, 0, 0, \"door\", True, 24)\n  h = rpc_factory(\"xmlrpc\", \"http://127.0.0.1:1/RPC2\")\n"
        "  def unused():\n    return h.open()\n  end\n  t = time()\n  sleep(0.5)\n"
        "  textmsg(floor(10 * (time().sec - t.sec + (time().nanosec - t.nanosec) / 1000000000) + 0.5))\n"
        "  textmsg(random() == random())\n"
        "  textmsg(norm(get_actual_tcp_speed()) < 0.01 and pose_dist(tool_pose(), get_actual_tcp_pose()) < 1e-6)\n"
    ) == ["5", "False", "True"]  # fmt: skip


@pytest.mark.parametrize("mode", [0, 1])
def test_movec_goes_on_the_circle_through_its_point(mode: int) -> None:
    arc = "movec(pose_trans(s, p[0.05, 0.05, 0, 0, 0, 0]), pose_trans(s, p[0.1, 0, 0, 0, 0, 0]), a=0.5, v=0.1, mode="
    rollout = script(f"  s = {START}\n  movej(get_inverse_kin(s))\n  textmsg(0)\n  {arc}{mode})\n  textmsg(1)")
    assert rollout.outcome == "finished", rollout.reason
    begin = rollout.messages[0].time
    places = rollout.poses["effector"][rollout.times >= begin, :3]
    origin = places[0]
    centre = origin + (places[-1] - origin) / 2
    assert np.linalg.norm(places - centre, axis=1) == pytest.approx(0.05, abs=0.002)
    assert np.linalg.norm(places[-1] - origin) == pytest.approx(0.1, abs=0.002)
    way = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert way == pytest.approx(math.pi * 0.05, abs=0.003)
    turned = Pose((0, 0, 0), tuple(rollout.poses["effector"][-1, 3:])).inverse() * Pose((0, 0, 0), tuple(down(0, 0, 0).quaternion))
    assert np.linalg.norm(turned.rotvec) == pytest.approx(math.pi * mode, abs=0.02)


def test_a_circle_needs_three_points() -> None:
    start = Pose((0, 0, 0), (1, 0, 0, 0))
    for via, goal in (((1, 0, 0), (2, 0, 0)), ((0, 0, 0), (1, 1, 0)), ((1, 0, 0), (0, 0, 0))):
        with pytest.raises(ValueError, match="one line"):
            circular_motion(start, via, Pose(goal, (1, 0, 0, 0)), 0.1, 1.0, False)
    line = "movec(pose_trans(s, p[0.1, 0, 0, 0, 0, 0]), pose_trans(s, p[0.2, 0, 0, 0, 0, 0]))"
    rollout = script(f"  s = {START}\n  movej(get_inverse_kin(s))\n  {line}")
    assert rollout.outcome == "error" and "one line" in rollout.reason
    rollout = script(f"  movec({START}, {START}, mode=2)")
    assert rollout.outcome == "error" and "mode is 0" in rollout.reason


def test_a_way_round_the_back_is_longer_than_half_the_circle() -> None:
    motion = circular_motion(Pose((1, 0, 0), (1, 0, 0, 0)), (-1, 0, 0), Pose((0, -1, 0), (1, 0, 0, 0)), 0.1, 1.0, False)
    assert motion.way == pytest.approx(1.5 * math.pi)
    assert motion.at(motion.duration).distance(motion.goal)[0] < 1e-9
