"""artm:SlidingGripper: move the empty gripper along a surface, in contact, pressing gently."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Location, Motion, Parameter, Role, TaskType, Unresolvable, hookimpl


class SlidingGripper(TaskType):
    task = "artm:SlidingGripper"
    aliases = ("SlideGripper",)
    roles = (Role("Locatum", effector=True, required=False), Role("Relatum", features=("vrps:SurfaceFeature",)))
    summary = "move the empty gripper along a surface, in contact"
    parameters = (
        Parameter("distance_m", 0.08, "a short stroke; scenarios say what they need"),
        Parameter("speed_m_s", 0.02, "at 20 mm/s and less inertia does not look like contact"),
        Parameter("press_n", 12.0, "keeps contact in simulation; 3 N bounced for up to 1.2 s, 8 N for 0.1 s"),
        Parameter("force_limit_n", 25.0, "as for extraction; a free stroke stays below 17 N"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(
                f"the gripper holds '{belief.held.thing}'; it must be empty to slide along a surface itself"
            )
        surface = action.roles["Relatum"]
        way = Location(
            action.inside("slide"), "slide", surface.name, {"distance_m": self.parameter(action, "distance_m")}
        )
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "press_n", "force_limit_n")}
        tare = Motion(action.inside("tare"), "zero_sensor", reason="from here on, more is pressing")
        slide = Motion(action.inside("stroke"), "compliant_slide", way, force, (surface.name,), f"along {surface.entity}")
        yield Decomposition((way, tare, slide), "straight stroke that follows the surface")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [SlidingGripper()]
