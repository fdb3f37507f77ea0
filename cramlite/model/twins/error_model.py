"""Error model: how far the real cell, in which a program will run, may differ from the believed one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, TypeVar, get_type_hints

from msgspec import field
from msgspec.structs import fields, replace

from ...base.value import Value
from ..sensor_errors import SensorErrors
from .error_sources import (
    FURTHEST,
    LATEST,
    STEEPEST,
    WIDEST,
    ErrorSource,
    Size,
    rubbing,
    rubbing_pads,
    weighing,
    with_backlash,
    with_centres,
    with_grip,
    with_latency,
    with_links,
    with_sensor,
    with_zeros,
)

M = TypeVar("M", bound="ErrorModel")


class PoseError(Value):
    """Error of a pose: a shift, uniform in a ball of radius ``position`` [m], and a turn of at most ``angle`` [rad].

    The turn is uniform between minus and plus ``angle``.
    """

    position: float = 0.0
    angle: float = 0.0

    def sigma(self, away: float) -> float:
        """Return the standard deviation [m], along any axis, of the position of a point ``away`` [m] from the centre of the turn.

        The turn may be about any axis, uniform in a ball as the shift: of both a fifth of the squared radius is the variance.
        """
        return math.sqrt((self.position**2 + (self.angle * away) ** 2) / 5)


class ErrorModel(Value):
    """Errors that are declared for a robot cell; the errors of its twins are drawn from them.

    A field declares its source (``ErrorSource``): how files write it, how it is drawn and applied. Where things are, and how large, is
    drawn for all of them at once (``cramlite.scenario.twin_places``).

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
        lean: of every thing that is fixed, about a horizontal axis through its base [rad]; what it carries leans with it. The floor that a
            platform drives on is level with its robot. 1 deg, a choice: what is set up without a spirit level.
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

    pose: Annotated[PoseError, ErrorSource(
        "poses", 1, nothing=PoseError(),
        keys={"position": ("position", Size("length", FURTHEST)), "angle": ("angle", Size("angle", WIDEST))},
    )] = PoseError(0.002, math.radians(1.0))  # fmt: skip
    things: Annotated[Mapping[str, PoseError], ErrorSource("poses", 1, nothing={})] = field(default_factory=dict)
    friction: Annotated[float, ErrorSource("friction", 3, Size("share", 1), thing=rubbing, world=rubbing_pads)] = 0.5
    mass: Annotated[float, ErrorSource("mass", 9, Size("share", 1), thing=weighing)] = 0.2
    size: Annotated[float, ErrorSource("size", 5, Size("share", 0.5))] = 0.01
    centre: Annotated[float, ErrorSource("centre", 4, Size("share", 0.5), world=with_centres)] = 0.05
    lean: Annotated[float, ErrorSource("lean", 2, Size("angle", STEEPEST))] = math.radians(1.0)
    gripper_force: Annotated[float, ErrorSource("gripper force", 10, Size("share", 1), world=with_grip)] = 0.1
    sensor: Annotated[SensorErrors | None, ErrorSource(
        "force sensor", 7, nothing=SensorErrors(0.0, 0.0, 0.0), world=with_sensor,
        keys={"force_noise": ("noise", Size("force")), "force_precision": ("precision", Size("force")),
              "force_drift": ("drift", Size("rate", 1000))},
    )] = None  # fmt: skip
    latency: Annotated[
        tuple[float, float], ErrorSource("latency", 8, Size("time", LATEST), nothing=(0.0, 0.0), world=with_latency)
    ] = (0.008, 0.024)
    kinematics: Annotated[float, ErrorSource("arm", 6, Size("length", FURTHEST), world=with_links)] = 0.0003
    calibration: Annotated[float, ErrorSource("arm", 6, Size("angle", WIDEST), world=with_zeros)] = math.radians(0.02)
    backlash: Annotated[float, ErrorSource("arm", 6, Size("angle", WIDEST), world=with_backlash)] = math.radians(1 / 60)
    hand_eye: Annotated[PoseError, ErrorSource("hand-eye", 11, nothing=PoseError())] = PoseError(0.003, math.radians(0.5))
    scale: float = 1.0

    def scaled(self, factor: float) -> ErrorModel:
        """Return the error model with every error ``factor`` times as large."""
        return replace(self, scale=self.scale * factor)

    def of(self, thing: str) -> PoseError:
        """Return the declared pose error of a thing, not yet multiplied by ``scale``."""
        return self.things.get(thing, self.pose)

    def sigma(self, thing: str, away: float) -> float:
        """Return the standard deviation [m], along any axis, of the position of a point of a thing ``away`` [m] from where it stands.

        Errors of pose, lean and size. Along an axis a disc's variance is a quarter of its squared radius, a range's a third.
        """
        variance = self.of(thing).sigma(away) ** 2 + (self.lean * away) ** 2 / 4 + (self.size * away) ** 2 / 3
        return self.scale * math.sqrt(variance)

    def only(self, source: str) -> ErrorModel:
        """Return the error model with the errors of one source only.

        Raises:
            KeyError: ``SOURCES`` has no such source.
        """
        kept: dict[str, Any] = {name: getattr(self, name) for name in sources(type(self))[source]}
        return replace(without_errors(type(self)), scale=self.scale, **kept)


@cache
def declared(model: type[ErrorModel]) -> Mapping[str, ErrorSource]:
    """Return the source of error that each field of an error model declares, in the order in which the errors
    of a twin are drawn."""
    hints = get_type_hints(model, include_extras=True)
    found = {f.name: source for f in fields(model) for source in getattr(hints[f.name], "__metadata__", ())}
    return dict(sorted(found.items(), key=lambda kv: kv[1].rank))


def sources(model: type[ErrorModel]) -> Mapping[str, tuple[str, ...]]:
    """Return the names of the sources of error of an error model, each with the fields that declare it."""
    found: dict[str, tuple[str, ...]] = {}
    for name, source in declared(model).items():
        found[source.name] = (*found.get(source.name, ()), name)
    return found


def without_errors(model: type[M]) -> M:
    """Return an error model of a type with all errors at zero."""
    nothing: dict[str, Any] = {name: source.nothing for name, source in declared(model).items()}
    return model(**nothing)


SOURCES = sources(ErrorModel)
"""Sources of error -> the fields of ``ErrorModel`` that belong to each; those that break programs most often stand first."""
NO_ERRORS = without_errors(ErrorModel)
"""Error model without any error: its twins are the believed world."""
