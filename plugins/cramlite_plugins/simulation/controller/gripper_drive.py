"""The drive of a parallel gripper, in metres and newtons: it moves the simulated fingers and detects their stop."""

from __future__ import annotations

import math
from typing import Any

from cramlite.model import Gripper

from ..model.index import RobotIndex
from .gripper_order import GripperOrder
from .jaws import jaws_of


class GripperDrive(GripperOrder):
    """Position drive of a simulated gripper: it moves the fingers in a MuJoCo model as they are commanded.

    Args:
        gripper: description.
        index: where the gripper is in the model.

    ``strength`` is its real grip force as a multiple of the commanded one; ``nearest`` how near the fingers come at all [m], and ``forced``
    an opening that they go to whatever is ordered [m], None for none: faults.
    """

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        super().__init__(gripper)
        self.index, self.jaws = index, jaws_of(gripper, index, model)
        self.nearest, self.forced = 0.0, None  # type: float, float | None
        self.strength, self.limit = 1.0, math.nan  # limit: of the grip force, as the actuators have it [N]

    def begin_as(self, data: Any) -> None:
        """Set the commanded opening to the fingers' present one, before the first cycle."""
        self.opening = self.goal = self.command = self.measured(data)

    def grip(self, force: float) -> None:
        """Press on the payload before the first cycle, with a force of each pad [N]."""
        self.move(self.gripper.opening[0], self.gripper.speed[1], force)
        self.command = self.goal

    def measured(self, data: Any) -> float:
        """Return the measured opening [m]."""
        return self.jaws.measured(data)

    def advance(self, data: Any, period: float) -> None:
        """Advance by a control cycle: read the fingers, move the commanded opening on, and command the
        actuator."""
        opening = self.measured(data)
        self.follow(opening, period)
        force = self.strength * self.force
        if force != self.limit or self.index.linkage is not None:  # a linkage's leverage changes with its opening
            self.limit = force
            self.jaws.limit(force, opening)
        self.jaws.order(data, max(self.command if self.forced is None else self.forced, self.nearest))
