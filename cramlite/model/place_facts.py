"""Facts about what the hand does at a place: grip of a thing, release of a payload, things pushed or pulled, a hole put on a peg."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import field

from ..base.value import Value
from .geometry import Pose


class GripFacts(Value):
    """Grip of the hand on a thing at a grasp pose, with the distance between the pads.

    Args:
        width_m: between the pads.
    """

    width_m: float


class Release(Value):
    """Release of a payload at a place.

    Args:
        height_m: of its lowest point over what carries it there.
        opening_m: of the fingers when they let go; None for as wide as they were on the way to the payload.
        settles: from where it is let go of to the attitude in which it comes to rest, in its own frame.
        into: thing into which it falls; "" where it is put down.
        sigma_m: standard deviation of where it comes to rest.
    """

    height_m: float
    opening_m: float | None = None
    settles: Pose = Pose()
    into: str = ""
    sigma_m: float = 0.0


class CarriedAlong(Value):
    """Movement of a thing that the hand pushes or pulls, and of others that this thing pushes ahead.

    Args:
        pushed_m: of the place's thing, straight on along the approach.
        joint: of the place's thing, along its joint [m, rad]; None where it has none.
        driven_m: another thing -> way on which the place's thing drives it before it.
        to_m: x and y in the base frame of where the place's thing shall come; None where nobody says so.
    """

    pushed_m: float = 0.0
    joint: float | None = None
    driven_m: Mapping[str, float] = field(default_factory=dict)
    to_m: tuple[float, float] | None = None


class PegFit(Value):
    """Fit of a hole on a peg.

    Args:
        play_m: radial play.
        push_m: way from the tip to where the hole comes to be.
        feet: what the peg stands on: a thing that is led down to its root may touch that.
    """

    play_m: float
    push_m: float
    feet: tuple[str, ...] = ()
