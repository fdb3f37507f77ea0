"""The virtual UR controller: emitted text moves the arm and stops with a reason."""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers.short_programs import CLOSED, FINGERTIP, GUARDED, WORLD, down, go, run, script, text
from helpers.standard import ROBOTS

from cramlite.model import MoveJoints, MoveLinear, Rollout
from cramlite.plugin import UserError
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.execute import execute
from cramlite_plugins.ur_controller.urscript.interpreter import Limits

# Motion


def test_movej_reaches_its_target() -> None:
    goal = tuple(np.add(UR5E.home, (0.5, -0.2, 0.3, 0.1, 0.2, 0.3)))
    rollout = run(MoveJoints(path=(goal,), speed=1.5, acceleration=3.0))
    assert (rollout.outcome, rollout.reason) == ("finished", "")
    assert np.abs(rollout.joints[-1] - goal).max() < 1e-3
    assert np.abs(rollout.joints[len(rollout.joints) // 4] - goal).max() > 0.05


def slowest(rollout: Rollout) -> float:
    """The least speed of the fastest joint between the first and the last 0.5 s of the motion [rad/s]."""
    rates = np.abs(np.diff(rollout.joints, axis=0)).max(axis=1) / np.diff(rollout.times)
    moving = np.flatnonzero(rates > 0.02)
    inner = rates[moving[0] : moving[-1]]
    skip = round(0.5 / float(np.diff(rollout.times).mean()))
    return float(inner[skip:-skip].min())


def test_a_blend_rounds_the_corner_without_a_stop_and_without_it_the_arm_stops() -> None:
    corner = tuple(np.add(UR5E.home, (0.8, 0, 0, 0, 0, 0)))
    goal = tuple(np.add(corner, (0, -0.4, 0.6, 0, 0, 0)))
    smooth = run(MoveJoints(path=(corner, goal), speed=1.0, acceleration=3.0, radii=(0.1,)))
    stops = run(MoveJoints(path=(corner, goal), speed=1.0, acceleration=3.0))
    assert (smooth.outcome, stops.outcome) == ("finished", "finished")
    assert slowest(smooth) > 0.15
    assert slowest(stops) < 0.05
    assert smooth.times[-1] < stops.times[-1] - 0.1
    assert np.abs(smooth.joints[-1] - goal).max() < 1e-3
    off = np.linalg.norm(smooth.poses["effector"][:, :3] - np.array(forward(UR5E, corner).position), axis=1).min()
    assert 0.01 < off < 0.1
    assert np.abs(stops.joints - corner).max(axis=1).min() < 0.005


def test_a_blend_into_something_else_stops_at_its_target() -> None:
    """As a movel with a radius does; what asks the arm or moves it otherwise comes after."""
    home = "[" + ", ".join(f"{v:.6f}" for v in UR5E.home) + "]"
    goal = np.add(UR5E.home, (0.3, 0, 0, 0, 0, 0))
    near = "[" + ", ".join(f"{v:.6f}" for v in goal) + "]"
    for rest in ("sleep(0.1)", "movel(pose_trans(get_actual_tcp_pose(), p[0, 0, -0.01, 0, 0, 0]))", "set_digital_out(0, True)", "x = 1"):
        rollout = script(f"  movej({near}, r=0.05)\n  {rest}")
        assert rollout.outcome == "finished", (rest, rollout.reason)
        assert np.abs(rollout.joints - goal).max(axis=1).min() < 4e-3, rest  # it sags
    asked = script(f"  movej({near}, r=0.05)\n  q = get_target_joint_positions()\n  textmsg(q[0])\n  movej({home})")
    assert float(asked.messages[0].text) == pytest.approx(goal[0], abs=1e-4)


def test_a_blend_that_its_thread_leaves_behind_and_one_that_is_too_large_are_errors() -> None:
    home = "[" + ", ".join(f"{v:.6f}" for v in UR5E.home) + "]"
    near = "[" + ", ".join(f"{v:.6f}" for v in np.add(UR5E.home, (0.3, 0, 0, 0, 0, 0))) + "]"
    left = script(f"  thread t():\n    movej({near}, r=0.05)\n  end\n  run t()\n  sleep(1)")
    assert (left.outcome, "followed by another movej" in left.reason) == ("error", True)
    wide = script(f"  movej({near}, r=0.4)\n  movej({home})")
    assert (wide.outcome, "takes more than half" in wide.reason) == ("error", True)
    assert script(f"  movej({near}, r=0.05)\n  movej({home})").outcome == "finished"


def test_a_duration_has_priority_over_speed() -> None:
    near = "[" + ", ".join(f"{v:.6f}" for v in np.add(UR5E.home, (0.3, 0, 0, 0, 0, 0))) + "]"
    rollout = script(f"  movej({near}, a=1.4, v=1.05, t=3)")
    assert rollout.outcome == "finished"
    assert rollout.times[-1] == pytest.approx(3.0, abs=0.03)


def test_movel_stays_on_its_line() -> None:
    start, goal = down(0.45, -0.2, 0.3), down(0.6, 0.1, 0.2)
    rollout = run(go(start), MoveLinear(target=goal, speed=0.25, acceleration=1.0))
    a, b = np.array(start.position), np.array(goal.position)
    way = (b - a) / np.linalg.norm(b - a)
    points = rollout.poses["effector"][:, :3] - a
    on = rollout.lines == max(rollout.lines[:-20])
    offsets = np.linalg.norm(points - np.outer(points @ way, way), axis=1)
    assert offsets[-1] < 1e-3
    assert offsets[np.flatnonzero(offsets > 0.002)[-1] + 1 :].size > 60  # the line itself took over a second
    assert np.linalg.norm(rollout.poses["effector"][-1, :3] - b) < 1e-3
    assert on.any()


def test_a_joint_motion_leaves_the_line_that_movel_keeps() -> None:
    start, goal = down(0.45, -0.2, 0.3), down(0.6, 0.1, 0.2)
    rollout = run(go(start), go(goal))
    a, b = np.array(start.position), np.array(goal.position)
    way = (b - a) / np.linalg.norm(b - a)
    points = rollout.poses["effector"][-80:, :3] - a
    assert np.linalg.norm(points - np.outer(points @ way, way), axis=1).max() > 2e-3


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (
            "movel(p[2, 0, 0.3, 3.14159, 0, 0], v=0.05)",
            r"the pose at \(2.000, 0.000, 0.300\) m that it moves to is out of reach, and on the way there: .*(no inverse|rad/s)",
        ),
        ("movej([0, 0, 0, 0, 0, 6.4], v=3)", "'wrist_3' at 6.28"),
        ("movej([0, -1.57, 0, 0, 0, 0], a=40, v=6)", "rad/s > 3.14 rad/s"),
        ("movej([3.14, -0.5, 2.2, -2, -1.57, 1.57], v=1)", "limit|off its command|force"),
    ],
)
def test_what_the_arm_cannot_do_ends_in_a_protective_stop(body: str, reason: str) -> None:
    rollout = script(f"  {body}")
    assert rollout.outcome == "protective stop"
    assert rollout.reason.startswith("line 2: ")
    assert re.search(reason, rollout.reason)


