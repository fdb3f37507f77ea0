"""artm:SlidingGripper: move the empty gripper along a surface, in contact, pressing gently."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl

from ..task_kit.bases import Sliding


class SlidingGripper(Sliding):
    task = "artm:SlidingGripper"
    aliases = ("SlideGripper",)
    roles = (Role("Locatum", effector=True, required=False), Role("Relatum", features=("vrps:SurfaceFeature",)))
    summary = "move the empty gripper along a surface, in contact"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(
                f"the gripper holds '{belief.held.thing}'; it must be empty to slide along a surface itself"
            )
        yield self.slide(action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingGripper()]
