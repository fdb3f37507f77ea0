"""artm:CloseGripperTask: close the empty gripper where it is."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Motion
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl

from ..task_kit.preconditions import empty_hand


class CloseGripperTask(TaskType):
    task = "artm:CloseGripperTask"
    aliases = ("CloseGripper",)
    roles = (Role("Agent", required=False, effector=True),)
    summary = "close the empty gripper where it is"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        empty_hand(belief)
        yield Decomposition(
            (
                Motion(
                    action.inside("close"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="close on nothing"
                ),
            ),
            "close",
        )


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [CloseGripperTask()]
