"""soma:ParkingArms: move the arm to its park position."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl


class ParkingArms(TaskType):
    task = "soma:ParkingArms"
    aliases = ("ParkArms", "Park")
    roles = (Role("Agent", required=False, effector=True),)
    summary = "move the arm to its park position"
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        move = Motion(action.inside("park"), "transfer", Location("home", "home"), reason="to the park position")
        yield Decomposition((move,), "collision-free motion to the park position")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [ParkingArms()]
