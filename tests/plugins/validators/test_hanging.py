"""What hangs on a peg may swing, but not creep along it, nor swing hard enough to come off: judged on real physics."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Pose, Rollout, World
from cramlite_plugins.objects.products_and_fixtures import hanger, hung, product
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.recording.recorder import Recorder
from cramlite_plugins.validators.postconditions import _not_hanging, _unsettled

BACK = Pose((0, 0, 0), (math.cos(math.pi / 2), 0, 0, math.sin(math.pi / 2)))


def hung_world(friction: float = 0.3) -> World:
    hook = hanger("hook", Pose((0.87, 0, 0.45)) * BACK, friction=friction)
    box = product("box", Pose(), size=(0.06, 0.05, 0.10), hole_diameter=0.009)
    return World((hook, replace(box, pose=hung(box, hook, depth=0.07), friction=friction)), ())


def pushed(speed: float, world: World | None = None, *, along: float = 0.0, seconds: float = 3.0) -> Rollout:
    """A box on a peg, given a speed across the peg [m/s] and one along it, to its tip, and watched."""
    compiled = compile_world(world or hung_world(), {}, hand=True)
    data, recorder = compiled.data(), Recorder(compiled, "hand")
    for _ in range(500):
        mujoco.mj_step(compiled.model, data)
    dof = compiled.things["box"].dof
    assert dof is not None
    below = compiled.world.thing("box").feature("vrps:Hole").pose.position[2]  # type: ignore[union-attr]
    data.qvel[dof : dof + 2] += (-along, speed)
    data.qvel[dof + 3] += speed / below  # about the peg, so that the hole stays where it is
    data.time = 0.0
    while data.time < seconds:
        mujoco.mj_step(compiled.model, data)
        recorder.observe(data)
    return recorder.rollout()


def said(rollout: Rollout) -> str:
    return _not_hanging(rollout, "box", rollout.world.thing("hook")) or _unsettled(rollout, "box", hanging=True)


@pytest.mark.parametrize("speed", [0.0, 0.03])
def test_a_thing_that_hangs_still_or_swings_a_little_is_there(speed: float) -> None:
    assert said(pushed(speed)) == ""


def test_a_little_swinging_lasts_and_takes_nothing_off() -> None:
    rollout = pushed(0.05, seconds=10.0)
    late = rollout.poses["box"][rollout.times > 9.0]
    assert np.ptp(late[:, 1]) > 0.001  # it still does
    assert said(rollout) == ""


def test_one_that_swings_hard_is_not() -> None:
    assert "'box' still swings" in said(pushed(0.4, seconds=1.0))


def test_one_that_creeps_along_the_peg_is_not() -> None:
    rollout = pushed(0.0, hung_world(friction=0.01), along=0.08, seconds=0.6)
    assert "the hole of 'box' still moves" in said(rollout)
    assert said(pushed(0.0, hung_world(), along=0.08, seconds=2.0)) == ""  # friction has stopped it


def test_what_does_not_hang_must_not_swing_at_all() -> None:
    rollout = pushed(0.15)
    assert said(rollout) == "" and "'box' still moves" in _unsettled(rollout, "box", hanging=False)
