"""Stance of one thing on another: whether a lid covers the vessel's opening, and how far a centre of mass
is inside of its support's border."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely

from cramlite.model import GRAVITY, Rollout, Thing, thing_of
from cramlite.plugin import Candidate

from ..shapes.bounds import centre_of_mass, lowest
from ..shapes.nesting import touching
from ..shapes.surfaces import footprint

LID = "soma:Lid"
ALONE = 0.9
"""Share of a thing's weight from which one support bears it alone: contact forces chatter by some per cent."""

GAP = 0.002
"""Largest part of an opening that a lid may leave uncovered [m]: things and their models differ by some millimetres."""
SHIFT, SHARE = 0.002, 0.05
"""Least distance of a centre of mass from its support's border [m], and the same as a share of the thing's extents: twins shift things
by 2 mm, and centres of mass by 5 % of the extents (``ErrorModel``)."""
SWINGS = 0.01
"""Swing of a hanging thing along its peg [m]: the amplitude of ``rest.SWING``."""
CONTACT = 0.01
"""Thickness of the slices of two things, above and below the height at which they meet, that count as in contact [m]: a thing may lean
by some degrees."""


def wrongly_rests(candidate: Candidate, thing: Thing, support: Thing) -> str:
    """Describe what is wrong with how a thing rests on another at the end of a run; "" if nothing
    is.

    A lid covers the opening that it lies on. What is stacked on a thing that can be moved has its centre of mass over that; on
    furniture, a thing may stand as it stands.

    Args:
        thing, support: where the run left them.
    """
    if candidate.taxonomy.any_is_a((thing.type,), LID):
        return uncovered(thing, support)
    stacked = not support.furniture and borne(candidate.ran, thing.name, support.name) > ALONE
    return unbalanced(thing, support) if stacked else ""


def borne(rollout: Rollout, thing: str, support: str) -> float:
    """Return the share of a thing's weight that another thing bears at the end of a run."""
    pairs = ((thing_of(t.a), thing_of(t.b), t.lift) for t in rollout.touches[-1])
    lift = sum(lift if b == thing else -lift for a, b, lift in pairs if {a, b} == {thing, support})
    weight = (rollout.world.thing(thing).mass or 0.0) * GRAVITY
    return lift / weight if weight else 0.0


def uncovered(lid: Thing, vessel: Thing) -> str:
    """Describe how much of a vessel's opening a lid leaves open; "" if the lid covers an opening, or the vessel has no opening.

    Args:
        lid, vessel: where they are, their z upwards.
    """
    over = footprint(lid, lid.pose)
    shares = [opening.buffer(-GAP).difference(over).area / opening.area for opening in _openings(vessel)]
    if not shares or min(shares) == 0.0:
        return ""
    return f"'{lid.name}' leaves {100 * min(shares):.0f} % of the opening of '{vessel.name}' uncovered"


def near_tip(thing: Thing, hanger: Thing) -> str:
    """Describe a thing that hangs too near to the tip of a peg; "" if it is far enough from the tip, or the
    peg's length is unknown.

    Args:
        thing, hanger: where they are; the peg's z leads to its tip.
    """
    hole, peg = thing.feature("vrps:Hole"), hanger.feature("vrps:Peg")
    if hole is None or peg is None or "length" not in peg.size:
        return ""
    length = peg.size["length"]
    along = float((hanger.pose * peg.pose).inverse().apply((thing.pose * hole.pose).position)[2])
    inside, least = length - along, min(SHIFT + SWINGS, length / 4)
    if inside >= least:
        return ""
    away = f"{1000 * inside:.0f} mm from the end of the peg of '{hanger.name}'"
    return f"'{thing.name}' hangs {away}, at least {1000 * least:.0f} mm are needed"


def _openings(vessel: Thing) -> Iterator[Any]:
    """Outlines of a vessel's openings, seen from above."""
    for feature in vessel.features:
        if feature.type == "cram:Cavity":
            there, size = vessel.pose * feature.pose, feature.size
            round_ = shapely.Point(0, 0).buffer(size.get("radius", 0.0))
            x, y = size["width"] / 2, size["depth"] / 2
            area = shapely.box(-x, -y, x, y) if round_.is_empty else round_
            yield shapely.transform(area, lambda points, at=there: at.apply(np.insert(points, 2, 0.0, axis=1))[:, :2])


def unbalanced(thing: Thing, support: Thing) -> str:
    """Describe a thing whose centre of mass is beyond its support's border, or too near to it; "" if it is far
    enough inside.

    Args:
        thing, support: where they are, their z upwards.
    """
    low = thing.pose.position[2] + lowest(thing, thing.pose)
    met = touching(thing, thing.pose, support, support.pose)  # what leans also rests on more than its lowest side
    own = footprint(thing, thing.pose, low, low + CONTACT).union(met).convex_hull
    under = footprint(support, support.pose, low - CONTACT, low + CONTACT).union(met).convex_hull
    both, centre = own.intersection(under), shapely.Point(thing.pose.apply(centre_of_mass(thing))[:2])
    inside, most = _depth(centre, both), _depth(centre, own)
    least = min(SHIFT + SHARE * _extent(own), most / 2)
    if inside >= least:
        return ""
    place = f"{1000 * abs(inside):.0f} mm {'inside' if inside >= 0 else 'outside'} of its support on '{support.name}'"
    return f"the centre of mass of '{thing.name}' is {place}, at least {1000 * least:.0f} mm inside are needed"


def _depth(point: Any, area: Any) -> float:
    """Distance of a point from the edge of an area [m], negative outside."""
    away = float(area.boundary.distance(point))
    return away if area.contains(point) else -away


def _extent(area: Any) -> float:
    """The longer side of the box around an area [m]."""
    x, y, x1, y1 = area.bounds
    return float(max(x1 - x, y1 - y))
