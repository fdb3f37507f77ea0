"""The Robotiq gripper behind its ASCII server: registers 0 .. 255 over the drive.

Registers and meanings: Robotiq 2F-85 instruction manual, "Control"; the server's words: docs/reference (SET, GET).
"""

from __future__ import annotations

from typing import Any

from cramlite.model import Gripper

from ..model.index import RobotIndex
from .gripper_drive import GripperDrive
from .gripper_order import COUNTS

NAMES = ("ACT", "GTO", "POS", "SPE", "FOR", "PRE", "OBJ", "STA", "FLT")
SETTABLE = ("ACT", "GTO", "POS", "SPE", "FOR")
OBJ = {"moving": 0, "stopped opening": 1, "stopped closing": 2, "there": 3}


class GripperServer(GripperDrive):
    """The gripper's registers, and the motion of the fingers that they command.

    Args:
        gripper: description.
        index: where the gripper is in the model.
    """

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        super().__init__(gripper, index, model)
        self.set = {"ACT": 1, "GTO": 1, "POS": 0, "SPE": 255, "FOR": 128}
        self.echo = 0

    def begin_as(self, data: Any) -> None:
        """Set the commanded opening and the registers to the fingers' present opening, before the first cycle."""
        super().begin_as(data)
        self.set["POS"] = self.echo = round(COUNTS * (self.widest - self.opening) / self.stroke)

    def grip(self, force: float) -> None:
        """Press on the payload before the first cycle, with a force of each pad [N]."""
        super().grip(force)
        weak, strong = self.gripper.force
        self.set["POS"] = self.echo = COUNTS
        self.set["FOR"] = round(COUNTS * min(max((force - weak) / (strong - weak), 0.0), 1.0))

    def order(self, name: str, value: int) -> bool:
        """Execute ``SET name value``; return False for an unknown register or value."""
        if name not in SETTABLE or not 0 <= value <= COUNTS:
            return False
        self.set[name] = value
        return True

    def ask(self, name: str) -> int | None:
        """Answer ``GET name``; None for an unknown register."""
        match name:
            case "POS":
                return round(COUNTS * (self.widest - self.opening) / self.stroke)
            case "PRE":
                return self.echo
            case "STA":
                return 3 if self.set["ACT"] else 0
            case "FLT":
                return 0
            case "OBJ":
                return OBJ[self.state()]
        return self.set.get(name)

    def advance(self, data: Any, period: float) -> None:
        """Advance by a control cycle, with the present values of the registers."""
        (slow, fast), (weak, strong) = self.gripper.speed, self.gripper.force
        self.speed = slow + (fast - slow) * self.set["SPE"] / COUNTS
        self.force = weak + (strong - weak) * self.set["FOR"] / COUNTS
        if self.set["GTO"] and self.set["ACT"] and self.echo != self.set["POS"]:
            self.echo = self.set["POS"]
            self.begin(self.widest - self.stroke * self.echo / COUNTS)
        super().advance(data, period)
