"""What rests sleeps and costs nothing; what moves, creeps or is touched does not, and nobody who judges a run sees a difference."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from helpers.short_programs import CLOSED, down, go, text
from helpers.standard import ROBOTS
from msgspec.structs import replace

from cramlite.model import Filling, Pose, RobotMount, Rollout, Thing, World
from cramlite_plugins.episodes.detection.touches import touching_pairs
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.objects.vessels import bottle, bowl, jug, mug
from cramlite_plugins.simulation.model import sleep
from cramlite_plugins.simulation.model.compile import Compiled, compile_world
from cramlite_plugins.simulation.model.index import Data
from cramlite_plugins.simulation.model.sleep import Sleep, awake_copy
from cramlite_plugins.simulator.execute import execute
from cramlite_plugins.validators import grips

CYCLE = 0.008  # of a control cycle, four steps [s]
FLOOR = table("floor", Pose((0, 0, 0)), size=(5.0, 5.0, 0.02))
TOP = 0.01  # of the floor [m]


def vessel(number: int) -> Thing:
    """One of four kinds of vessels, on a circle beyond the arm's reach."""
    kind, half = ((jug, 0.05), (bowl, 0.025), (mug, 0.0475), (bottle, 0.075))[number % 4]
    return kind(f"v{number}", Pose((2 * np.cos(0.4 * number), 2 * np.sin(0.4 * number), TOP + half)))


def kitchen(idle: int, *things: Thing) -> World:
    return World((FLOOR, *things, *map(vessel, range(idle))), (RobotMount("arm", "ur5e"),))


def simulated(world: World, seconds: float, sleeps: bool = True) -> tuple[Compiled, Data]:
    """A world that was let run, the arm holding, without a controller."""
    compiled = compile_world(world, ROBOTS)
    data, watch = compiled.data(), Sleep(compiled.model, CYCLE) if sleeps else None
    for _ in range(round(seconds / CYCLE)):
        mujoco.mj_step(compiled.model, data, 4)
        if watch is not None:
            watch.look(data)
    return compiled, data


def slept(compiled: Compiled, data: Data, thing: str) -> bool:
    return bool(data.tree_asleep[compiled.model.body_treeid[compiled.things[thing].body]] >= 0)


def ran(world: World, *, z: float = 0.4) -> Rollout:
    return execute(text(go(down(0.5, 0.1, z)), CLOSED), world, ROBOTS, mount="arm", settle=0.5)


# What sleeps


def test_idle_things_add_neither_contacts_nor_degrees_of_freedom_to_a_step() -> None:
    (_, bare), (compiled, crowded) = (simulated(kitchen(count), 1.5) for count in (0, 8))
    assert compiled.model.nv > bare.nv_awake + 40
    assert (crowded.nv_awake, crowded.ncon) == (bare.nv_awake, bare.ncon)


def test_a_bottle_that_shakes_in_place_sleeps_too() -> None:
    """Its speed is above what MuJoCo would take for rest; its way is not."""
    compiled, data = simulated(kitchen(4), 0.4, sleeps=False)
    dof = compiled.things["v3"].dof
    assert dof is not None
    fastest = 0.0
    for _ in range(100):
        mujoco.mj_step(compiled.model, data)
        fastest = max(fastest, float(np.abs(data.qvel[dof : dof + 3]).max()))
    assert fastest > sleep.CREEPS
    assert slept(*simulated(kitchen(4), 1.5), "v3")


def test_what_creeps_stays_awake_however_slow_it_is() -> None:
    """Slower than what shakes in place, but it gets somewhere."""
    compiled = compile_world(kitchen(0, replace(block("box", Pose((2, 0, TOP + 0.02)), size=(0.04,) * 3), friction=0.0)), ROBOTS)
    compiled.model.opt.gravity[:2] = 0.0
    data, watch = compiled.data(), Sleep(compiled.model, CYCLE)
    dof = compiled.things["box"].dof
    assert dof is not None
    for _ in range(round(1.0 / CYCLE)):
        data.qvel[dof] = 0.3 * sleep.SHAKES
        mujoco.mj_step(compiled.model, data, 4)
        watch.look(data)
        assert not slept(compiled, data, "box")
    assert compiled.pose(data, "box").position[0] - 2 > 0.0002


