"""soma:Releasing: open the fingers where the hand is."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Motion, Role, TaskType, Unresolvable, hookimpl


class Releasing(TaskType):
    task = "soma:Releasing"
    aliases = ("Release", "LetGo")
    roles = (Role("Locatum"), Role("Relatum", required=False))
    summary = "open the fingers; what they held stays with what supports it"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable("nothing is held that could be released")
        steps = (
            Motion(action.inside("open"), "gripper", None, {"to": "open", "expect": "none"}, reason="let go"),
            Motion(action.inside("payload"), "payload", reason="the gripper is empty again"),
        )
        yield Decomposition(steps, "open the fingers here")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Releasing()]
