"""The drive of a parallel gripper, in metres and newtons: it moves the simulated fingers and detects their stop."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from cramlite.model import Gripper

from ..model.index import RobotIndex
from .jaws import COUNTS, jaws_of

TOLERANCE = 3 / COUNTS  # share of the stroke within which an opening is reached: 1 mm of a 2F-85
STILL = 0.004  # fingers slower than this have stopped [m/s]
PATIENCE = 0.08  # for this long [s], before an object counts as found

State = Literal["moving", "stopped opening", "stopped closing", "there"]


class GripperDrive:
    """A position drive that executes one order at a time: an opening, a speed and a force.

    Args:
        gripper: description.
        index: where the gripper is in the model.

    ``strength`` is its real grip force as a multiple of the commanded one.
    """

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        self.gripper, self.index = gripper, index
        low, self.widest = gripper.opening
        self.stroke = self.widest - low
        self.opening = self.goal = self.command = self.widest
        self.speed, self.force = gripper.speed[1], sum(gripper.force) / 2
        self.still, self.strength, self.limit = 0.0, 1.0, math.nan  # limit: of the grip force, as the actuators have it [N]
        self.jaws = jaws_of(gripper, index, model)

    def begin_as(self, data: Any) -> None:
        """Initialize the order from the fingers' state before the first cycle."""
        self.opening = self.goal = self.command = self.measured(data)

    def measured(self, data: Any) -> float:
        """Return the measured opening [m]."""
        return self.jaws.measured(data)

    def move(self, opening: float, speed: float, force: float) -> None:
        """Order an opening [m] at a speed [m/s] with a grip force [N], each clamped to the gripper's range."""
        low, high = self.gripper.opening
        self.speed = float(np.clip(speed, *self.gripper.speed))
        self.force = float(np.clip(force, *self.gripper.force))
        self.begin(min(max(opening, low), high))

    def begin(self, opening: float) -> None:
        """Start towards an opening [m] from the fingers' present one: a squeezed object must not delay the opening."""
        self.goal, self.still, self.command = opening, 0.0, self.opening

    def stop(self) -> None:
        """Stop the fingers where they are."""
        self.begin(self.opening)

    def state(self) -> State:
        """Return whether the fingers move, have arrived, or were stopped by an object."""
        rest = self.opening - self.goal
        if abs(rest) <= TOLERANCE * self.stroke:
            return "there"
        if self.still < PATIENCE:
            return "moving"
        return "stopped closing" if rest > 0 else "stopped opening"

    def advance(self, data: Any, period: float) -> None:
        """Advance by a control cycle: read the fingers, move the order on, and command the actuator."""
        opening = self.measured(data)
        fast = abs(opening - self.opening) / period > STILL
        self.opening = opening
        step = self.speed * period
        self.command += max(-step, min(step, self.goal - self.command))
        # The order has to be well ahead of the fingers before their rest means anything.
        ahead = abs(self.command - self.opening) > TOLERANCE * self.stroke
        self.still = self.still + period if ahead and not fast else 0.0
        force = self.strength * self.force
        if force != self.limit or self.index.linkage is not None:  # a linkage's leverage changes with its opening
            self.limit = force
            self.jaws.limit(force, opening)
        self.jaws.order(data, self.command)
