"""Command to a parallel gripper, in metres and newtons: an opening, how the fingers approach it, and when
they have stopped."""

from __future__ import annotations

from typing import Literal

import numpy as np

from cramlite.model import Gripper

COUNTS = 255  # of a gripper's registers: 0 open, 255 closed
TOLERANCE = 3 / COUNTS  # share of the stroke within which an opening is reached: 1 mm of a 2F-85
STILL = 0.004  # fingers slower than this have stopped [m/s]
PATIENCE = 0.08  # for this long [s], before an object counts as found
CREEP = 1.5  # times what they are apart when they have closed on nothing: nearer to it they creep on, and are waited for longer

State = Literal["moving", "stopped opening", "stopped closing", "there"]


class GripperOrder:
    """Current command to the gripper: an opening, a speed and a force.

    ``command`` is the opening that the fingers are sent to now [m].
    """

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper
        low, self.widest = gripper.opening
        self.stroke = self.widest - low
        self.opening = self.goal = self.command = self.widest
        self.speed, self.force = gripper.speed[1], sum(gripper.force) / 2
        self.still, self.moved = 0.0, False
        self.tolerance, self.patience = TOLERANCE * self.stroke, PATIENCE
        self.closed = self.tolerance

    def move(self, opening: float, speed: float, force: float) -> None:
        """Command an opening [m] at a speed [m/s] with a grip force [N], each clamped to the gripper's range."""
        low, high = self.gripper.opening
        self.speed = float(np.clip(speed, *self.gripper.speed))
        self.force = float(np.clip(force, *self.gripper.force))
        self.begin(min(max(opening, low), high))

    def begin(self, opening: float) -> None:
        """Move the fingers to an opening [m], starting from the measured one, so that a squeezed object delays no release."""
        self.goal, self.still, self.command, self.moved = opening, 0.0, self.opening, False

    def stop(self) -> None:
        """Stop the fingers where they are."""
        self.begin(self.opening)

    def state(self) -> State:
        """Return whether the fingers move, have arrived, or were stopped by an object."""
        rest = self.opening - self.goal
        if abs(rest) <= self._near:
            return "there"
        if self.still < (min(PATIENCE, self.patience) if self._stopped else self.patience):
            return "moving"
        return "stopped closing" if rest > 0 else "stopped opening"

    @property
    def pressing(self) -> float:
        """Commanded force of the fingers [N]; 0 if they are to open, or to stay."""
        return self.force if self.goal < self.opening - self._near else 0.0

    @property
    def _stopped(self) -> bool:
        """Whether fingers that stand still have certainly been stopped by a thing, and have not just paused on their
        way.

        They had begun to close, press with all that they are ordered to, and are not nearly closed. Fingers
        that open press on nothing, and creep to the end of their way.
        """
        return self.moved and self.goal < self.opening and self.command == self.goal and self.opening > CREEP * self.closed

    @property
    def _near(self) -> float:
        """Tolerance of the commanded opening [m], at which the fingers count as arrived."""
        return self.closed if self.goal <= self.gripper.opening[0] else self.tolerance

    def follow(self, opening: float, period: float) -> None:
        """Take the measured opening [m], a control cycle after the last one, and move the commanded opening on towards
        its goal."""
        fast = abs(opening - self.opening) / period > STILL
        self.moved = self.moved or (fast and (opening - self.opening) * (self.goal - self.opening) > 0)
        self.opening = opening
        step = self.speed * period
        self.command += max(-step, min(step, self.goal - self.command))
        # The order has to be well ahead of the fingers before their rest means anything.
        ahead = abs(self.command - self.opening) > self._near
        self.still = self.still + period if ahead and not fast else 0.0
