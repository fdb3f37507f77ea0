"""artm:SlidingObject: move a held object along the surface that it rests on, pressing gently."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl

from ..task_kit.bases import Sliding
from ..task_kit.preconditions import held_payload


class SlidingObject(Sliding):
    task = "artm:SlidingObject"
    aliases = ("Sliding", "SlideObject")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", features=("vrps:SurfaceFeature",)))
    summary = "move a held object along the surface that it rests on"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        held_payload(belief, "slid")
        yield self.slide(action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingObject()]