def test_a_straight_line_that_only_runs_too_fast_is_not_said_to_be_out_of_reach() -> None:
    rollout = script("  movel(pose_add(get_actual_tcp_pose(), p[-0.15, 0, 0, 0, 0, 0]), a=60, v=6)")
    assert rollout.outcome == "protective stop" and "rad/s > " in rollout.reason and "out of reach" not in rollout.reason, rollout.reason


@pytest.mark.parametrize("radius", ["0", "0.02"])
def test_a_blend_radius_of_a_line_is_told_and_the_arm_stops_at_the_corner(radius: str) -> None:
    sides = ("0, 0.1, 0", "0.1, 0.1, 0", "0.1, 0, 0")
    lines = "".join(f"  movel(pose_add(at, p[{side}, 0, 0, 0]), r={radius})\n" for side in sides)
    rollout = script(f"  at = get_actual_tcp_pose()\n{lines}")
    told = [m for m in rollout.messages if "a blend radius is not modelled" in m.text]
    assert rollout.outcome == "finished" and len(told) == (radius != "0"), rollout.messages


def test_the_start_posture_is_checked() -> None:
    start = (UR5E.home[0] + 0.05, *UR5E.home[1:])
    rollout = execute(text(start=start), WORLD, ROBOTS, mount="arm", settle=0.0)
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"joint 0 is at [\d.]+ rad, the program starts from [\d.]+ rad", rollout.reason)
    assert execute(text(), WORLD, ROBOTS, mount="arm", settle=0.0).outcome == "finished"


