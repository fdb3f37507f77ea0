"""soma:Grasping: the fingers close on an object until friction holds it."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Location, Motion, Stage
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, hookimpl

from ..task_kit.preconditions import empty_hand, grasp_of

FREE = 0.08  # of an arm that has a pace, on its way to a grasp [m/s]: with a pace of 2.5 it brakes in the last 25 mm
IN_PLACE = 0.01  # standard deviation [m] up to which a thing that was let go may still be between the fingers


class Grasping(TaskType):
    task = "soma:Grasping"
    aliases = ("Grasp",)
    roles = (Role("Patient", ("soma:PhysicalObject", "dul:PhysicalObject"), aliases=("object",)),)
    summary = "approach an object, close the fingers, check that it is held"
    slides = False
    parameters = (
        Parameter(
            "approach_speed_m_s", 0.05, "slow enough to stop within a millimetre, ISO 10218 reduced speed is 0.25"
        ),
        Parameter("force_n", 0.0, "0: from weight, friction and a margin, docs/explanation/simulation.md"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        empty_hand(belief)
        grasp = self.begins_at(action)
        patient = action.roles["Patient"].name
        speed = self.parameter(action, "approach_speed_m_s")
        close = {"to": Fingers.CLOSED, "expect": ExpectedGrip.OBJECT, "force_n": self.parameter(action, "force_n")}
        steps = (
            grasp,
            Motion(action.inside("open"), "gripper", grasp, {"to": Fingers.PLACE}, reason="as wide as the grasp needs"),
            Motion(action.inside("transfer"), "transfer", grasp, reason="to the pre-grasp"),
            Motion(
                action.inside("approach"),
                "linear",
                grasp,
                {"stage": Stage.POSE, "speed_m_s": speed, "paced": 1.0, "free_m_s": FREE},
                (patient,),
                "to the grasp",
            ),
            Motion(action.inside("close"), "gripper", grasp, close, reason=f"hold {action.roles['Patient'].entity}"),
            Motion(action.inside("payload"), "payload", reason="the arm now carries the object"),
        )
        away = Location(action.inside("away"), "retreat")
        back = Motion(action.inside("back"), "linear", away, {"stage": Stage.POSE}, (patient,), "clear of the thing")
        known = belief.poses.get(action.roles["Patient"].entity or "")
        # fingers may still be around what was let go; what was only seen is as unsure, but no finger is there
        if known and known.source.startswith("predicted") and 0 < known.sigma <= IN_PLACE:
            yield Decomposition((away, back, *steps), "straight back, then pre-grasp, straight approach, close")
        yield Decomposition(steps, "pre-grasp, straight approach, close on the object", 1.0)
        if _stopped_here(belief):
            yield Decomposition((away, back, *steps), "straight back from where the arm was stopped, then as above", 2.0)

    def begins_at(self, action: Action) -> Location:
        return grasp_of(action.roles["Patient"])


def _stopped_here(belief: Belief) -> bool:
    """Check whether the arm stands where an earlier run left it, as the known opening of its fingers shows: maybe among things."""
    mount = next(m for m in belief.world.robots if m.name == belief.robot)
    return mount.opening is not None and belief.joints == mount.joints


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Grasping()]
