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
        Parameter("speed_m_s", 0.03, "below the 20 mm/s to 50 mm/s where inertia looks like contact"),
        Parameter("press_n", 3.0, "keeps contact without lifting friction above 2 N"),
        Parameter("force_limit_n", 25.0, "as for extraction"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable("nothing is held that could be slid", because=(EARLIER_TASKS,))
        surface = action.roles["Relatum"]
        way = Location(
            action.inside("slide"), "slide", surface.name, {"distance_m": self.parameter(action, "distance_m")}
        )
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "press_n", "force_limit_n")}
        slide = Motion(
            action.inside("stroke"), "compliant_slide", way, force, (surface.name,), f"along {surface.entity}"
        )
        yield Decomposition((way, slide), "straight stroke that follows the surface")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingObject()]
