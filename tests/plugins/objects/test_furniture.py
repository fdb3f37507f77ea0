"""What is mounted on a joint: geometry, physics, recording, and what cannot be used."""

from __future__ import annotations

import math

import mujoco
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Geom, Joint, Pose, RobotMount, Thing, World
from cramlite.plugin import UserError
from cramlite_plugins.objects.controls import latch, lever
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.objects.threads import jar, screw_lid
from cramlite_plugins.robots.arms import robots
from cramlite_plugins.shapes.joints import joint_value, mounts
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.recording.recorder import Recorder

ROBOTS = {r.type: r for r in robots()}
AT = Pose.from_rotvec((0.7, 0.1, 0.4), (0, 0, 2.5))
small = st.floats(-1.0, 1.0)


@given(st.sampled_from(["slide", "hinge"]), st.tuples(small, small, small), st.tuples(small, small, small), small)
def test_a_joint_undoes_what_it_did(kind: str, place: tuple[float, ...], turn: tuple[float, ...], by: float) -> None:
    joint = Joint(kind, Pose.from_rotvec(place, turn), -2.0, 2.0)  # type: ignore[arg-type]
    moved = joint.moved(AT, by)
    assert joint.between(AT, moved) == pytest.approx(by, abs=1e-9)
    assert max(joint.moved(moved, -by).distance(AT)) < 1e-6


@given(st.tuples(small, small, small), st.tuples(small, small, small), st.floats(-30.0, 30.0), st.floats(0.001, 0.01))
def test_a_thread_tells_its_turns(place: tuple[float, ...], turn: tuple[float, ...], by: float, pitch: float) -> None:
    joint = Joint("hinge", Pose.from_rotvec(place, turn), 0.0, 30.0, pitch=pitch)  # type: ignore[arg-type]
    moved = joint.moved(AT, by)
    assert joint.between(AT, moved) == pytest.approx(by, abs=1e-6)
    assert max(joint.moved(moved, -by).distance(AT)) < 1e-6


def test_a_lid_rises_while_it_turns_stays_where_it_is_left_and_ends_on_its_jar() -> None:
    thing = screw_lid("x", AT, "jar", turned=1.2)
    compiled = compile_world(World((jar("jar", AT), thing), (RobotMount("arm", "ur5e", Pose((-1, 0, 0))),)), ROBOTS)
    data, joint, body = compiled.data(), thing.joint, compiled.things["x"]
    assert joint is not None and body.joint is not None and data.qpos[body.joint] == pytest.approx(1.2 * math.tau)
    assert max(compiled.pose(data, "x").distance(thing.pose)) < 1e-6

    def turned(torque: float, steps: int) -> float:
        for _ in range(steps):
            data.qfrc_applied[compiled.model.jnt_dofadr[compiled.model.joint("x").id]] = torque
            mujoco.mj_step(compiled.model, data)
        there = compiled.pose(data, "x")
        value = joint.value + joint.between(thing.pose, there)
        assert value == pytest.approx(data.qpos[body.joint], abs=0.02)
        assert AT.inverse().apply(there.position)[2] == pytest.approx(joint.pitch * value / math.tau, abs=2e-4)
        return value

    start, open_ = turned(0.0, 250), turned(0.25, 1500)
    assert start == pytest.approx(1.2 * math.tau, abs=0.02) and open_ > start + math.tau
    assert turned(-0.25, 6000) == pytest.approx(0.0, abs=0.05)
    assert turned(0.0, 250) == pytest.approx(0.0, abs=0.05)
    there = joint.moved(thing.pose, 2.1 * math.tau)
    compiled.place(data, "x", there)
    mujoco.mj_kinematics(compiled.model, data)
    assert max(compiled.pose(data, "x").distance(there)) < 1e-6


def world(*things: Thing) -> World:
    return World((cabinet("cabinet", AT), *things), (RobotMount("arm", "ur5e", Pose((-1, 0, 0))),))


@pytest.mark.parametrize("thing", [drawer("x", AT, "cabinet", opened=0.05), door("x", AT, "cabinet", opened=0.3)])
def test_pushed_it_moves_on_its_joint_only(thing: Thing) -> None:
    compiled = compile_world(world(thing), ROBOTS)
    data, recorder = compiled.data(), Recorder(compiled)
    joint, body = thing.joint, compiled.things["x"]
    assert joint is not None and body.joint is not None
    assert data.qpos[body.joint] == pytest.approx(joint.value)
    assert max(compiled.pose(data, "x").distance(thing.pose)) < 1e-6
    for _ in range(250):
        data.qfrc_applied[compiled.model.jnt_dofadr[compiled.model.joint("x").id]] = 3.0
        mujoco.mj_step(compiled.model, data)
        recorder.observe(data)
    values = recorder.rollout().values["x"]
    assert values[-1] > values[0] + 0.02
    there = compiled.pose(data, "x")
    assert joint.value + joint.between(thing.pose, there) == pytest.approx(values[-1], abs=0.02)
    assert max(joint.moved(thing.pose, float(data.qpos[body.joint]) - joint.value).distance(there)) < 1e-3


def test_dry_friction_holds_it() -> None:
    thing = drawer("x", AT, "cabinet", joint_friction=60.0)
    compiled = compile_world(world(thing), ROBOTS)
    data = compiled.data()
    for _ in range(250):
        data.qfrc_applied[compiled.model.jnt_dofadr[compiled.model.joint("x").id]] = 30.0
        mujoco.mj_step(compiled.model, data)
    assert data.qpos[compiled.things["x"].joint] < 0.002


