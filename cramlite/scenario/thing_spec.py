"""Things of a scenario file: model, pose, random variation, and errors of the believed pose."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from ..base.quantities import Angle, Force, Length
from ..base.spec import Name, Spec
from .pose_spec import PoseSpec


class HangSpec(Spec):
    """Placement of a thing that hangs on a hanger's peg: distance from the peg's root, and rotation about the
    vertical."""

    hanger: str
    depth: Length
    yaw: Angle = 0.0


class ThingSpec(Spec):
    """Thing: its model, its pose, and the model's parameters under ``with``."""

    name: Name
    model: str
    type: str | None = None
    at: PoseSpec | None = None
    hangs_on: HangSpec | None = None
    max_grip_force: Force | None = Field(None, ge=0.1, le=1000)
    parameters: dict[str, Any] = Field({}, alias="with")

    @model_validator(mode="after")
    def _placed_once(self) -> ThingSpec:
        if (self.at is None) == (self.hangs_on is None):
            raise ValueError("a thing needs exactly one of 'at' and 'hangs_on'")
        return self


class VarySpec(Spec):
    """Random variation of a thing's position, yaw, model or parameters, drawn by the seed; seed 0 varies
    nothing.

    Drawn are a thing's position (uniform, each horizontal axis), its yaw, or parameters from a list.
    """

    thing: str
    position: Length = Field(0.0, ge=0.0)
    yaw: Angle = Field(0.0, ge=0.0)
    model: list[str] = Field(default_factory=list)
    parameters: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field({}, alias="with")


class UnknownErrorSpec(Spec):
    """Bound on the error of a thing's position in the real world; the belief does not contain this error.

    The thing is moved, with what hangs on it, by a vector that is drawn uniformly from the ball of radius
    ``position`` [m]; every seed has its own, seed 0 included. Belief, search and program are not told.
    """

    thing: str
    position: Length = Field(ge=0.0)


class LateSpec(Spec):
    """Thing whose pose the program asks for when it runs, with the tolerance around the planned pose."""

    thing: str
    position: Length = Field(ge=0.0)
    yaw: Angle = Field(0.0, ge=0.0)
