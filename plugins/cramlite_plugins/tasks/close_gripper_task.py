"""artm:CloseGripperTask: close the empty gripper where it is."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import EARLIER_TASKS, Action, Belief, Decomposition, Motion, Role, TaskType, Unresolvable, hookimpl


class CloseGripperTask(TaskType):
    task = "artm:CloseGripperTask"
    aliases = ("CloseGripper",)
    roles = (Role("Agent", required=False, effector=True),)
    summary = "close the empty gripper where it is"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(f"the gripper already holds '{belief.held.thing}'", because=(EARLIER_TASKS,))
        yield Decomposition(
            (
                Motion(
                    action.inside("close"), "gripper", None, {"to": "shut", "expect": "none"}, reason="close on nothing"
                ),
            ),
            "close",
        )


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [CloseGripperTask()]
