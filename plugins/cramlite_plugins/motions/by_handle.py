"""The steps of moving a drawer or a door by its handle, which tasks that differ in the way have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cramlite import Action, Decomposition, Location, Motion


def handle_of(action: Action) -> Location:
    """Where the hand takes the patient."""
    patient = action.roles["Patient"].name
    return Location(f"handle({patient})", "handle", patient)


def by_handle(action: Action, way: Location, stroke: str, values: Mapping[str, Any]) -> Decomposition:
    """Hold the handle, follow the joint, let go.

    Args:
        way: where the joint leads.
        stroke: name of the motion along it.
        values: the task's parameters speed_m_s, force_n and force_limit_n.
    """
    patient, handle = action.roles["Patient"], handle_of(action)
    limits = {k: values[k] for k in ("speed_m_s", "force_limit_n")}
    close = {"to": "closed", "expect": "object", "force_n": values["force_n"]}
    touch, back = (patient.name,), Location(action.inside("away"), "retreat")
    steps = (
        handle,
        Motion(action.inside("open"), "gripper", handle, {"to": "place"}, reason="wider than the handle"),
        Motion(action.inside("transfer"), "transfer", handle, reason="in front of the handle"),
        Motion(action.inside("approach"), "linear", handle, {"stage": "pose"}, touch, "around the handle"),
        Motion(action.inside("close"), "gripper", handle, close, reason="hold the handle"),
        way,
        Motion(action.inside(stroke), "force_path", way, limits, touch, f"the way that {patient.entity} moves"),
        Motion(action.inside("release"), "gripper", None, {"to": "open", "expect": "none"}, reason="let go"),
        back,
        Motion(action.inside("back"), "linear", back, {"stage": "pose"}, touch, "clear of the handle"),
    )
    return Decomposition(steps, "hold the handle, follow the joint, let go")
