"""cram:PickAndPlace: take a thing from where it stands and put it onto a surface."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import (
    EARLIER_TASKS,
    Action,
    Belief,
    Decomposition,
    Location,
    Object,
    Role,
    TaskType,
    Unresolvable,
    hookimpl,
)


class PickAndPlace(TaskType):
    task = "cram:PickAndPlace"
    aliases = ("PickPlace", "MoveObject")
    roles = (Role("Locatum"), Role("Relatum", features=("vrps:SurfaceFeature",)))
    places = True
    summary = "grasp an object, lift it, put it onto a surface"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(f"the gripper already holds '{belief.held.thing}'", because=(EARLIER_TASKS,))
        thing = action.roles["Locatum"]
        parts: tuple[tuple[str, dict[str, Object]], ...] = (
            ("soma:Grasping", {"Patient": thing}), ("soma:PickingUp", {"Locatum": thing}), ("soma:Placing", dict(action.roles)),
        )  # fmt: skip
        steps = tuple(
            Action(action.inside(p.split(":")[-1]), p, roles, parameters=action.parameters if p == "soma:Placing" else {})
            for p, roles in parts
        )
        yield Decomposition(steps, "grasp, pick up, place")

    def effects(self, action: Action, belief: Belief) -> Belief:
        return belief.related(("on", action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""))

    def begins_at(self, action: Action) -> Location:
        thing = action.roles["Locatum"].name
        return Location(f"grasp({thing})", "grasp", thing)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [PickAndPlace()]
