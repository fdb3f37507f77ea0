"""artm:SlidingObject: move a held object along the surface that it rests on, pressing gently."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import (
    EARLIER_TASKS,
    Action,
    Belief,
    Decomposition,
    Location,
    Motion,
    Parameter,
    Role,
    TaskType,
    Unresolvable,
    hookimpl,
)


class SlidingObject(TaskType):
    task = "artm:SlidingObject"
    aliases = ("Sliding", "SlideObject")
    roles = (Role("Locatum"), Role("Relatum", features=("vrps:SurfaceFeature",)))
    summary = "move a held object along the surface that it rests on"
    parameters = (
        Parameter("distance_m", 0.08, "a short stroke; scenarios say what they need"),
        Parameter("speed_m_s", 0.02, "at 20 mm/s and less inertia does not look like contact"),
        Parameter("press_n", 12.0, "keeps contact in simulation; 3 N bounced for up to 1.2 s, 8 N for 0.1 s"),
        Parameter("force_limit_n", 25.0, "as for extraction; a free stroke stays below 17 N"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable("nothing is held that could be slid", because=(EARLIER_TASKS,))
        surface = action.roles["Relatum"]
        way = Location(
            action.inside("slide"), "slide", surface.name, {"distance_m": self.parameter(action, "distance_m")}
        )
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "press_n", "force_limit_n")}
        tare = Motion(action.inside("tare"), "zero_sensor", reason="from here on, more is pressing")
        slide = Motion(
            action.inside("stroke"), "compliant_slide", way, force, (surface.name,), f"along {surface.entity}"
        )
        yield Decomposition((way, tare, slide), "straight stroke that follows the surface")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingObject()]
