"""The error model: how far the cell that a program will run in may be from the one that is believed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from msgspec import field
from msgspec.structs import replace

from ..base.value import Value
from .sensor_errors import SensorErrors


class PoseError(Value):
    """Error of a pose: in position [m], uniform in a ball of this radius; in angle [rad], uniform in plus or minus."""

    position: float = 0.0
    angle: float = 0.0


class ErrorModel(Value):
    """Declared errors of a cell; worlds that are drawn from it are twins.

    Each number is the half-width of a uniform distribution, but for the noise of the sensor, a standard deviation. The defaults are
    choices, with the measured numbers that they were made from; a scenario changes any of them.

    Args:
        pose: of each thing that ``things`` does not name. 2 mm and 1 deg: what is measured with a tape, or set against a stop.
        things: by name.
        friction: share of every thing's friction and of the pads' (0.5 is plus or minus 50 %); each is drawn by itself. Rubber on
            smooth solids was measured between .25 and 1.0: a range, never a value.
        mass: share of every thing's mass.
        size: share of the size of every thing that is free; furniture keeps its own. 1 %, a choice: guides to printed plastics give .1 to
            1 % of shrinkage.
        centre: of mass of every thing that is free, as a share of the box around it, along each of its sides. 5 %, a choice: a shape does
            not say what is in it.
        lean: of every thing that is fixed, about a horizontal axis through its base [rad]; what it carries leans with it. 1 deg, a choice:
            what is set up without a spirit level.
        gripper_force: share of the grip force. 10 %: none is published.
        sensor: of the force-torque sensor; None for what the robot declares.
        latency: lowest and highest delay between a measurement and what a program does about it [s]. 8 to 24 ms: one to three
            cycles of a controller at 125 Hz.
        kinematics: how far the flange is off where the errors of all links add up [m]. 0.3 mm, of a calibrated arm.
        calibration: error of each joint's zero [rad]. 0.02 deg: 0.3 mm at a reach of 0.85 m.
        backlash: width of each joint's play [rad]. 1 arc minute, as catalogues of strain wave gears have it at most.
        hand_eye: of a camera in the hand or beside it; it moves all that was seen, together. 3 mm and 0.5 deg: users of D435-class
            cameras report 1.1 to 5 mm and 0.66 deg.
        scale: multiplies every number.
    """

    pose: PoseError = PoseError(0.002, math.radians(1.0))
    things: Mapping[str, PoseError] = field(default_factory=dict)
    friction: float = 0.5
    mass: float = 0.2
    size: float = 0.01
    centre: float = 0.05
    lean: float = math.radians(1.0)
    gripper_force: float = 0.1
    sensor: SensorErrors | None = None
    latency: tuple[float, float] = (0.008, 0.024)
    kinematics: float = 0.0003
    calibration: float = math.radians(0.02)
    backlash: float = math.radians(1 / 60)
    hand_eye: PoseError = PoseError(0.003, math.radians(0.5))
    scale: float = 1.0

    def scaled(self, factor: float) -> ErrorModel:
        """Return the model with every number ``factor`` times as large."""
        return replace(self, scale=self.scale * factor)

    def of(self, thing: str) -> PoseError:
        """Return the pose error of a thing, without ``scale``."""
        return self.things.get(thing, self.pose)

    def only(self, source: str) -> ErrorModel:
        """Return the model without the errors of all other sources.

        Raises:
            KeyError: ``SOURCES`` has no such source.
        """
        kept: dict[str, Any] = {name: getattr(self, name) for name in SOURCES[source]}
        return replace(NO_ERRORS, scale=self.scale, **kept)


NO_ERRORS = ErrorModel(
    pose=PoseError(), friction=0.0, mass=0.0, size=0.0, centre=0.0, lean=0.0, gripper_force=0.0, sensor=SensorErrors(0.0, 0.0, 0.0),
    latency=(0.0, 0.0), kinematics=0.0, calibration=0.0, backlash=0.0, hand_eye=PoseError(),
)  # fmt: skip
"""What is drawn from it is the believed world itself."""

SOURCES: Mapping[str, tuple[str, ...]] = {
    "poses": ("pose", "things"), "friction": ("friction",), "arm": ("kinematics", "calibration", "backlash"),
    "force sensor": ("sensor",), "latency": ("latency",), "mass": ("mass",), "gripper force": ("gripper_force",),
    "hand-eye": ("hand_eye",), "size": ("size",), "centre": ("centre",), "lean": ("lean",),
}  # fmt: skip
"""Sources of error -> the fields of ``ErrorModel`` that belong to each; those that break programs most often stand first."""
