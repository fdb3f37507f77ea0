"""Errors and proofs under doubt as files write them: only what differs from the defaults."""

from __future__ import annotations

from typing import Any

from msgspec.structs import replace
from pydantic import Field, model_validator

from ..base.quantities import Angle, Force, Length, Time
from ..base.spec import Spec
from ..model.error_model import ErrorModel, PoseError
from ..model.proof_doubts import MOST_TWINS, ProofDoubts
from ..model.sensor_errors import SensorErrors

FURTHEST, WIDEST, LATEST = 0.5, 3.2, 1.0
"""Errors of lengths [m], angles [rad] and times [s] beyond these are none: nothing would be where it is believed to be."""

STEEPEST = 0.2
"""Lean of furniture beyond this is none [rad]: what stands on it would slide at a friction of .2."""


class PoseErrorSpec(Spec):
    """Error of a pose: in position [m] and in angle [rad]."""

    position: Length = Field(default=0.0, ge=0, le=FURTHEST)
    angle: Angle = Field(default=0.0, ge=0, le=WIDEST)

    def error(self) -> PoseError:
        """Return the value."""
        return PoseError(self.position, self.angle)


class ThingErrorSpec(PoseErrorSpec):
    """Pose error of one thing."""

    thing: str


class ErrorSpec(Spec):
    """Keys of an error model (``cramlite.model.ErrorModel``); what is not written is as it was before."""

    position: Length | None = Field(default=None, ge=0, le=FURTHEST)
    angle: Angle | None = Field(default=None, ge=0, le=WIDEST)
    things: tuple[ThingErrorSpec, ...] = ()
    friction: float | None = Field(default=None, ge=0, lt=1)
    mass: float | None = Field(default=None, ge=0, lt=1)
    size: float | None = Field(default=None, ge=0, lt=0.5)
    centre: float | None = Field(default=None, ge=0, lt=0.5)
    lean: Angle | None = Field(default=None, ge=0, le=STEEPEST)
    gripper_force: float | None = Field(default=None, ge=0, lt=1)
    force_noise: Force | None = Field(default=None, ge=0)
    force_precision: Force | None = Field(default=None, ge=0)
    force_drift: float | None = Field(default=None, ge=0, le=1000)
    latency: tuple[Time, Time] | None = None
    kinematics: Length | None = Field(default=None, ge=0, le=FURTHEST)
    calibration: Angle | None = Field(default=None, ge=0, le=WIDEST)
    backlash: Angle | None = Field(default=None, ge=0, le=WIDEST)
    hand_eye: PoseErrorSpec | None = None
    scale: float | None = Field(default=None, ge=0, le=100)

    @model_validator(mode="after")
    def _in_order(self) -> ErrorSpec:
        if self.latency is not None and not 0 <= self.latency[0] <= self.latency[1] <= LATEST:
            raise ValueError(f"'latency' is the lowest and the highest delay, in this order, from 0 to {LATEST:g} s")
        return self

    def errors(self, before: ErrorModel, sensor: SensorErrors) -> ErrorModel:
        """Return an error model with what is written here changed.

        Args:
            before: what is not written.
            sensor: of the robot; what is not written of the sensor, unless ``before`` says it.
        """
        same = ("friction", "mass", "size", "centre", "lean", "gripper_force", "latency", "kinematics", "calibration", "backlash", "scale")
        changes: dict[str, Any] = {n: getattr(self, n) for n in same if getattr(self, n) is not None}
        pose = {n: v for n in ("position", "angle") if (v := getattr(self, n)) is not None}
        of_sensor = {n: v for n in ("noise", "precision", "drift") if (v := getattr(self, f"force_{n}")) is not None}
        if self.hand_eye is not None:
            changes["hand_eye"] = self.hand_eye.error()
        things = {**before.things, **{t.thing: t.error() for t in self.things}}
        return replace(
            before, pose=replace(before.pose, **pose), things=things, sensor=replace(before.sensor or sensor, **of_sensor), **changes
        )


class ProofSpec(Spec):
    """Doubts that programs must stand: how many twins, which share of all runs must succeed, and how far twins are off."""

    twins: int | None = Field(default=None, ge=0, le=MOST_TWINS)
    at_least: float = Field(default=ProofDoubts().at_least, ge=0, le=1)
    errors: ErrorSpec = ErrorSpec()
