"""Sliding along a surface in contact, which the tasks that slide the gripper and what it holds have in common."""

from __future__ import annotations

from typing import ClassVar

from cramlite import Action, Decomposition, Location, Motion, Parameter, TaskType


class Sliding(TaskType):
    """A task that slides along its relatum; a subclass says what slides."""

    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("distance_m", 0.08, "a short stroke; scenarios say what they need"),
        Parameter("speed_m_s", 0.02, "at 20 mm/s and less inertia does not look like contact"),
        Parameter("press_n", 12.0, "keeps contact in simulation; 3 N bounced for up to 1.2 s, 8 N for 0.1 s"),
        Parameter("force_limit_n", 25.0, "as for extraction; a free stroke stays below 17 N"),
    )

    def slide(self, action: Action) -> Decomposition:
        """Zero the sensor, then a stroke that presses and follows the surface."""
        surface, far = action.roles["Relatum"], {"distance_m": self.parameter(action, "distance_m")}
        way = Location(action.inside("slide"), "slide", surface.name, far)
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "press_n", "force_limit_n")}
        tare = Motion(action.inside("tare"), "zero_sensor", reason="from here on, more is pressing")
        stroke = Motion(action.inside("stroke"), "compliant_slide", way, force, (surface.name,), f"along {surface.entity}")
        return Decomposition((way, tare, stroke), "straight stroke that follows the surface")