def test_a_program_that_ends_in_motion_leaves_the_arm_at_rest() -> None:
    body = "  thread t():\n    movej([2.0, -1.75, 2.25, -2.07, -1.57, 1.57])\n  end\n  run t()\n  sleep(0.8)"
    rollout = execute(f"def test():\n{body}\nend\n", WORLD, ROBOTS, mount="arm", settle=1.0)
    assert rollout.outcome == "finished"
    assert 0.02 < np.abs(np.subtract(rollout.joints[-1], UR5E.home)).max() < 1.0
    assert np.abs(rollout.joints[-1] - rollout.joints[-5]).max() < 1e-4


# Limits and files

TWO_MOVERS = """  thread t():
    movej([3, -1.75, 2.2, -2, -1.5, 1.5])
  end
  run t()
  sync()
  sync()
  movel(get_actual_tcp_pose())"""


@pytest.mark.parametrize(
    ("body", "outcome", "reason"),
    [
        ("  while True:\n  end", "error", "line 2: 20000 statements without"),
        ("  while True:\n    sync()\n  end", "timeout", "line 3: the program still ran after 2 s"),
        ('  textmsg("enough: ", 3)\n  halt', "halted", "enough: 3"),
        ("  movej([1, 2])", "error", "line 2: movej needs a list of 6 numbers"),
        ("  x = get_tcp_force()[7]", "error", "line 2: a list with 6 elements has no index 7"),
        (TWO_MOVERS, "error", "line 8: another thread"),
    ],
)
def test_a_program_that_goes_wrong_ends_with_a_reason(body: str, outcome: str, reason: str) -> None:
    rollout = script(body, time_limit=2.0, limits=Limits(slice=20_000))
    assert rollout.outcome == outcome
    assert rollout.reason.startswith(reason)


def test_a_program_that_goes_on_to_new_lines_may_take_longer_than_one_of_them() -> None:
    rollout = script("\n".join(["  sleep(0.6)"] * 3), time_limit=1.0)
    assert rollout.outcome == "finished" and rollout.times[-1] > 1.5


@pytest.mark.heavy
def test_the_same_seed_gives_the_same_run() -> None:
    steps = (go(down(0.45, -0.2, FINGERTIP + 0.01)), CLOSED, GUARDED)
    runs = [execute(text(*steps), WORLD, ROBOTS, mount="arm", seed=s, settle=0.0, force_noise=0.3) for s in (1, 1, 2)]
    assert np.array_equal(runs[0].joints, runs[1].joints)
    assert runs[0].messages == runs[1].messages
    assert not np.array_equal(runs[0].wrench, runs[2].wrench)


def test_a_world_without_the_robot_is_refused() -> None:
    with pytest.raises(UserError, match="no robot 'arn'; did you mean 'arm'"):
        execute(text(), WORLD, ROBOTS, mount="arn")
    with pytest.raises(UserError, match="line 2: there is no function 'movek'"):
        script("  movek([1])")


def test_joint_positions_are_inside_their_limits_or_not() -> None:
    asked = ("[0, -1, 1, -1.5, -1.5, 0]", "[0, -7, 1, -1.5, -1.5, 0]")
    rollout = script("\n".join(f"  textmsg(is_within_safety_limits({q}))" for q in asked))
    assert [m.text for m in rollout.messages] == ["True", "False"]
