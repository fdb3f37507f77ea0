"""Errors and proofs under doubt as files write them: only what differs from the defaults."""

from __future__ import annotations

from typing import Annotated, Any

from msgspec.structs import replace
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ..base.quantities import Angle, Force, Length, Time
from ..model.error_model import ErrorModel, PoseError
from ..model.proof_doubts import MOST_TWINS, ProofDoubts
from ..model.sensor_errors import SensorErrors

Offset = Annotated[Length, Field(ge=0, le=0.5)]
Turn = Annotated[Angle, Field(ge=0, le=3.2)]
Part = Annotated[float, Field(ge=0, lt=1)]


class _Spec(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class PoseErrorSpec(_Spec):
    """Error of a pose: in position [m] and in angle [rad]."""

    position: Offset = 0.0
    angle: Turn = 0.0

    def error(self) -> PoseError:
        """Return the value."""
        return PoseError(self.position, self.angle)


class ThingErrorSpec(PoseErrorSpec):
    """Pose error of one thing."""

    thing: str


class ErrorSpec(_Spec):
    """Keys of an error model (``cramlite.model.ErrorModel``); what is not written is as it was before."""

    position: Offset | None = None
    angle: Turn | None = None
    things: tuple[ThingErrorSpec, ...] = ()
    friction: Part | None = None
    mass: Part | None = None
    gripper_force: Part | None = None
    force_noise: Annotated[Force, Field(ge=0)] | None = None
    force_precision: Annotated[Force, Field(ge=0)] | None = None
    force_drift: Annotated[float, Field(ge=0, le=1000)] | None = None
    latency: tuple[Annotated[Time, Field(ge=0, le=1)], Annotated[Time, Field(ge=0, le=1)]] | None = None
    kinematics: Offset | None = None
    calibration: Turn | None = None
    backlash: Turn | None = None
    hand_eye: PoseErrorSpec | None = None
    scale: Annotated[float, Field(ge=0, le=100)] | None = None

    @model_validator(mode="after")
    def _in_order(self) -> ErrorSpec:
        if self.latency is not None and self.latency[0] > self.latency[1]:
            raise ValueError("'latency' is the lowest and the highest delay, in this order")
        return self

    def errors(self, before: ErrorModel, sensor: SensorErrors) -> ErrorModel:
        """Return an error model with what is written here changed.

        Args:
            before: what is not written.
            sensor: of the robot; what is not written of the sensor, unless ``before`` says it.
        """
        same = ("friction", "mass", "gripper_force", "latency", "kinematics", "calibration", "backlash", "scale")
        changes: dict[str, Any] = {n: getattr(self, n) for n in same if getattr(self, n) is not None}
        pose = {n: v for n in ("position", "angle") if (v := getattr(self, n)) is not None}
        of_sensor = {n: v for n in ("noise", "precision", "drift") if (v := getattr(self, f"force_{n}")) is not None}
        if self.hand_eye is not None:
            changes["hand_eye"] = self.hand_eye.error()
        things = {**before.things, **{t.thing: t.error() for t in self.things}}
        return replace(
            before, pose=replace(before.pose, **pose), things=things, sensor=replace(before.sensor or sensor, **of_sensor), **changes
        )


class ProofSpec(_Spec):
    """Doubts that programs must stand: how many twins, which share of all runs must succeed, and how far twins are off."""

    twins: Annotated[int, Field(ge=0, le=MOST_TWINS)] | None = None
    at_least: float = Field(default=ProofDoubts().at_least, ge=0, le=1)
    errors: ErrorSpec = ErrorSpec()
