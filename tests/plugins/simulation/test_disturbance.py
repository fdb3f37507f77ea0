"""What a twin's world file adds, the controller feels: noise, drift and links that are not where they should be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Pose, RobotMount, Rollout, World
from cramlite.model.run.rollout import load_rollout, save_rollout
from cramlite.model.world.world import Disturbance
from cramlite.plugin import UserError
from cramlite_plugins.objects import products_and_fixtures as models
from cramlite_plugins.robots.ur5 import UR5
from cramlite_plugins.simulator.execute import execute

WORLD = World((models.table("floor", Pose((0, 0, -0.005))),), (RobotMount("arm", "ur5"),))
STILL = "def stand():\n  sleep(1.0)\nend\nstand()\n"


def ran(**disturbance: object) -> Rollout:
    return execute(STILL, replace(WORLD, disturbance=Disturbance(**disturbance)), {"ur5": UR5}, mount="arm", seed=1)  # type: ignore[arg-type]


CALM = ran()


def test_drift_shows_in_the_sensor_and_grows() -> None:
    off = (ran(force_drift=(0.0, 0.0, 0.5)).wrench - CALM.wrench)[:, :3]
    size = np.linalg.norm(off, axis=1)
    assert size[-1] == pytest.approx(0.5 * CALM.times[-1], abs=0.3) and size[-1] > size[len(size) // 2] > size[1]


def test_noise_is_as_large_as_was_said_and_belongs_to_the_seed() -> None:
    noisy = ran(force_noise=1.0)
    spread = (noisy.wrench - CALM.wrench)[:, :3]
    assert 0.05 < spread.std() < 1.0  # the sensor's filter leaves some of it
    assert np.array_equal(ran(force_noise=1.0).wrench, noisy.wrench)
    assert np.abs(ran().wrench - CALM.wrench).max() == 0


def test_displaced_links_move_the_tool_but_not_what_the_encoders_say() -> None:
    off = ran(links=((0.0, 0.0, 0.0),) * 5 + ((0.0, 0.001, 0.0),))
    moved = np.linalg.norm(off.poses["effector"][0, :3] - CALM.poses["effector"][0, :3])
    assert moved == pytest.approx(0.001, abs=1e-4)
    assert np.allclose(off.joints[0], CALM.joints[0], atol=1e-3)


def test_a_rollout_survives_its_file(tmp_path: Path) -> None:
    save_rollout(CALM, tmp_path / "rollout.npz")
    read = load_rollout(tmp_path / "rollout.npz", CALM.world)
    assert read.touches == CALM.touches and read.messages == CALM.messages and read.outcome == CALM.outcome
    for name in ("times", "joints", "wrench", "opening", "lines", "force", "commanded", "payload", "grip"):
        assert np.array_equal(getattr(read, name), getattr(CALM, name))
    assert read.poses.keys() == CALM.poses.keys()
    half = (tmp_path / "rollout.npz").read_bytes()[:900]
    (tmp_path / "rollout.npz").write_bytes(half)
    with pytest.raises(UserError, match="holds no recorded run"):
        load_rollout(tmp_path / "rollout.npz", CALM.world)
    with pytest.raises(UserError, match="holds no recorded run"):
        load_rollout(tmp_path / "none.npz", CALM.world)