@pytest.mark.parametrize(("share", "sleeps"), [(0.8, True), (1.2, False)])
def test_a_grain_that_hardly_moves_sleeps_and_a_faster_one_does_not(share: float, sleeps: bool) -> None:
    tray = replace(table("tray", Pose((2, 0, TOP + 0.02)), size=(0.2, 0.2, 0.04)), filling=Filling(1, 0.006, 0.001))
    compiled = compile_world(kitchen(0, tray), ROBOTS)
    ((body, at),) = compiled.things["tray"].grains
    data, watch, tree = compiled.data(), Sleep(compiled.model, CYCLE), compiled.model.body_treeid[body]
    compiled.model.opt.gravity[:] = 0.0
    data.qpos[at + 2] += 0.1  # it floats on at that speed
    data.qvel[compiled.model.body_dofadr[body]] = share * sleep.ROLLS
    for _ in range(100):
        mujoco.mj_step(compiled.model, data, 4)
        watch.look(data)
    assert bool(data.tree_asleep[tree] >= 0) is sleeps


def test_what_swings_or_falls_never_sleeps() -> None:
    high = block("high", Pose((2, 0, 4.0)), size=(0.04,) * 3)
    compiled, data = simulated(kitchen(0, high), 0.8)
    assert not slept(compiled, data, "high")
    assert compiled.pose(data, "high").position[2] == pytest.approx(4.0 - 9.81 * 0.8**2 / 2, abs=0.02)


def test_what_is_fallen_onto_wakes_and_moves_as_if_it_had_never_slept() -> None:
    things = block("low", Pose((2, 0, TOP + 0.05)), size=(0.1,) * 3), block("high", Pose((2.04, 0, 1.5)), size=(0.1,) * 3)
    world = kitchen(0, *things)
    ends = []
    for sleeps in (True, False):
        compiled, data = simulated(world, 0.45, sleeps=sleeps)
        assert slept(compiled, data, "low") == sleeps
        compiled, data = simulated(world, 2.0, sleeps=sleeps)
        ends.append([compiled.pose(data, t.name) for t in things])
    assert all(with_.distance(without)[0] < 1e-4 for with_, without in zip(*ends, strict=True))
    assert ends[0][1].distance(things[1].pose)[0] > 1.0


def test_a_model_whose_tendons_are_tied_to_each_other_runs_and_nothing_sleeps() -> None:
    """MuJoCo 4.0 ends with an error where such a model may sleep."""
    slides = "".join(f"<body pos='0 {k} 1'><joint name='j{k}' type='slide'/><geom size='.1'/></body>" for k in (0, 1))
    fixed = "".join(f"<fixed name='t{k}'><joint joint='j{k}' coef='1'/></fixed>" for k in (0, 1))
    tied = "<equality><tendon tendon1='t0' tendon2='t1'/></equality>"
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{slides}</worldbody><tendon>{fixed}</tendon>{tied}</mujoco>")
    data, watch = mujoco.MjData(model), Sleep(model, CYCLE)
    mujoco.mj_step(model, data, 4)
    watch.look(data)
    assert not model.opt.enableflags


# What is recorded


def test_what_sleeps_touches_what_it_stands_on_with_its_weight() -> None:
    rollout = ran(kitchen(4))
    for touches in (rollout.touches[0], rollout.touches[-1]):
        forces = {t.b: t.force for t in touches if t.a == "floor"}
        assert set(forces) == {"v0", "v1", "v2", "v3"}
        assert all(forces[t.name] == pytest.approx((t.mass or 0) * 9.81, rel=0.02) for t in map(vessel, range(4)))


