"""artm:SlidingObject: move a held object along the surface that it rests on, pressing gently."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Role, TaskType, hookimpl
from cramlite_plugins.motions.hand import what_is_held
from cramlite_plugins.motions.sliding import Sliding


class SlidingObject(Sliding):
    task = "artm:SlidingObject"
    aliases = ("Sliding", "SlideObject")
    roles = (Role("Locatum"), Role("Relatum", features=("vrps:SurfaceFeature",)))
    summary = "move a held object along the surface that it rests on"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        what_is_held(belief, "slid")
        yield self.slide(action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingObject()]
