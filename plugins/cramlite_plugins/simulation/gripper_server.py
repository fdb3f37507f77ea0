"""The Robotiq gripper behind its ASCII server, driven by what the simulated fingers really do.

Registers and meanings: Robotiq 2F-85 instruction manual, "Control"; the server's words: docs/reference (SET, GET).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cramlite.robots import Gripper

from .index import RobotIndex

NAMES = ("ACT", "GTO", "POS", "SPE", "FOR", "PRE", "OBJ", "STA", "FLT")
SETTABLE = ("ACT", "GTO", "POS", "SPE", "FOR")
SPEED = (0.020, 0.150)  # closing speed at SPE 0 and 255 [m/s]: the manual's "Specifications"
TOLERANCE = 3.0  # counts within which a position is reached
STILL = 0.004  # fingers slower than this have stopped [m/s]
PATIENCE = 0.08  # for this long [s], before an object counts as found


class GripperServer:
    """Registers and the motion that they order.

    Args:
        gripper: description.
        index: where the gripper is in the model.
    """

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        self.gripper, self.index, self.model = gripper, index, model
        self.set = {"ACT": 1, "GTO": 1, "POS": 0, "SPE": 255, "FOR": 128}
        self.echo = 0
        self.command = 0.0
        self.opening = gripper.opening[1]
        self.still = 0.0
        low, self.widest = gripper.opening
        fingers = [(a, np.flatnonzero(model.jnt_qposadr == a)[0]) for a in index.fingers]
        self.fingers = [(a, (self.widest - low) / len(fingers) / float(model.jnt_range[j, 1])) for a, j in fingers]

    def order(self, name: str, value: int) -> bool:
        """``SET name value``; False for a register or value that there is not."""
        if name not in SETTABLE or not 0 <= value <= 255:
            return False
        self.set[name] = value
        return True

    def ask(self, name: str) -> int | None:
        """``GET name``; None for a register that there is not."""
        match name:
            case "POS":
                return round(self.position)
            case "PRE":
                return self.echo
            case "STA":
                return 3 if self.set["ACT"] else 0
            case "FLT":
                return 0
            case "OBJ":
                return self.object()
        return self.set.get(name)

    @property
    def position(self) -> float:
        """Where the fingers are, in counts."""
        low, high = self.gripper.opening
        return 255 * (high - self.opening) / (high - low)

    def object(self) -> int:
        """0 moving, 1 stopped while opening, 2 stopped while closing, 3 at the position."""
        rest = self.echo - self.position
        if abs(rest) <= TOLERANCE:
            return 3
        if self.still < PATIENCE:
            return 0
        return 2 if rest > 0 else 1

    def advance(self, data: Any, period: float) -> None:
        """One control cycle: read the fingers, move the order on, and command the actuator."""
        opening = self.widest - sum(scale * float(data.qpos[a]) for a, scale in self.fingers)
        fast = abs(opening - self.opening) / period > STILL
        self.opening = opening
        if self.set["GTO"] and self.set["ACT"] and self.echo != self.set["POS"]:
            # From where the fingers are: what squeezed an object so far must not delay the opening.
            self.echo, self.still, self.command = self.set["POS"], 0.0, self.position
        low, high = self.gripper.opening
        rate = (SPEED[0] + (SPEED[1] - SPEED[0]) * self.set["SPE"] / 255) * 255 / (high - low)
        step = max(-rate * period, min(rate * period, self.echo - self.command))
        self.command += step
        # The order has to be well ahead of the fingers before their rest means anything.
        ahead = abs(self.command - self.position) > TOLERANCE
        self.still = self.still + period if ahead and not fast else 0.0
        self._actuate(data)

    def _actuate(self, data: Any) -> None:
        low, high = self.gripper.force
        force = low + (high - low) * self.set["FOR"] / 255
        # The tendon pulls both pads: twice the grip force of one (robots/robotiq_2f85.py).
        self.model.actuator_forcerange[self.index.gripper] = (-2 * force, 2 * force)
        data.ctrl[self.index.gripper] = self.command
