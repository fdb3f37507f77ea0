"""soma:PuttingDown: lower a held object until it touches a surface; it stays in the hand."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Hang, Location, Motion, Stage
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, hookimpl

from ..task_kit.preconditions import held_payload, spot

LED = 0.05  # the hand leads what it lays down [m/s]: half of what is usual in the air, as it touches on the way


class PuttingDown(TaskType):
    task = "soma:PuttingDown"
    aliases = ("PutDown", "LowerOnto")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", features=("vrps:SurfaceFeature",), aliases=("target",)))
    places = True
    summary = "move above a surface and lower until contact"
    slides = False
    parameters = (
        Parameter("speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
        Parameter("force_n", 3.0, "above sensor noise, below what tips a light object"),
        Parameter("free_m_s", 0.1, "as things are lifted; the last 15 mm are gone at speed_m_s"),
        Parameter("duration_s", 0.3, "a block that was lowered at 10 mm/s bounced for 0.02 s; detection calls 0.06 s a state"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if held_payload(belief, "put down").swing is not None:
            yield self._laying_down(action)
            return
        place, surface = self.begins_at(action), action.roles["Relatum"]
        guard = {k: self.parameter(action, k) for k in ("speed_m_s", "force_n", "free_m_s")}
        rest = {"duration_s": self.parameter(action, "duration_s"), "paced": 1.0}
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"to {surface.entity}"),
            Motion(action.inside("enter"), "linear", place, {"stage": Stage.VIA}, reason="in, level"),
            Motion(action.inside("tare"), "zero_sensor", reason="the weight of the object is not a contact force"),
            Motion(action.inside("lower"), "until_contact", place, guard, (surface.name,), f"down to {surface.entity}"),
            Motion(action.inside("rest"), "hold", None, rest, reason="the object comes to rest before anybody lets go"),
        )
        yield Decomposition(steps, "guarded motion down to the surface")

    def _laying_down(self, action: Action) -> Decomposition:
        """Decomposition of laying down a hanging plate: its far side touches first, and the plate turns about that side until it lies."""
        place, surface = self.begins_at(action), action.roles["Relatum"]
        rest = {"duration_s": self.parameter(action, "duration_s")}
        lower = {"to": Hang.LIES}
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"above {surface.entity}"),
            Motion(action.inside("enter"), "linear", place, {"stage": Stage.VIA}, reason="in, level"),
            Motion(action.inside("reach"), "linear", place, {"stage": Stage.POSE, "speed_m_s": LED}, (surface.name,), "its far side first"),
            Motion(action.inside("lower"), "swing", place, lower, (surface.name,), "it turns back about its far side until it lies"),
            Motion(action.inside("rest"), "hold", None, rest, reason="the object comes to rest before anybody lets go"),
        )
        return Decomposition(steps, "lay the hanging thing down, its far side first")

    def effects(self, action: Action, belief: Belief) -> Belief:
        locatum, relatum = action.roles["Locatum"].entity or "", action.roles["Relatum"].thing
        return belief.unrelated("on", locatum).related(("on", locatum, relatum))

    def begins_at(self, action: Action) -> Location:
        return spot("on", action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [PuttingDown()]
