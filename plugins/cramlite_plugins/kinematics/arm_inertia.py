"""Inertia of an arm as its joints feel it, from the robot's own model."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from cramlite.model import Floats, Robot


def inertia(robot: Robot, q: Sequence[float] | Floats) -> Floats:
    """Compute the joint-space inertia matrix (n, n) of arm and empty gripper at joint positions [kg m2]."""
    import mujoco

    model, data, dofs, places = _model(robot, threading.get_ident())
    data.qpos[places] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_crb(model, data)
    mujoco.mj_fullM(model, data, full := np.zeros((model.nv, model.nv)))
    return full[np.ix_(dofs, dofs)]


@lru_cache(maxsize=8)
def _model(robot: Robot, thread: int) -> tuple[Any, Any, list[int], list[int]]:
    """MuJoCo's model and data of an arm, and the indices of its joints in velocities and in positions.

    Each thread has its own, as a computation changes the data.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(robot.mjcf())
    joints = [model.joint(name) for name in robot.joints]
    dofs = [int(j.dofadr[0]) for j in joints]
    if robot.rotors:
        model.dof_armature[dofs] = robot.rotors
    return model, mujoco.MjData(model), dofs, [int(j.qposadr[0]) for j in joints]
