"""The drive of a parallel gripper, in metres and newtons: it moves the simulated fingers and detects their stop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cramlite.model import Gripper

from ..model.index import RobotIndex
from .gripper_order import COUNTS, GripperOrder


class GripperDrive(GripperOrder):
    """A position drive that executes an order in a MuJoCo model.

    Args:
        gripper: description.
        index: where the gripper is in the model.

    ``strength`` is its real grip force as a multiple of the commanded one.
    """

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        super().__init__(gripper)
        self.index, self.model = index, model
        self.strength, self.limit = 1.0, math.nan  # limit: as the actuator has it [N]
        fingers = [(a, np.flatnonzero(model.jnt_qposadr == a)[0]) for a in index.fingers]
        self.fingers = [(a, self.stroke / len(fingers) / float(model.jnt_range[j, 1])) for a, j in fingers]

    def begin_as(self, data: Any) -> None:
        """Initialize the order from the fingers' state before the first cycle."""
        self.opening = self.goal = self.command = self.measured(data)

    def measured(self, data: Any) -> float:
        """Return the measured opening [m]."""
        qpos = data.qpos
        return self.widest - sum([scale * float(qpos[a]) for a, scale in self.fingers])  # a generator would take twice as long

    def advance(self, data: Any, period: float) -> None:
        """Advance by a control cycle: read the fingers, move the order on, and command the actuator."""
        self.follow(self.measured(data), period)
        # The tendon pulls both pads: twice the grip force of one (robots/parallel_gripper.py).
        force = self.strength * 2 * self.force
        if force != self.limit:
            self.limit = force
            self.model.actuator_forcerange[self.index.gripper] = (-force, force)
        data.ctrl[self.index.gripper] = COUNTS * (self.widest - self.command) / self.stroke
