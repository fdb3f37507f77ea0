"""soma:Navigating: drive to where a thing can be reached and seen."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl


class Navigating(TaskType):
    task = "soma:Navigating"
    aliases = ("Navigate", "GoTo", "Drive", "MoveBase")
    roles = (Role("Destination", aliases=("target",)),)
    summary = "park the arm and drive to where a thing can be reached and seen"
    touches = ()
    parameters = (
        Parameter("speed_m_s", 0.5, "a brisk arm's speed; half of the MPO-500's 0.9, walking pace is 1.4"),
        Parameter("speed_rad_s", 0.6, "a corner of the platform then moves at 0.36 m/s"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.at is None:
            raise Unresolvable(f"'{belief.robot}' is bolted down and cannot drive", ("",))
        there = action.roles["Destination"]
        stand = Location(f"stand({there.name})", "stand", there.name)
        rates = {p.name: self.parameter(action, p.name) for p in self.parameters}
        park = Motion(
            action.inside("park"), "transfer", self.begins_at(action), reason="nothing sticks out while it drives"
        )
        drive = Motion(action.inside("drive"), "drive", stand, rates, reason=f"to where {there.entity} can be reached")
        yield Decomposition((park, stand, drive), f"arm parked, drive to {there.entity}")

    def begins_at(self, action: Action) -> Location:
        return Location("home", "home")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Navigating()]
