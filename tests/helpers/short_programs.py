"""Short programs for the virtual controller, and what comes of them."""

from __future__ import annotations

from functools import cache

import numpy as np
from msgspec.structs import replace

from cramlite.model import AnyStep, MoveJoints, MoveUntilContact, Pose, Program, Rollout, SetGripper, World
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.execute import execute
from helpers.standard import ROBOTS, standing_world

WORLD = standing_world().moved({"product": Pose((0.55, 0.1, 0.075))})
FINGERTIP = 0.01875  # from the pinch point to the fingertips [m]


def down(x: float, y: float, z: float) -> Pose:
    """Return a TCP pose that points down at a position, with the fingers closing along y."""
    return Pose.from_axes((x, y, z), (0, 0, -1), (1, 0, 0))


@cache
def near_home(target: Pose) -> tuple[float, ...]:
    """Return joint positions for a TCP pose, with the elbow up and near the home posture."""
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
