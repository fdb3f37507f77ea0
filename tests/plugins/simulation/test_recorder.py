"""A rollout holds what happened: forces with their signs, poses, openings, at the rate asked for."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from helpers.arm import lift
from helpers.standard import ROBOTS, standard_world, standing_world

from cramlite.model import Physics, Pose, Rollout
from cramlite.plugin import UserError
from cramlite_plugins.simulation.model.compile import Compiled, compile_world
from cramlite_plugins.simulation.recording.recorder import Recorder

AHEAD = Pose.from_axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, -1))


@pytest.fixture(scope="module")
def lifted() -> Rollout:
    compiled = compile_world(standing_world(), ROBOTS)
    recorder = Recorder(compiled)
    lift(compiled, compiled.data(), recorder.observe)
    recorder.message(1.0, "grasped", 7)
    return recorder.rollout()


def test_samples_come_at_a_constant_rate(lifted: Rollout) -> None:
    assert np.diff(lifted.times) == pytest.approx(0.02)
    count = len(lifted.times)
    assert lifted.joints.shape == (count, 6)
    assert lifted.wrench.shape == (count, 6)
    assert len(lifted.touches) == count == len(lifted.opening) == len(lifted.lines)
    assert set(lifted.poses) == {"table", "product", "effector", "effector/left", "effector/right"}
    assert all(p.shape == (count, 7) for p in lifted.poses.values())
    assert [m.line for m in lifted.messages] == [7]


def test_the_wrench_is_what_the_robot_applies(lifted: Rollout) -> None:
    """It carries 0.8 kg up: +7.85 N; before the grasp nothing."""
    assert lifted.wrench[-1, :3] == pytest.approx((0, 0, 0.8 * 9.81), abs=0.15)
    assert np.abs(lifted.wrench[1, :3]).max() < 1.0


def test_touches_tell_who_carries(lifted: Rollout) -> None:
    end = {(t.a, t.b): t for t in lifted.touches[-1]}
    assert set(end) == {("effector/left", "product"), ("effector/right", "product")}
    assert sum(t.lift for t in end.values()) == pytest.approx(0.8 * 9.81, abs=0.1)
    assert all(45 < t.force < 55 for t in end.values())
    start = {(t.a, t.b): t for t in lifted.touches[3]}
    (pair,) = start
    assert set(pair) == {"product", "table"}
    up = 1 if pair[0] == "table" else -1
    assert up * start[pair].lift == pytest.approx(0.8 * 9.81, abs=0.2)


def test_the_opening_follows_the_object(lifted: Rollout) -> None:
    assert lifted.opening[0] == pytest.approx(0.085, abs=1e-4)
    assert lifted.opening[-1] == pytest.approx(0.025, abs=5e-4)
    pads = lifted.poses["effector/left"][0, :3] - lifted.poses["effector/right"][0, :3]
    assert np.linalg.norm(pads) == pytest.approx(0.085 + 0.008, abs=1e-4)


def test_an_unknown_effector_is_named() -> None:
    with pytest.raises(KeyError, match="there are: arm"):
        Recorder(compile_world(standard_world(), ROBOTS), "leg")


def pinch(compiled: Compiled) -> tuple[Rollout, Any]:
    """The hand closes on the standing product, lifts it by 10 cm and holds it."""
    hand, data = compiled.hand, compiled.data()
    assert hand is not None
    recorder = Recorder(compiled, "hand")
    place = compiled.pose(data, "product").position

    def go(start: Pose, end: Pose, opening: tuple[float, float], seconds: float) -> None:
        for s in np.linspace(0, 1, int(seconds / 0.002)):
            at = np.multiply(start.position, 1 - s) + np.multiply(end.position, s)
            hand.set_target(data, Pose(tuple(at), start.quaternion), opening[0] * (1 - s) + opening[1] * s)
            mujoco.mj_step(compiled.model, data)
            recorder.observe(data)

    grasp = Pose(place) * AHEAD
    before, above = Pose((-0.1, 0, 0)) * grasp, Pose((0, 0, 0.1)) * grasp
    hand.teleport(compiled.model, data, before)
    go(before, grasp, (0.1, 0.1), 0.6)
    go(grasp, grasp, (0.1, 0.0), 0.5)
    go(grasp, above, (0.0, 0.0), 0.6)
    go(above, above, (0.0, 0.0), 0.6)
    return recorder.rollout(), data


def test_a_hand_holds_by_friction() -> None:
    compiled = compile_world(standing_world_without_robot(Physics()), {}, hand=True)
    rollout, data = pinch(compiled)
    assert compiled.pose(data, "product").position[2] > 0.075 + 0.09
    assert rollout.joints.shape[1] == 0
    assert rollout.wrench[-1, 2] == pytest.approx(0.8 * 9.81, abs=0.15)
    assert {(t.a, t.b) for t in rollout.touches[-1]} == {("effector/left", "product"), ("effector/right", "product")}


def test_a_hand_without_friction_holds_nothing() -> None:
    compiled = compile_world(standing_world_without_robot(Physics(pad_friction=0.0)), {}, hand=True)
    _, data = pinch(compiled)
    assert compiled.pose(data, "product").position[2] < 0.08


def test_a_hand_says_when_it_cannot_turn_that_far() -> None:
    compiled = compile_world(standing_world_without_robot(Physics()), {}, hand=True)
    back = Pose.from_axes((0, 0, 0), z=(-1, 0, 0), x=(0, 0, -1))
    assert compiled.hand is not None
    with pytest.raises(UserError, match="170 degrees"):
        compiled.hand.set_target(compiled.data(), back, 0.05)
    other = compile_world(standing_world_without_robot(Physics()), {}, hand=back)
    assert other.hand is not None
    other.hand.set_target(other.data(), back, 0.05)


def standing_world_without_robot(physics: Physics) -> Any:
    from msgspec.structs import replace

    return replace(standing_world(physics), robots=())
