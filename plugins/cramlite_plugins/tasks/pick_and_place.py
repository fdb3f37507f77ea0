"""cram:PickAndPlace: take a thing from where it stands and put it onto a surface."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl

from ..task_kit.preconditions import empty_hand, grasp_of


class PickAndPlace(TaskType):
    task = "cram:PickAndPlace"
    aliases = ("PickPlace", "MoveObject")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", features=("vrps:SurfaceFeature",), aliases=("target",)))
    places = True
    puts_aside = ("Locatum", "Relatum")
    summary = "grasp an object, lift it, put it onto a surface"
    slides = False

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        empty_hand(belief)
        thing = action.roles["Locatum"]
        steps = (
            Action(action.inside("Grasping"), "soma:Grasping", {"Patient": thing}),
            Action(action.inside("PickingUp"), "soma:PickingUp", {"Locatum": thing}),
            Action(action.inside("Placing"), "soma:Placing", action.roles, parameters=action.parameters),
        )
        yield Decomposition(steps, "grasp, pick up, place")

    def effects(self, action: Action, belief: Belief) -> Belief:
        return belief.related(("on", action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""))

    def begins_at(self, action: Action) -> Location:
        return grasp_of(action.roles["Locatum"])


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [PickAndPlace()]
