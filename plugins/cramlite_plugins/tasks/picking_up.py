"""soma:PickingUp: lift a held object off its support."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Hang, Location, Motion, Stage
from cramlite.plugin import HAND, Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl

SWINGS = "it turns between the pads until it hangs"


class PickingUp(TaskType):
    task = "soma:PickingUp"
    aliases = ("PickUp", "Lift")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", required=False))
    summary = "lift a held object straight up"
    touches = ((HAND, "Locatum"), (HAND, "Relatum"))
    carries_on = True
    slides = False
    parameters = (Parameter("height_m", 0.1, "clears the rim of a tray and leaves room for a free motion"),)

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable.because_of_earlier_tasks("the object must be grasped before it is picked up")
        if peg := belief.relates("hangs_on", belief.held.thing):
            locatum = action.roles.get("Locatum")
            meant = locatum is not None and locatum.thing == belief.held.thing
            reason = f"'{belief.held.thing}' hangs on '{peg}', which constrains more than one degree of freedom"
            if locatum is not None and meant:
                raise Unresolvable.because_of_earlier_tasks(reason, (locatum.name,))
            raise Unresolvable(reason)
        up = Location(action.inside("up"), "lift", parameters={"height_m": self.parameter(action, "height_m")})
        touched = tuple(o.name for k, o in action.roles.items() if k == "Relatum")
        if belief.held.swing is not None:
            swings = Motion(action.inside("lift"), "swing", up, {"to": Hang.HANGS}, touched, SWINGS)
            yield Decomposition((up, swings), f"straight up; {SWINGS}")
            return
        yield Decomposition(
            (up, Motion(action.inside("lift"), "linear", up, {"stage": Stage.POSE}, touched, "straight up")), "straight up"
        )


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [PickingUp()]
