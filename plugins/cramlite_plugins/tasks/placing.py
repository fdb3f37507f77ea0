"""soma:Placing: put a held object onto a surface and let go."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location
from cramlite.plugin import Decomposition, Role, TaskType, hookimpl

from ..task_kit.preconditions import held_payload, spot


class Placing(TaskType):
    task = "soma:Placing"
    aliases = ("Place", "PutOn")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", features=("vrps:SurfaceFeature",), aliases=("target",)))
    places = True
    summary = "lower a held object onto a surface, open, withdraw"
    slides = False

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        held_payload(belief, "placed")
        left = {"Relatum": action.roles["Locatum"]}  # what the hand withdraws from
        parts = {"soma:PuttingDown": action.roles, "soma:Releasing": action.roles, "soma:Retracting": left}
        steps = tuple(
            Action(action.inside(p.split(":")[-1]), p, roles, parameters=action.parameters) for p, roles in parts.items()
        )
        yield Decomposition(steps, "put down, release, retract")
        if belief.feature(action.roles["Relatum"].entity or "", "cram:Cavity"):
            drop = Action(action.inside("Ungrasping"), "artm:Ungrasping", action.roles, parameters=action.parameters)
            yield Decomposition((drop, steps[-1]), "let go over its floor, where the hand does not fit, and retract", 1.0)

    def effects(self, action: Action, belief: Belief) -> Belief:
        return belief.related(("on", action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""))

    def begins_at(self, action: Action) -> Location:
        return spot("on", action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Placing()]
