"""artm:Ungrasping: let go of an object in or above a container."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl

from ..task_kit.preconditions import spot, what_is_held


class Ungrasping(TaskType):
    task = "artm:Ungrasping"
    aliases = ("DropInto", "Ungrasp")
    roles = (Role("Locatum"), Role("Relatum", ("soma:DesignedContainer",), features=("cram:Cavity",)))
    places = True
    summary = "carry a held object into a container's opening and let go"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        what_is_held(belief, "let go")
        container = action.roles["Relatum"].entity
        yield self._let_down(action, self.begins_at(action), f"move above {container}, lower, open")
        aslant = replace(spot("aslant", action), name=f"aslant({action.roles['Relatum'].name})")
        said = f"lean it to get it in under what is over {container}, straighten it there, open"
        yield replace(self._let_down(action, aslant, said), cost=1.0)

    def _let_down(self, action: Action, place: Location, said: str) -> Decomposition:
        container = action.roles["Relatum"].entity
        upright = Motion(action.inside("straighten"), "linear", place, {"stage": "end"}, reason="upright")
        straighten = (upright,) if place.relation == "aslant" else ()
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"above {container}"),
            Motion(action.inside("lower"), "linear", place, {"stage": "pose"}, reason=f"as deep into {container} as the hand fits"),
            *straighten,
            Motion(action.inside("open"), "gripper", place, {"to": "open", "expect": "none"}, reason="let go"),
            Motion(action.inside("payload"), "payload", reason="the gripper is empty again"),
        )
        return Decomposition(steps, said)

    def effects(self, action: Action, belief: Belief) -> Belief:
        locatum, relatum = action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""
        return belief.related(("in", locatum, relatum))

    def begins_at(self, action: Action) -> Location:
        return spot("in", action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Ungrasping()]
