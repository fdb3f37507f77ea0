"""soma:Closing: close a drawer or a door by its handle."""

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


class Closing(TaskType):
    task = "soma:Closing"
    aliases = ("Close", "CloseContainer")
    roles = (Role("Patient", features=("cram:Handle",)),)
    summary = "close a drawer or a door by its handle"
    parameters = (
        Parameter("speed_m_s", 0.05, "slow enough to stop within a millimetre, ISO 10218 reduced speed is 0.25"),
        Parameter("force_n", 50.0, "as for grasping"),
        Parameter("force_limit_n", 25.0, "rails of 1 N and damping of 5 N s/m took under 10 N in simulation"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(f"the gripper already holds '{belief.held.thing}'", because=(EARLIER_TASKS,))
        patient, handle = action.roles["Patient"], self.begins_at(action)
        way = Location(f"closed({patient.name})", "closed", patient.name)
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")}
        close = {"to": "closed", "expect": "object", "force_n": self.parameter(action, "force_n")}
        touch, back = (patient.name,), Location(action.inside("away"), "retreat")
        steps = (
            handle,
            Motion(action.inside("open"), "gripper", handle, {"to": "place"}, reason="wider than the handle"),
            Motion(action.inside("transfer"), "transfer", handle, reason="in front of the handle"),
            Motion(action.inside("approach"), "linear", handle, {"stage": "pose"}, touch, "around the handle"),
            Motion(action.inside("close"), "gripper", handle, close, reason="hold the handle"),
            way,
            Motion(action.inside("push"), "force_path", way, force, touch, f"the way that {patient.entity} moves"),
            Motion(action.inside("release"), "gripper", None, {"to": "open", "expect": "none"}, reason="let go"),
            back,
            Motion(action.inside("back"), "linear", back, {"stage": "pose"}, touch, "clear of the handle"),
        )
        yield Decomposition(steps, "hold the handle, follow the joint, let go")

    def begins_at(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"handle({patient})", "handle", patient)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Closing()]
