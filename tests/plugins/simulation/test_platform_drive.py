"""A platform drives by its servos: to where the text says, within its limits, and not through anything."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import (
    Drive,
    Geom,
    MoveJoints,
    Pose,
    Program,
    RobotMount,
    Rollout,
    Step,
    Thing,
    World,
    read_program,
    write_program,
)
from cramlite.plugin import UserError
from cramlite_plugins.backends.typed_json import TypedJson
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.robots.ur5e_mobile import UR5E_MOBILE
from cramlite_plugins.simulation.controller.platform_drive import leg
from cramlite_plugins.simulator.execute import execute

FLOOR = Thing("floor", "cram:Table", Pose((0, 0, -0.01)), (Geom("box", (5, 5, 0.005)),))
POST = Thing("post", "cram:Table", Pose((1.5, 0.2, 0.2)), (Geom("box", (0.05, 0.3, 0.2)),))
START = Pose.from_rotvec((0.1, 0.2, 0.0), (0, 0, 2.8))
RATES = {"speed": 0.5, "acceleration": 0.5, "turn_speed": 0.6, "turn_acceleration": 0.6}
AWAY = Drive(((1.2, 0.9, -2.9), (1.2, 0.2, -2.9)), **RATES, origin="1.Navigating/drive")


def program(*steps: Step, robot: str = "ur5e_mobile") -> Program:
    model = {"ur5e_mobile": UR5E_MOBILE, "ur5e": UR5E}[robot]
    return Program("drive", "arm", robot, model.gripper.tcp, model.home, steps, (), mass=0.925)  # type: ignore[arg-type]


def run(made: Program, *things: Thing) -> Rollout:
    world = World((FLOOR, *things), (RobotMount("arm", made.robot_type, START),))
    robots = {"ur5e_mobile": UR5E_MOBILE, "ur5e": UR5E}
    return execute(write_program(made), world, robots, mount="arm", settle=0.2)


def test_it_gets_there_at_a_speed_that_it_may_have_and_turns_the_shorter_way() -> None:
    rollout = run(program(AWAY))
    track = rollout.poses["arm/base"]
    assert rollout.outcome == "finished", rollout.reason
    end = Pose(tuple(track[-1, :3]), tuple(track[-1, 3:]))
    assert math.dist(end.position[:2], (1.2, 0.2)) < 0.002
    assert abs(math.remainder(2 * math.atan2(end.quaternion[3], end.quaternion[0]) + 2.9, math.tau)) < 0.002
    ten = np.linalg.norm(track[10:, :2] - track[:-10, :2], axis=1) / 0.2  # samples fall on control cycles of 8 ms
    assert ten.max() < 0.55
    turned = np.abs(np.unwrap(2 * np.arctan2(track[:, 6], track[:, 3])) - 2.8)
    assert turned.max() < 0.7, "2.8 to -2.9 rad is 0.58 rad the shorter way"
    assert rollout.sizes["arm/base"] == (0.988, 0.662, 0.386)


def test_what_stands_in_the_way_stops_it() -> None:
    rollout = run(program(Drive(((3.0, 0.2, 2.8),), **RATES)), POST)
    assert rollout.outcome == "protective stop"
    assert "something is in its way" in rollout.reason
    assert rollout.poses["arm/base"][-1, 0] < 1.2
    assert any("post" in t.a + t.b for touches in rollout.touches for t in touches)


def test_the_arm_moves_relative_to_where_it_was_driven() -> None:
    home = UR5E_MOBILE.home
    rollout = run(program(AWAY, MoveJoints(((home[0] + 1.0, *home[1:]),), 1.0, 1.0), AWAY))
    assert rollout.outcome == "finished", rollout.reason
    assert np.abs(rollout.joints[-1] - [home[0] + 1.0, *home[1:]]).max() < 0.002
    assert np.linalg.norm(rollout.wrench[:, :3], axis=1).max() < 10.0, "only inertia, whichever way it looks"


def test_an_arm_that_is_bolted_down_refuses_the_text() -> None:
    with pytest.raises(UserError, match="line 9: a 'ur5e' stands still; it cannot drive"):
        run(program(AWAY, robot="ur5e"))


def test_the_text_is_read_back_equal_and_leads_to_the_task() -> None:
    code = TypedJson().emit(program(AWAY), UR5E_MOBILE)
    assert read_program(code.text).program.steps == (AWAY,)
    assert "1.Navigating/drive" in code.origins.values()


def test_urscript_refuses_to_drive() -> None:
    said = r"'1\.Navigating/drive': it drives a platform, and URScript moves an arm only; write the program as typed_json"
    with pytest.raises(UserError, match=said):
        emit(program(AWAY), UR5E_MOBILE)


@pytest.mark.parametrize("rate", ["speed", "turn_speed", "turn_acceleration"])
def test_rates_are_positive(rate: str) -> None:
    with pytest.raises(UserError, match=f"{rate} 0 is not positive"):
        run(program(Drive(((1.0, 0.0, 0.0),), **{**RATES, rate: 0.0})))


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3))
def test_a_leg_keeps_to_its_rates(x: float, y: float, turn: float) -> None:
    found = leg(np.zeros(3), np.array([x, y, turn]), (0.5, 0.5), (0.6, 0.6))
    times = np.linspace(0, max(found.duration, 1e-3), 400)
    places = np.array([found.at(t) for t in times])
    step = times[1]
    assert np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1).max() / step < 0.5 + 1e-6
    assert np.abs(np.diff(places[:, 2])).max() / step < 0.6 + 1e-6
    assert np.allclose(places[-1], [x, y, turn], atol=1e-9)
