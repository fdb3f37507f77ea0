"""A full jug is carried without no-slip iterations, and stays in the fingers as it does with them."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from helpers.short_programs import CLOSED, down, go, text
from helpers.standard import ROBOTS
from msgspec.structs import replace

from cramlite.model import Pose, RobotMount, Rollout, Wait, World
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.objects.vessels import jug
from cramlite_plugins.simulation.model import friction
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.model.index import site_pose
from cramlite_plugins.simulation.model.no_slip import NoSlip
from cramlite_plugins.simulation.model.sleep import Sleep
from cramlite_plugins.simulator.execute import execute

JUG = jug("jug", Pose((0.55, 0.1, 0.06), (0.0, 0.0, 0.0, 1.0)), grains=8)  # its handle is towards the arm
WORLD = World((table("floor", Pose((0.5, 0, 0)), size=(1.0, 1.0, 0.02)), JUG), (RobotMount("arm", "ur5e"),))
OVER, AT = down(0.47, 0.1, 0.25), down(0.47, 0.1, 0.08)
HELD = 2.5  # before the end, the arm holds still [s]


def lifted() -> Rollout:
    steps = (go(OVER), go(AT), replace(CLOSED, expect="object"), go(OVER), Wait(duration=3.0, origin="hold"))
    return execute(text(*steps), WORLD, ROBOTS, mount="arm", settle=0.0)


def slipped(rollout: Rollout) -> float:
    """How far the jug moved in the hand while this stood still [mm]."""
    first, last = (int(np.searchsorted(rollout.times, rollout.times[-1] - ago)) for ago in (HELD, 0.1))
    hand, thing = rollout.poses["effector"], rollout.poses["jug"]
    return 1e3 * float(np.linalg.norm((thing - hand)[last, :3] - (thing - hand)[first, :3]))


@pytest.mark.heavy
def test_a_full_jug_does_not_creep_through_the_fingers(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    look = NoSlip.look
    monkeypatch.setattr(NoSlip, "look", lambda self, data: (look(self, data), seen.append(self._options.noslip_iterations)))
    firm = lifted()
    assert firm.poses["jug"][-1, 2] > 0.15
    assert {seen[0], seen[-1]} == {5, 0}
    assert slipped(firm) < 0.1
    monkeypatch.setattr(friction, "FIRM", (0.9, 0.95, 0.001, 0.5, 2.0))
    assert slipped(lifted()) > 0.3


def test_grains_that_no_robot_carries_change_nothing() -> None:
    compiled = compile_world(WORLD, ROBOTS)
    data, watch = compiled.data(), NoSlip(compiled, "arm")
    for _ in range(25):
        mujoco.mj_step(compiled.model, data, 4)
        watch.look(data)
    assert data.ncon and compiled.model.opt.noslip_iterations == 5


def test_the_iterations_stay_off_with_an_emptied_jug_once_its_grains_sleep_elsewhere() -> None:
    compiled = compile_world(WORLD, ROBOTS)
    data, watch = compiled.data(), NoSlip(compiled, "arm")
    options, sleep = compiled.model.opt, Sleep(compiled.model, 0.008)
    for k, (_, at) in enumerate(compiled.things["jug"].grains):
        data.qpos[at : at + 3] = (0.3 + 0.03 * k, -0.3, 0.017)
    told = dict[bool, int]()
    for _ in range(100):
        compiled.place(data, "jug", site_pose(data, compiled.robots["arm"].tcp) * Pose((0.0, 0.035, 0.0)))  # between the fingers
        for _ in range(4):
            mujoco.mj_step(compiled.model, data)
        sleep.look(data)
        watch.look(data)
        told[bool(data.tree_asleep[watch._grains[0]] >= 0)] = options.noslip_iterations
    assert told == {False: 5, True: 0}


def test_only_pads_on_what_has_contents_are_firm() -> None:
    empty = World((WORLD.things[0], jug("jug", JUG.pose)), WORLD.robots)
    for world, firm in ((WORLD, True), (empty, False)):
        model = compile_world(world, ROBOTS).model
        pads = [p for p in range(model.npair) if "pad" in model.pair(p).name and "jug" in model.pair(p).name]
        assert pads
        assert all((tuple(model.pair_solimp[p]) == friction.FIRM) is firm for p in pads)
