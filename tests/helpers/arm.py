"""A plain arm driver for tests: damped least squares and joint ramps."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from cramlite.model import Pose
from cramlite_plugins.simulation.model.compile import Compiled

FORWARD = Pose.from_axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, -1))


def solve(compiled: Compiled, target: Pose, start: Any, mount: str = "arm") -> Any:
    """Solve for the joint positions that put the tool frame at a pose [rad]."""
    model, index = compiled.model, compiled.robots[mount]
    data = mujoco.MjData(model)
    joints, dofs = list(index.joints), list(index.dofs)
    data.qpos[joints] = start
    jac = np.zeros((6, model.nv))
    for _ in range(300):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        now = index.pose(data)
        turn = Pose.from_matrix(target.rotation @ now.rotation.T).rotvec
        error = np.r_[np.subtract(target.position, now.position), turn]
        if np.linalg.norm(error) < 1e-5:
            return data.qpos[joints].copy()
        mujoco.mj_jacSite(model, data, jac[:3], jac[3:], index.tcp)
        j = jac[:, dofs]
        step = j.T @ np.linalg.solve(j @ j.T + 1e-4 * np.eye(6), error)
        data.qpos[joints] += step * min(1.0, 0.3 / np.abs(step).max())
    raise AssertionError(f"no joint angles for {target}")


def line(compiled: Compiled, start: Pose, end: Pose, q: Any, count: int = 10) -> list[Any]:
    """Return joint positions along a straight line of the tool frame between two poses [rad]."""
    found = []
    for s in np.linspace(0, 1, count + 1):
        place = np.multiply(start.position, 1 - s) + np.multiply(end.position, s)
        q = solve(compiled, Pose(tuple(place), start.quaternion), q)
        found.append(q)
    return found


def ramp(compiled: Compiled, data: Any, targets: dict[int, float], steps: int, observe: Any = None) -> None:
    """Move the targets of actuators linearly to new values while the physics runs."""
    first = {a: data.ctrl[a] for a in targets}
    for k in range(steps):
        for a, value in targets.items():
            data.ctrl[a] = first[a] + (value - first[a]) * (k + 1) / steps
        mujoco.mj_step(compiled.model, data)
        if observe is not None:
            observe(data)


def follow(compiled: Compiled, data: Any, path: list[Any], steps: int = 50, observe: Any = None) -> None:
    for q in path:
        ramp(compiled, data, dict(zip(compiled.robots["arm"].actuators, q, strict=True)), steps, observe)


def lift(compiled: Compiled, data: Any, observe: Any = None) -> tuple[Pose, Pose]:
    """Grasp the product of ``standing_world``, lift it by 10 cm, hold it for 1 s.

    Returns:
        The product in the tool frame before and after.
    """
    index = compiled.robots["arm"]
    place = compiled.pose(data, "product").position
    grasp = Pose(place) * FORWARD
    before, above = Pose((-0.12, 0, 0)) * grasp, Pose((0, 0, 0.1)) * grasp
    approach = line(compiled, before, grasp, (3.02, -1.17, 2.5, -1.33, 1.45, -1.57))
    data.qpos[list(index.joints)] = approach[0]
    data.ctrl[list(index.actuators)] = approach[0]
    mujoco.mj_forward(compiled.model, data)
    follow(compiled, data, approach, observe=observe)
    ramp(compiled, data, {index.gripper: 200.0}, 200, observe)
    ramp(compiled, data, {}, 200, observe)
    held = index.pose(data).inverse() * compiled.pose(data, "product")
    follow(compiled, data, line(compiled, grasp, above, approach[-1]), observe=observe)
    ramp(compiled, data, {}, 500, observe)
    return held, index.pose(data).inverse() * compiled.pose(data, "product")