def test_a_stack_that_sleeps_touches_in_itself() -> None:
    low, top = (block(name, Pose((2, 0, TOP + h)), size=(0.1,) * 3, mass=0.2) for name, h in (("low", 0.05), ("top", 0.15)))
    forces = {(t.a, t.b): t.force for t in ran(kitchen(0, low, top)).touches[-1]}
    assert forces == {("floor", "low"): pytest.approx(3.924, rel=0.02), ("low", "top"): pytest.approx(1.962, rel=0.02)}


def test_the_contacts_of_what_sleeps_are_asked_of_a_copy_that_leaves_the_state_asleep() -> None:
    compiled, data = simulated(kitchen(1), 1.5)
    copy = awake_copy(compiled.model, data)
    assert copy.ncon > 0 == data.ncon and slept(compiled, data, "v0")
    mujoco.mj_step(compiled.model, data)
    assert slept(compiled, data, "v0")


def test_a_run_says_what_its_contacts_were_computed_for() -> None:
    near = block("near", Pose((0.5, 0.1, TOP + 0.03)), size=(0.06,) * 3)
    rollout = ran(kitchen(2, near), z=0.06)
    assert {n for n, points in rollout.work.items() if not points} == {"v0", "v1"}
    assert rollout.work["near"] > 0 and rollout.work["arm"] > 0


# What nothing brings together


@pytest.mark.parametrize(
    ("other", "stated"),
    [((2.0, 0.0, 0.12), True), ((2.0, 0.6, 0.04), False), ((0.5, 0.3, 0.04), True)],
    ids=["nearby", "far from each other and from the arm", "within the arm's reach"],
)
def test_friction_is_stated_of_what_may_meet(other: tuple[float, float, float], stated: bool) -> None:
    there = replace(block("there", Pose((2.0, 0.0, 0.04)), size=(0.06,) * 3), friction=0.3)
    model = compile_world(kitchen(0, there, block("other", Pose(other), size=(0.06,) * 3)), ROBOTS).model
    pairs = [{model.geom(int(model.pair_geom1[k])).name, model.geom(int(model.pair_geom2[k])).name} for k in range(model.npair)]
    assert ({"there/body/0", "other/body/0"} in pairs) == stated


def test_fingers_have_no_pairs_with_what_no_arm_reaches() -> None:
    near, far = block("near", Pose((0.5, 0.1, 0.04)), size=(0.06,) * 3), block("far", Pose((2.0, 0.0, 0.04)), size=(0.06,) * 3)
    model = compile_world(kitchen(0, near, far), ROBOTS).model
    padded = [model.geom(int(model.pair_geom2[k])).name for k in range(model.npair) if "pad" in model.geom(int(model.pair_geom1[k])).name]
    assert {name for name in padded if name != "floor/body/0"} == {"near/body/0"}


def test_touches_of_what_sleeps_are_told_apart_and_change_nothing_that_is_found() -> None:
    run = ran(kitchen(4, block("cube", Pose((0.5, 0.1, TOP + 0.025)))), z=0.05)  # the gripper comes down on the cube
    asleep, awake = ([{t.a for t in touches} for touches in those] for those in (run.asleep, run.awake_touches))
    assert all(len(a) + len(b) == len(c) for a, b, c in zip(run.asleep, run.awake_touches, run.touches, strict=True))
    assert {"v0", "v3"} <= {t for s in asleep[-1:] for t in s} | {t.b for t in run.asleep[-1]}
    assert any("effector" in name for names in awake for name in names)
    assert not any("effector" in name for names in asleep for name in names)
    told = replace(run, asleep=())  # as a file has it, where nobody knows what slept
    assert told.awake_touches == told.touches
    told_apart, whole = touching_pairs(run, set()), touching_pairs(told, set())
    assert list(told_apart) == list(whole)
    for pair, found in whole.items():
        assert np.allclose(told_apart[pair].force, found.force) and np.allclose(told_apart[pair].lift, found.lift)
    assert grips.held_at(run) == grips.held_at(told)
