"""soma:Placing: put a held object onto a surface and let go."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import EARLIER_TASKS, Action, Belief, Decomposition, Location, Role, TaskType, Unresolvable, hookimpl


class Placing(TaskType):
    task = "soma:Placing"
    aliases = ("Place", "PutOn")
    roles = (Role("Locatum"), Role("Relatum", features=("vrps:SurfaceFeature",)))
    places = True
    summary = "lower a held object onto a surface, open, withdraw"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable("nothing is held that could be placed", because=(EARLIER_TASKS,))
        parts = ("soma:PuttingDown", "soma:Releasing", "soma:Retracting")
        steps = tuple(
            Action(action.inside(p.split(":")[-1]), p, action.roles, parameters=action.parameters) for p in parts
        )
        yield Decomposition(steps, "put down, release, retract")

    def effects(self, action: Action, belief: Belief) -> Belief:
        return belief.related(("on", action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""))

    def begins_at(self, action: Action) -> Location:
        surface = action.roles["Relatum"].name
        return Location(f"on({surface})", "on", surface, action.parameters.get("where", {}))


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Placing()]
