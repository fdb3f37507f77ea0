"""Recorded run of a single sample that shows the world before any run, so that it is drawn as a run is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..model.entity_name import EntityName
from ..model.run.rollout import Rollout

if TYPE_CHECKING:
    from ..model.geometry import Floats, Pose
    from .setting import Setting


def start_record(setting: Setting) -> Rollout:
    """Return a recording with a single sample: the believed world and the robot before anything moves."""
    mount, belief = setting.world.robots[0], setting.belief()
    poses = {t.name: _row(t.pose) for t in setting.world.things if t.movable}
    poses |= {str(EntityName(mount.name, "base")): _row(mount.base)}
    return Rollout(
        world=setting.world,
        effector=mount.name,
        times=np.zeros(1),
        poses=poses,
        touches=((),),
        joints=np.array([belief.joints]),
        wrench=np.zeros((1, 6)),
        opening=np.array([belief.opening]),
        lines=np.zeros(1),
    )


def _row(pose: Pose) -> Floats:
    """Return a pose as an array (1, 7): position [m], quaternion (w, x, y, z)."""
    return np.array([[*pose.position, *pose.quaternion]])
