"""Parameters of locations: a class for each set of parameters, with a docstring line for each field."""

from __future__ import annotations

from typing import Literal, TypeVar

import msgspec

from cramlite.model import Location, ShownPath, Value, Vector3


class Where(Value):
    """Constraints on a placement, as scenarios write them under ``where``.

    Args:
        near, left_of, right_of, in_front_of, behind: another thing; sides are those of the robot's base,
            which looks along x.
        within: distance from ``near``, from middle to middle, seen from above [m].
        visible_from: "camera", or a point in the world [m].
        attitude: direction of the payload's z axis.
        facing: thing that the payload's front looks at, seen from above.
        region: feature of the reference object, a surface or a cavity.
    """

    near: str | None = None
    left_of: str | None = None
    right_of: str | None = None
    in_front_of: str | None = None
    behind: str | None = None
    within: float = 0.2
    visible_from: Literal["camera"] | Vector3 | None = None
    attitude: Literal["upright", "upside down"] | None = None
    facing: str | None = None
    region: str | None = None


class Back(Value):
    """Parameters of the relation "retreat": a way back of the hand.

    Args:
        straight: against the direction of the hand alone, as fingers around a bar come off it.
    """

    straight: bool = False


class Up(Value):
    """Parameters of locations with the relation "lift", which the hand reaches by a straight way up or down.

    Args:
        height_m: of the way; negative for down.
    """

    height_m: float


class Along(Value):
    """Parameters of relations whose path is a straight line of a given length.

    Args:
        distance_m: of the way.
    """

    distance_m: float


class Begun(Value):
    """Parameters of a location designator whose path begins at another location.

    Args:
        begin: name of the location where it begins.
    """

    begin: str


class Handle(Value):
    """Parameters of a grasp of a handle.

    Args:
        least: share of the joint's range that must be reached.
        most: share of it to which the thing must come back, where there is no "least".
        drives: whether what stands in the way may be driven along.
        lever: whether the handle is that of the thing's lever.
    """

    least: float | None = None
    most: float | None = None
    drives: bool = False
    lever: bool = False


class Front(Value):
    """Parameters of closed fingers in front of a thing that they push shut.

    Args:
        most: share of the joint's range to which the thing must come back.
    """

    most: float | None = None


class JointWay(Value):
    """Parameters of a path along a thing's joint.

    Args:
        share: of the joint's range; 0 for as far as the arm comes.
        ajar: share below which the way ends, at the most.
        turned: whether it is a knob or a switch that is turned.
        drives: whether what stands in the way is driven along; the place says how far.
        lever: whether it is the thing's lever that is turned: opened, so far that the thing can open to
            ``share``; closed, back.
    """

    share: float = 0.0
    ajar: float = 0.0
    turned: bool = False
    drives: bool = False
    lever: bool = False


class Turned(Value):
    """Parameters of a turn of a thing about its joint, from where it is.

    Args:
        turn: rotation vector in the thing's frame; what it has along the joint's axis counts [rad].
    """

    turn: Vector3


class InnerSide(Value):
    """Parameters of a hand that pushes a door open from its inner side.

    Args:
        least: share of the joint's range that must be reached.
        drives: whether what stands in the way may be driven along.
    """

    least: float
    drives: bool = False


class PushedThing(Value):
    """Parameters of a push of a flat thing.

    Args:
        region: surface feature to which it goes.
        within: distance from another thing [m]; pushes have no use for it.
        aside_m: distance to any side, in the place of a region.
        apart: opening of the fingers behind it, as a share of its width.
        inside: whether the fingers are in it, behind its rim.
        around: whether the way leads around what stands in it.
        begin: name of the location where the way begins; the hand's own place has none.
    """

    region: str = ""
    within: float = 0.2
    aside_m: float | None = None
    apart: float = 0.0
    inside: bool = False
    around: bool = False
    begin: str = ""


class Tilting(Value):
    """Parameters of the tilting of a vessel.

    Args:
        tilt_rad: angle of the tilt.
        height_m: of the lip over the other vessel's rim.
    """

    tilt_rad: float
    height_m: float


class Sight(Value):
    """Parameters of a viewpoint from which a camera sees things.

    Args:
        around: names of things in view, in the place of the reference object.
    """

    around: tuple[str, ...] = ()


class Followed(Value):
    """Parameters of a location that is a path shown in a demonstration.

    Args:
        path: of the payload's foot, about the reference object.
    """

    path: ShownPath


P = TypeVar("P", bound=Value)


def asked(location: Location, of: type[P]) -> P:
    """Return the parameters of a location."""
    return msgspec.convert(dict(location.parameters), of)
