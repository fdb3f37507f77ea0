"""Checks in simulation of how a payload comes to rest that is let go of in another pose than it stands in."""

from __future__ import annotations

import math

import shapely
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite.plugin import Refused

from ....kinematics.inverse import inverse
from ....motion_planning.reach import shift
from ....shapes.bounds import centre_of_mass
from ....shapes.standing_up import stood_up
from ....shapes.surfaces import footprint
from ....simulation.resting import rests
from ..query import Placement, Query
from .hand import room
from .shapes import near, region_missed

STANDS = math.radians(3.0)  # what leans by no more has come to stand
OFF_PATH = 0.004  # how far beside its place what is let go may be [m]: where an arm has arrived


def rests_there(placement: Placement, query: Query) -> str | Refused:
    """Check in simulation that a payload which is released leaning, or dropped, comes to rest in the
    opening or at its place, wherever it is released nearby; what is let down onto a movable thing, near that
    thing."""
    if placement.kind == "on" and query.under:
        return stays(placement, query)
    there = placement.kind == "dropped"
    if placement.lies is None or placement.kind not in ("in", "dropped"):
        return ""
    below = query.around if there else query.whole
    for end in rests(query.thing, placement.thing, below, query.at, OFF_PATH, there):
        if no := (_astray(end, query) if there else _leaning(end, query)):
            return no
    return ""


def stays(placement: Placement, query: Query) -> str:
    """Check in simulation that a payload which is let down onto a movable thing, such as the knob of a lid,
    stays on it, and near the thing that it shall be near, wherever it is let down nearby."""
    assert query.under is not None
    for end in rests(query.thing, placement.thing, query.under, query.at, OFF_PATH):
        if end is None:
            return f"'{query.thing.name}' may fall off '{query.entity}' when it is released"
        if no := near(replace(placement, lies=end), query):
            return f"released, it may come to rest {no}"
    return ""


def _leaning(end: Pose | None, query: Query) -> str:
    """Reason why a payload at rest does not stand in an opening; "" if it does."""
    stands = end is not None and end.distance(stood_up(query.thing, end))[1] <= STANDS
    if end and stands and query.target.area.covers(footprint(query.thing, query.target.pose.inverse() * end)):
        return ""
    return f"'{query.thing.name}' may come to rest in another pose than standing when it is released"


def at_rest(placement: Placement, query: Query) -> Placement:
    """Return the placement of a dropped payload, completed by its simulated rest pose if it has one.

    Unchanged if there is no room for it, or the arm does not reach the pose of its release.
    """
    if room(placement, query) or not inverse(query.context.robot, placement.pose, seed=query.belief.joints):
        return placement  # checks say so
    return replace(
        placement,
        lies=next(rests(query.thing, placement.thing, query.around, query.at, OFF_PATH, there=True)),
    )


def dropped(placement: Placement, query: Query) -> str | Refused:
    """Check that a payload which is released in another pose than it stands in comes to rest at its place."""
    if placement.kind != "dropped" or (placement.lies is None and room(placement, query)):
        return ""
    return _astray(placement.lies, query)


def _astray(end: Pose | None, query: Query) -> str | Refused:
    """Say why a payload would come to rest at a wrong place; "" if the place is right.

    Its origin must be in the wanted region, or, where no region is wanted, its centre of mass over the
    target.
    """
    if end is None:
        return "it may come to rest nowhere near"
    to = query.target.pose.inverse() * end
    if query.where.region:
        sunk = query.depth and not -query.depth <= to.position[2] <= 0.0
        return (
            "its origin comes to rest above or below its region" if sunk else region_missed(end, 0.0, query)
        )
    centre = shapely.Point(*to.apply(centre_of_mass(query.thing))[:2])
    return "" if query.target.area.covers(centre) else f"it comes to rest beside '{query.entity}'"


def lying_there(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload has room at its rest pose, however it was released."""
    lying = shift(placement.rests, (0.0, 0.0, placement.height))
    no: Refused | None = query.scene.met(query.belief.base() * query.hand(lying), False)
    return no or ""
