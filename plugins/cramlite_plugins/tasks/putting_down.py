"""soma:PuttingDown: lower a held object until it touches a surface; it stays in the hand."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, hookimpl

from ..task_kit.preconditions import spot, what_is_held


class PuttingDown(TaskType):
    task = "soma:PuttingDown"
    aliases = ("PutDown", "LowerOnto")
    roles = (Role("Locatum"), Role("Relatum", features=("vrps:SurfaceFeature",)))
    places = True
    summary = "move above a surface and lower until contact"
    parameters = (
        Parameter("speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
        Parameter("force_n", 3.0, "above sensor noise, below what tips a light object"),
        Parameter("free_m_s", 0.1, "as things are lifted; the last 15 mm are gone at speed_m_s"),
        Parameter("duration_s", 0.3, "a block that was lowered at 10 mm/s bounced for 0.02 s; detection calls 0.06 s a state"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        what_is_held(belief, "put down")
        place, surface = self.begins_at(action), action.roles["Relatum"]
        guard = {k: self.parameter(action, k) for k in ("speed_m_s", "force_n", "free_m_s")}
        rest = {"duration_s": self.parameter(action, "duration_s")}
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"above {surface.entity}"),
            Motion(action.inside("tare"), "zero_sensor", reason="the weight of the object is not a contact force"),
            Motion(action.inside("lower"), "until_contact", place, guard, (surface.name,), f"down to {surface.entity}"),
            Motion(action.inside("rest"), "hold", None, rest, reason="the object comes to rest before anybody lets go"),
        )
        yield Decomposition(steps, "guarded motion down to the surface")

    def effects(self, action: Action, belief: Belief) -> Belief:
        locatum, relatum = action.roles["Locatum"].entity or "", action.roles["Relatum"].thing
        return belief.unrelated("on", locatum).related(("on", locatum, relatum))

    def begins_at(self, action: Action) -> Location:
        return spot("on", action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [PuttingDown()]
