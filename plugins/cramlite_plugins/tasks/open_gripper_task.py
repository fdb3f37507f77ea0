"""artm:OpenGripperTask: open the empty gripper where it is."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Motion
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl


class OpenGripperTask(TaskType):
    task = "artm:OpenGripperTask"
    aliases = ("OpenGripper",)
    roles = (Role("Agent", required=False, effector=True),)
    summary = "open the empty gripper where it is"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable.because_of_earlier_tasks(
                f"opening would drop '{belief.held.thing}'; Releasing does that on purpose"
            )
        yield Decomposition(
            (Motion(action.inside("open"), "gripper", None, {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}, reason="open"),), "open"
        )


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [OpenGripperTask()]