@pytest.mark.parametrize(("turned", "opens"), [(0.0, False), (1.5, True)])
def test_a_latch_before_a_door_keeps_it_shut_until_it_is_turned(turned: float, opens: bool) -> None:
    kept = world(door("x", AT, "cabinet"), latch("latch", AT * Pose((0.0, -0.175, 0.07)), turned=turned))
    compiled = compile_world(kept, ROBOTS)
    data = compiled.data()
    for _ in range(250):
        data.qfrc_applied[compiled.model.jnt_dofadr[compiled.model.joint("x").id]] = 1.0
        mujoco.mj_step(compiled.model, data)
    opened = float(data.qpos[compiled.things["x"].joint])
    assert opened > 0.3 if opens else opened < 0.05


LEVER = AT * Pose((0.018, -0.11, -0.07))
KEEPER = Thing("keeper", "cram:Table", AT * Pose((0.047, -0.18, -0.07)), (Geom("box", (0.0125, 0.015, 0.03)),))


@pytest.mark.parametrize(("turned", "opens"), [(0.0, False), (1.3, True)])
def test_a_lever_keeps_its_door_shut_until_it_is_turned_and_moves_along_with_it(turned: float, opens: bool) -> None:
    kept = world(door("x", AT, "cabinet"), KEEPER, lever("lever", LEVER, "x", turned=turned, spring=0.0, joint_friction=0.5))
    compiled = compile_world(kept, ROBOTS)
    data = compiled.data()
    before = compiled.pose(data, "lever")
    for _ in range(250):
        data.qfrc_applied[compiled.model.jnt_dofadr[compiled.model.joint("x").id]] = 1.0
        mujoco.mj_step(compiled.model, data)
    opened = float(data.qpos[compiled.things["x"].joint])
    assert opened > 0.3 if opens else opened < 0.1
    assert (before.distance(compiled.pose(data, "lever"))[0] > 0.05) == opens


def test_a_spring_draws_a_lever_back() -> None:
    compiled = compile_world(world(door("x", AT, "cabinet"), lever("lever", LEVER, "x", turned=1.0)), ROBOTS)
    data = compiled.data()
    for _ in range(1500):
        mujoco.mj_step(compiled.model, data)
    assert abs(data.qpos[compiled.things["lever"].joint]) < 0.15


@pytest.mark.parametrize(("opened", "turned"), [(0.0, 0.7), (0.6, 0.0), (0.6, 0.7)])
def test_the_value_of_a_lever_is_known_where_its_door_has_moved(opened: float, turned: float) -> None:
    shut = world(door("x", AT, "cabinet"), lever("lever", LEVER, "x"))
    compiled = compile_world(shut, ROBOTS)
    data = compiled.data()
    for name, value in (("x", opened), ("lever", turned)):
        data.qpos[compiled.things[name].joint] = value
    mujoco.mj_kinematics(compiled.model, data)
    poses = {name: compiled.pose(data, name) for name in ("x", "lever")}
    there = shut.put(poses)
    assert [t.joint.value for t in there.things if t.joint] == pytest.approx([opened, turned])
    again = compiled.data()
    for name, pose in poses.items():
        compiled.place(again, name, pose)
    mujoco.mj_kinematics(compiled.model, again)
    assert max(compiled.pose(again, "lever").distance(poses["lever"])) < 1e-6
    from_there = compile_world(there, ROBOTS)
    assert max(from_there.pose(from_there.data(), "lever").distance(poses["lever"])) < 1e-6


def test_a_mount_is_what_stands_still_or_goes_with_it() -> None:
    kept, beside = latch("latch", AT * Pose((0.0, -0.16, 0.07)), "jamb"), latch("beside", AT * Pose((0.0, -0.16, -0.07)), "cabinet")
    assert mounts(door("x", AT, "cabinet"), world(door("x", AT, "cabinet"), kept, beside)) == ("cabinet", "beside")


def test_a_planning_model_puts_it_anywhere() -> None:
    thing = drawer("x", AT, "cabinet")
    compiled = compile_world(world(thing), ROBOTS, planning=True)
    data = compiled.data()
    assert thing.joint is not None
    there = thing.joint.moved(thing.pose, 0.1)
    compiled.place(data, "x", there)
    mujoco.mj_kinematics(compiled.model, data)
    assert max(compiled.pose(data, "x").distance(there)) < 1e-6


@pytest.mark.parametrize(
    ("thing", "says"),
    [
        (drawer("x", AT, "cabinett"), "nearest|cabinet"),
        (drawer("x", AT, "cabinet", opened=0.3), "outside 0 .. 0.2"),
        (replace(drawer("x", AT, "cabinet"), mass=None), "no mass"),
        (door("x", AT, "cabinet", opened=math.pi), "outside 0 .. 1.3"),
        (lever("x", AT, "x"), "no fixed thing, nor one on a joint that comes before it"),
    ],
)
def test_what_cannot_be_used(thing: Thing, says: str) -> None:
    with pytest.raises(UserError, match=says):
        compile_world(world(thing), ROBOTS)


def test_the_value_is_known_from_the_pose() -> None:
    from cramlite.model import initial_belief

    thing = door("x", AT, "cabinet", opened=0.2)
    belief = initial_belief(world(thing), "arm", (0.0,) * 6, 0.08)
    assert thing.joint is not None
    assert joint_value(belief, "x", thing.joint.moved(thing.pose, 0.5)) == pytest.approx(0.7)
