"""soma:Pouring: let the contents of a held vessel flow into another one."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion, Tilt
from cramlite.plugin import HAND, Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl

from ..shapes.contents import SHARE, SPILLED, pouring_obstacle


class Pouring(TaskType):
    task = "soma:Pouring"
    aliases = ("Pour", "PourInto")
    roles = (Role("Source", features=("cram:Cavity",), filled=True), Role("Destination", features=("cram:Cavity",), aliases=("target",)))
    summary = "tilt a held vessel about its rim, over another one, and back"
    slides = False
    touches = ((HAND, "Source"),)
    parameters = (
        Parameter("tilt_rad", 2.1, "120 deg: walls of an upright vessel then slope by 30 deg, the angle of repose of grains"),
        Parameter("height_m", 0.03, "of the lip over the rim: balls of 10 mm pass under it three deep"),
        Parameter("speed_rad_s", 0.5, "4 s for a tilt; the surface then leads the vessel by less than the contents slide"),
        Parameter("duration_s", 1.0, "until the last grain has left: 0.1 m of a slope of 30 deg take 0.3 s"),
        Parameter("share", SHARE, "of the contents that must arrive; all did in simulation"),
        Parameter("spilled", SPILLED, "of the contents that may be beside all vessels: one ball of 12"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        source, into = action.roles["Source"], action.roles["Destination"]
        if belief.held is None or belief.held.thing != source.entity:
            raise Unresolvable.because_of_earlier_tasks(f"'{source.entity}' is not in the hand", (source.name,))
        if reason := pouring_obstacle(belief, source.entity or "", into.entity or ""):
            raise Unresolvable.because_of_earlier_tasks(reason, (source.name, into.name))
        place = self.begins_at(action)
        speed, wait = ({k: self.parameter(action, k)} for k in ("speed_rad_s", "duration_s"))
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"the rim over {into.entity}"),
            Motion(action.inside("tilt"), "tilt", place, {"to": Tilt.TILTED, **speed}, reason="about the rim"),
            Motion(action.inside("flow"), "hold", None, wait, reason="until the last has left"),
            Motion(action.inside("back"), "tilt", place, {"to": Tilt.UPRIGHT, **speed}, reason="upright again"),
        )
        yield Decomposition(steps, f"tilt over {into.entity}, wait, tilt back")

    def effects(self, action: Action, belief: Belief) -> Belief:
        source, into = (action.roles[r].entity or "" for r in ("Source", "Destination"))
        return belief.related(("contains", into, source))

    def begins_at(self, action: Action) -> Location:
        into, how = action.roles["Destination"].name, {k: self.parameter(action, k) for k in ("tilt_rad", "height_m")}
        return Location(f"pour({into})", "pour", into, how)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Pouring()]
