"""The virtual UR controller: emitted text moves the arm, feels contact, grips, and stops with a reason."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from standard import ROBOTS, standing_world

from cramlite.errors import UserError
from cramlite.geometry import Pose
from cramlite.program import (
    AnyStep,
    ForceMove,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Program,
    SetGripper,
    SetPayload,
    Wait,
    ZeroSensor,
)
from cramlite.rollout import Rollout
from cramlite.world import World
from cramlite_plugins.backends.urscript import emit
from cramlite_plugins.motions.kinematics import forward, inverse
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.execute import execute, execute_file
from cramlite_plugins.simulation.protective_stop import Safety
from cramlite_plugins.simulation.ur_process import process_motion
from cramlite_plugins.simulation.urscript import Limits

WORLD = standing_world().moved({"product": Pose((0.55, 0.1, 0.075))})
FINGERTIP = 0.01875  # from the pinch point to the fingertips [m]


def down(x: float, y: float, z: float) -> Pose:
    """The TCP over the table, looking down; fingers close along y."""
    return Pose.from_axes((x, y, z), (0, 0, -1), (1, 0, 0))


@cache
def near_home(target: Pose) -> tuple[float, ...]:
    """Joints for a pose with the elbow up, on the side of the home posture."""
    home = UR5E.home
    return next(q for q in inverse(UR5E, target, seed=home) if abs(q[0] - home[0]) < 1.3 and q[2] > 0)


def go(target: Pose) -> MoveJoints:
    return MoveJoints(path=(near_home(target),), speed=1.5, acceleration=3.0)


def text(*steps: AnyStep, **changes: object) -> str:
    program = Program(
        name="test", robot="arm", robot_type="ur5e", tcp=UR5E.gripper.tcp, start=UR5E.home, steps=steps, sections=(),
        mass=UR5E.gripper.mass, center=(0.0, 0.0, 0.06),
    )  # fmt: skip
    return emit(replace(program, **changes), UR5E).text  # type: ignore[arg-type]


def run(*steps: AnyStep, world: World = WORLD, settle: float = 0.3) -> Rollout:
    return execute(text(*steps), world, ROBOTS, mount="arm", settle=settle)


def script(body: str, **options: object) -> Rollout:
    return execute(f"def test():\n{body}\nend\n", WORLD, ROBOTS, mount="arm", settle=0.0, **options)  # type: ignore[arg-type]


def peak(rollout: Rollout) -> float:
    return float(np.linalg.norm(rollout.wrench[:, :3], axis=1).max())


CLOSED = SetGripper(opening=0.0, speed=0.15, force=50, expect="none", origin="close")
GUARDED = MoveUntilContact(direction=(0, 0, -1), speed=0.02, force=3, distance=0.05, timeout=10, origin="touch")


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


def test_a_blend_into_nothing_and_one_that_is_too_large_are_errors() -> None:
    home = "[" + ", ".join(f"{v:.6f}" for v in UR5E.home) + "]"
    near = "[" + ", ".join(f"{v:.6f}" for v in np.add(UR5E.home, (0.3, 0, 0, 0, 0, 0))) + "]"
    alone = script(f"  movej({near}, r=0.05)\n  sleep(1.0)\n  movej({home})")
    assert (alone.outcome, "followed by another movej" in alone.reason) == ("error", True)
    last = script(f"  movej({near}, r=0.05)")
    assert (last.outcome, "followed by another movej" in last.reason) == ("error", True)
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
        ("movel(p[2, 0, 0.3, 3.14159, 0, 0], v=0.05)", "no inverse kinematics|rad/s"),
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


# Contact


@pytest.mark.parametrize(("speed", "most"), [(0.02, 18.0), (0.01, 9.0), (0.005, 6.0)])
def test_a_guarded_motion_stops_on_a_plate(speed: float, most: float) -> None:
    height = FINGERTIP + 0.015
    rollout = run(go(down(0.45, -0.2, height)), CLOSED, replace(GUARDED, speed=speed))
    assert rollout.outcome == "finished"
    assert any("touch: contact" in m.text for m in rollout.messages)
    assert 3.0 < peak(rollout) < most  # docs/explanation/simulation.md: 12 to 18, 9 and 6 N
    assert rollout.poses["effector"][-1, 2] == pytest.approx(FINGERTIP, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "outcome", "reason"),
    [
        ({}, "halted", "touch: no contact within 0.05 m"),
        ({"timeout": 1.0}, "halted", "touch: no contact within 1 s"),
        ({"expect": "any"}, "finished", ""),
    ],
)
def test_a_guarded_motion_without_a_plate(change: dict[str, object], outcome: str, reason: str) -> None:
    rollout = run(go(down(0.45, -0.2, 0.2)), replace(GUARDED, **change))  # type: ignore[arg-type]
    assert (rollout.outcome, rollout.reason) == (outcome, reason)


def test_driving_into_the_table_is_stopped_by_the_programs_own_limit() -> None:
    rollout = run(go(down(0.45, -0.2, 0.1)), MoveLinear(target=down(0.45, -0.2, -0.1), speed=0.1, acceleration=1.0))
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith("force ")
    assert rollout.reason.endswith("N > 60 N")


def test_and_without_one_by_the_controller() -> None:
    x = near_home(down(0.45, -0.2, 0.05))
    body = f"  movej({list(x)})\n  movel(p[0.45, -0.2, -0.1, 3.14159265, 0, 0], v=0.1)"
    rollout = script(body, safety=Safety(force=80))
    assert rollout.outcome == "protective stop"
    assert "N > 80 N" in rollout.reason


PRESS = ForceMove(
    waypoints=(down(0.45, -0.18, FINGERTIP + 0.003), down(0.45, -0.22, FINGERTIP + 0.003)), frame=Pose(),
    compliant=(False, False, True, False, False, False), wrench=(0, 0, -8, 0, 0, 0),
    limits=(0.01, 0.01, 0.02, 0.1, 0.1, 0.1),
    speed=0.02, force_limit=30, timeout=20, origin="press",
)  # fmt: skip


def test_force_mode_presses_with_the_force_that_was_asked_for() -> None:
    rollout = run(go(down(0.45, -0.2, FINGERTIP + 0.003)), CLOSED, ZeroSensor(), PRESS, settle=0.0)
    assert rollout.outcome == "finished"
    pressing = rollout.wrench[-70:-10, 2]
    assert np.median(pressing) == pytest.approx(-8.0, abs=2.5)
    away = rollout.poses["effector"][-70:-10, :3]
    assert np.ptp(away[:, 1]) > 0.01  # the motion in y went on
    assert np.abs(away[:, 2] - FINGERTIP).max() < 1e-3


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"force_limit": 5.0}, "press: force "),
        ({"timeout": 0.5}, "press: not done within 0.5 s"),
    ],
)
def test_force_mode_is_watched(change: dict[str, float], reason: str) -> None:
    steps = (go(down(0.45, -0.2, FINGERTIP + 0.003)), CLOSED, ZeroSensor(), replace(PRESS, **change))  # type: ignore[arg-type]
    rollout = run(*steps, settle=0.0)
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith(reason)


# Gripper


def pick(close: float, expect: str) -> tuple[AnyStep, ...]:
    grip = SetGripper(opening=close, speed=0.1, force=50, expect=expect, origin="grip")  # type: ignore[arg-type]
    payload = SetPayload(mass=UR5E.gripper.mass + 0.8, center=(0.0, 0.0, 0.12))
    return (
        go(down(0.55, 0.1, 0.22)), MoveLinear(target=down(0.55, 0.1, 0.13), speed=0.2, acceleration=1.0), grip, payload,
        MoveLinear(target=down(0.55, 0.1, 0.22), speed=0.2, acceleration=1.0), Wait(duration=0.3),
    )  # fmt: skip


def test_a_grasp_lifts_the_product() -> None:
    rollout = run(*pick(0.0, "object"))
    assert rollout.outcome == "finished"
    assert rollout.opening[-1] == pytest.approx(0.025, abs=1e-3)
    assert rollout.poses["product"][-1, 2] - rollout.poses["product"][0, 2] == pytest.approx(0.09, abs=0.01)
    assert rollout.wrench[-1, 2] == pytest.approx(0.8 * 9.81, abs=0.3)  # it carries the product: upwards


def test_an_empty_hand_is_noticed() -> None:
    empty = WORLD.moved({"product": Pose((0.2, -0.5, 0.075))})
    rollout = run(*pick(0.0, "object"), world=empty)
    assert (rollout.outcome, rollout.reason) == ("halted", "grip: no object between the fingers")
    assert run(*pick(0.06, "object")).reason == "grip: no object between the fingers"
    assert run(*pick(0.0, "none")).reason == "grip: an object stopped the fingers"


def test_sockets_lead_to_the_gripper_only() -> None:
    good = script('  socket_open("127.0.0.1", 63352, "g")\n  textmsg(socket_get_var("STA", "g"))')
    assert [m.text for m in good.messages] == ["3"]
    bad = script('  socket_open("192.168.1.5", 30002)')
    assert bad.outcome == "error"
    assert "192.168.1.5:30002 refused" in bad.reason


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
        ("  x = get_tcp_force()[7]", "error", "line 2: index 7"),
        (TWO_MOVERS, "error", "line 8: another thread"),
    ],
)
def test_a_program_that_goes_wrong_ends_with_a_reason(body: str, outcome: str, reason: str) -> None:
    rollout = script(body, time_limit=2.0, limits=Limits(slice=20_000))
    assert rollout.outcome == outcome
    assert rollout.reason.startswith(reason)


def test_the_same_seed_gives_the_same_run() -> None:
    steps = (go(down(0.45, -0.2, FINGERTIP + 0.01)), CLOSED, GUARDED)
    runs = [execute(text(*steps), WORLD, ROBOTS, mount="arm", seed=s, settle=0.0, force_noise=0.3) for s in (1, 1, 2)]
    assert np.array_equal(runs[0].joints, runs[1].joints)
    assert runs[0].messages == runs[1].messages
    assert not np.array_equal(runs[0].wrench, runs[2].wrench)


def test_a_process_that_is_given_two_files(tmp_path: Path) -> None:
    program, world = tmp_path / "program.script", tmp_path / "world.json"
    program.write_text(text(Wait(duration=0.1)))
    world.write_bytes(msgspec.json.encode(WORLD))
    rollout = execute_file(program, world, settle=0.0)
    assert rollout.outcome == "finished"
    assert rollout.world == WORLD
    assert math.isclose(rollout.times[1], 0.02)
    world.write_text(json.dumps({"things": 3}))
    with pytest.raises(UserError, match="not a world"):
        execute_file(program, world)


def test_a_world_without_the_robot_is_refused() -> None:
    with pytest.raises(UserError, match="no robot 'arn'; did you mean 'arm'"):
        execute(text(), WORLD, ROBOTS, mount="arn")
    with pytest.raises(UserError, match="line 2: there is no function 'movek'"):
        script("  movek([1])")


def movep(*places: tuple[float, float, float], r: float, v: float = 0.1, last: str = "") -> str:
    """A movel to the first place and movep along the others, looking down, all but the last with a blend radius."""
    there = [", ".join(f"{x:.6f}" for x in (*p, *down(*p).rotvec)) for p in places]
    lines = [f"  movej(get_inverse_kin(p[{there[0]}]))"]
    lines += [f"  movep(p[{p}], a=0.5, v={v}, r={r})" for p in there[1:-1]]
    return "\n".join([*lines, last or f"  movep(p[{there[-1]}], a=0.5, v={v})"])


SQUARE = ((0.45, -0.1, 0.3), (0.6, -0.1, 0.3), (0.6, 0.1, 0.3), (0.45, 0.1, 0.3))


def test_movep_goes_around_corners_on_circles_at_one_speed() -> None:
    rollout = script(movep(*SQUARE, r=0.05))
    assert rollout.outcome == "finished", rollout.reason
    places = rollout.poses["effector"][:, :3]
    speeds = np.linalg.norm(places[2:] - places[:-2], axis=1) / (rollout.times[2:] - rollout.times[:-2])  # 5 control cycles
    begin = int(np.linalg.norm(places - SQUARE[0], axis=1).argmin())
    cruise = speeds[begin:][speeds[begin:] > 0.02]
    assert np.median(cruise) == pytest.approx(0.1, abs=0.003)
    assert cruise[20:-20].min() > 0.09, "it does not slow down in the corners"
    corner = np.linalg.norm(places[begin:] - SQUARE[1], axis=1).min()
    assert corner == pytest.approx(0.05 * (math.sqrt(2) - 1), abs=0.003), "the circle that touches both lines 50 mm away"
    centre = np.array((0.55, -0.05, 0.3))
    round_ = [p for p in places[begin:] if p[0] > 0.551 and p[1] < -0.051]
    assert len(round_) > 10
    assert np.linalg.norm(np.array(round_) - centre, axis=1) == pytest.approx(0.05, abs=0.003)
    assert np.linalg.norm(places[-1] - SQUARE[-1]) < 4e-3  # it sags


def test_movep_without_a_radius_stops_at_the_corner() -> None:
    rollout = script(movep(*SQUARE[:3], r=0.0))
    places = rollout.poses["effector"][:, :3]
    assert rollout.outcome == "finished" and np.linalg.norm(places - SQUARE[1], axis=1).min() < 4e-3


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (movep(*SQUARE, r=0.09), "takes more than half of a motion of 0.150 m"),
        (movep(*SQUARE[:3], r=0.05, last="  sleep(0.1)"), "movep with a blend radius must be followed by another movep"),
        (movep(*SQUARE[:3], r=0.05, last="  movej([0, -1, 1, -1.5, -1.5, 0])"), "movep with a blend radius must be followed"),
        (movep(*SQUARE[:2], SQUARE[0], r=0.05), "turns straight back"),
        (movep(SQUARE[0], SQUARE[0], r=0.0), "turn on the spot with movel"),
        (movep(*SQUARE[:3], r=0.05, last="  movep(p[0.6, 0.1, 0.3, 0, 3.14, 0], a=0.5, v=0.2)"), "the same v and a"),
        (movep(*SQUARE[:3], r=-0.05), "radius of 0 or more"),
    ],
)
def test_a_movep_that_cannot_be_blended_says_why(body: str, said: str) -> None:
    rollout = script(body)
    assert rollout.outcome == "error" and said in rollout.reason, rollout.reason


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(-0.5, 0.5)] * 3), min_size=3, max_size=5, unique=True),
    st.floats(0.02, 0.98), st.tuples(*[st.floats(-1, 1)] * 3),
)  # fmt: skip
def test_the_way_of_a_movep_has_no_jumps(places: list[tuple[float, float, float]], part: float, turn: tuple[float, float, float]) -> None:
    """Neighbouring places are as far apart as the speed says, the turn goes on steadily, and both ends are met."""
    poses = [Pose.from_rotvec(p, [k * t / 2 for t in turn]) for k, p in enumerate(places)]
    lengths = [math.dist(a, b) for a, b in pairwise(places)]
    assume(min(lengths) > 0.05)
    try:
        motion = process_motion(poses, [part * min(lengths) / 2] * (len(places) - 2), 0.25, 1.0)
    except ValueError as error:
        assume("straight back" not in str(error))
        raise
    times = np.linspace(0, motion.duration, 150)
    found = [motion.at(float(t)) for t in times]
    assert math.dist(found[0].position, places[0]) < 1e-9 and math.dist(found[-1].position, places[-1]) < 1e-9
    assert found[-1].distance(poses[-1])[1] < 1e-6
    step = float(times[1])
    corners = [math.acos(max(-1.0, min(1.0, float(a @ b)))) for a, b in pairwise(np.diff(places, axis=0) / np.reshape(lengths, (-1, 1)))]
    shorter = max(2 * math.tan(c / 2) / c if c > 1e-3 else 1.0 for c in corners)  # two halves of a line against the arc
    fastest = math.hypot(*turn) / 2 * shorter
    for a, b in pairwise(found):
        way, angle = a.distance(b)
        assert way <= 0.25 * step + 1e-9
        assert angle <= 1.01 * fastest * 0.25 * step / min(lengths) + 1e-6
