"""Filters of placements of a held thing: pure functions, each returns a reason with numbers, or nothing.

The cheap ones, which only compare shapes, are asked before the arm is; all work in the robot's base frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Pose, Release, Stage, Thing, Value, thing_of
from cramlite.plugin import Context, Refused

from ..kinematics.kinematics import inverse, reach_shortfall, why_no_inverse
from ..motion_planning.reach import collision_free_ik, shift
from ..motion_planning.space import refusal
from ..motion_planning.too_far import no_inverse
from ..motions.gripping import DROPPED, LET_GO
from ..shapes import ray_casting as rays
from ..shapes.bounds import box_around, centre_of_mass, support
from ..shapes.surfaces import FLAT, Surface, footprint, inset, standing
from .parameters import Where
from .too_little_room import taken_by, too_high, too_narrow

AS_LET_GO = Pose()
ASIDE = 0.02  # what is left of a thing is so by at least this [m]
SIDES: Mapping[str, tuple[int, float]] = {
    "left_of": (1, 1.0), "right_of": (1, -1.0), "behind": (0, 1.0), "in_front_of": (0, -1.0)
}  # fmt: skip
"""Axis of the robot's base and the sign of what lies on that side: x leads forwards, y to the left."""
OFF_WALLS = 0.008
"""Of an outline from the walls that it is let down between [m]: a streamed arm is up to 5 mm off its path."""
WELL_IN = 0.01  # of an origin from the edge of its region [m]: a thing that is let go shifts by a few millimetres
BELOW_TOP = 0.002  # of an origin at rest from the upper end of its region [m]: the judge of goals asks for half of that
LEVEL = 45.0  # of closing or approach direction from level, up to which something falls out of a hand [deg]: friction of 1 holds on less
SEEN = 0.5  # share of a thing that others may not hide


class Spot(Value):
    """Placement candidate: where the thing would be, and the TCP poses that bring it there.

    Args:
        height: of its lowest point above the target [m].
    """

    name: str
    thing: Pose
    pose: Pose
    before: Pose
    height: float


class Obstacle(Value):
    """What stands on a target.

    Args:
        name: of the thing.
        area: its outline with the gap around, in the frame of the target [m].
        top: how high it reaches over the target [m]: what is put there may stick out over it.
    """

    name: str
    area: Any
    top: float = math.inf


class Wanted(Value):
    """Placement request: the held thing, its target, and further constraints.

    Args:
        entity: what it is put on or in.
        target: the surface, or the opening of the cavity, in the base frame.
        scene: the planning scene.
        opened: the same with the fingers open, as they are when they have let go, the widest first.
        where: further constraints, by name (the keys of ``where`` in scenario files).
        obstacles: what stands there.
        depth: of a cavity [m].
        covers: what is over its opening.
        under: what it comes to rest on in its middle, where that is not level.
    lowered: the scene in which the held thing may touch that, and the hand may not.
        uneven: nothing of the target is level: what is put there has to come to rest of itself.
    """

    thing: Thing
    entity: str
    target: Surface
    belief: Belief
    context: Context
    scene: Any
    where: Where
    obstacles: tuple[Obstacle, ...] = ()
    depth: float = 0.0
    covers: tuple[Obstacle, ...] = ()
    opened: tuple[Any, ...] = ()
    under: Thing | None = None
    lowered: Any = None
    uneven: bool = False


Filter = Callable[[Spot, Wanted], "str | Refused"]
"""Objects with a reason, with what is in the way where it looked for that; "" where it does not object."""


def released(wanted: Wanted, height: float, opening: float | None = None, settles: Pose = AS_LET_GO) -> Release:
    """Return the release of a payload at a height over its target [m]: let fall into a cavity, or put down."""
    into = thing_of(wanted.entity) if wanted.depth else ""
    return Release(height, opening, settles, into, DROPPED if into else LET_GO)


def first_objection(spot: Spot, wanted: Wanted, filters: Mapping[str, Filter]) -> Refused | None:
    """Return which filter objects and why, how many passed before it, and what is in the way; None where none does.

    What stands on the target is blamed whenever nothing else is: it takes away positions that are not even looked at.
    """
    for passed, (name, objects) in enumerate(filters.items()):
        no = objects(spot, wanted)
        if no:
            why = no if isinstance(no, Refused) else refusal(no, blocking=standing_there(wanted))
            return replace(why, reason=f"not {name}: {why.reason}", check=name).of(spot.name, passed)
    return None


def standing_there(wanted: Wanted) -> tuple[str, ...]:
    """Return the names of what stands on a target, without the target itself, whose own shape goes along with it."""
    return tuple(n for n in dict.fromkeys(o.name for o in wanted.obstacles) if n != thing_of(wanted.entity))


def supported(spot: Spot, wanted: Wanted) -> str:
    """Check that the thing's centre of mass is above what of the surface it would touch."""
    local = wanted.target.pose.inverse() * spot.thing
    inside, least = inset(standing(wanted.thing, local), wanted.target.area)
    if inside >= least or _sunk(spot, wanted):
        return ""
    if not math.isfinite(inside):
        return f"nothing of '{wanted.entity}' would be under what it stands on"
    side = f"{-1000 * inside:.0f} mm beyond" if inside < 0 else f"only {1000 * inside:.0f} mm from"
    return f"its centre of mass would be {side} the edge of '{wanted.entity}'; {1000 * least:.0f} mm inside is needed"


def _sunk(spot: Spot, wanted: Wanted) -> bool:
    """Whether its centre of mass comes to rest below the rim of a hollow: however it lies there, it does not fall out."""
    hollow = wanted.under.feature("cram:Cavity") if wanted.under else None
    if wanted.under is None or hollow is None:
        return False
    centre = spot.thing.apply(centre_of_mass(wanted.thing)) - np.array([0.0, 0.0, spot.height])
    x, y, z = (wanted.belief.pose(wanted.under.name) * hollow.pose).inverse().apply(centre)
    half = [hollow.size.get("radius", hollow.size.get(name, 0.0) / 2) for name in ("width", "depth")]
    return bool(z < 0 and abs(x) < half[0] / 2 and abs(y) < half[1] / 2)


def clear(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that its outline, seen from above, is apart from those of what stands there, as far up as that reaches."""
    there = wanted.target.pose.inverse() * spot.thing
    foot = -support(wanted.thing, there, (0.0, 0.0, -1.0))  # it may still be above where it will stand
    for found in wanted.obstacles:
        outline = footprint(wanted.thing, there, high=foot + found.top)
        if (overlap := float(outline.intersection(found.area).area)) > 0:
            said = f"its outline would overlap that of '{found.name}' and the gap around it by {1e4 * overlap:.1f} cm2"
            return taken_by(said, wanted.thing.name, wanted.entity, found.name, overlap, standing_there(wanted))
    return ""


def inside(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that all of it is over the container's opening, and apart from its walls as far as there is room: what meets one on its way
    down leans."""
    outline = footprint(wanted.thing, wanted.target.pose.inverse() * spot.thing)
    (low, left, high, right), (x, y, x1, y1) = outline.bounds, wanted.target.area.bounds
    gap = min(OFF_WALLS, max(0.0, min(x1 - x - high + low, y1 - y - right + left) / 4))  # with half of the room to choose from
    if wanted.target.area.buffer(-gap).covers(outline):
        return ""
    if wanted.target.area.covers(outline):
        least = 1000 * wanted.target.area.boundary.distance(outline)
        return f"only {least:.0f} mm from the walls of '{wanted.entity}', {1000 * gap:.0f} mm is needed"
    out, across, room, side = max(
        (max(x - low, high - x1), high - low, x1 - x, "width"), (max(y - left, right - y1), right - left, y1 - y, "depth")
    )
    if out <= 0:
        return f"{1e4 * float(outline.difference(wanted.target.area).area):.1f} cm2 of it would be beside the opening of '{wanted.entity}'"
    said = f"{1000 * across:.0f} mm of it would stick out by {1000 * out:.0f} mm over the {1000 * room:.0f} mm {side} of '{wanted.entity}'"
    return too_narrow(said, wanted.thing.name, wanted.entity, out, standing_there(wanted))


def falls(spot: Spot, wanted: Wanted) -> str:
    """Check that what is let go of falls out of the hand, and stays neither on the lower finger nor on the palm."""
    fingers, ahead = (float(spot.pose.rotate(axis)[2]) for axis in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    for what, up in (("the lower finger", abs(fingers)), ("the palm below it", ahead)):
        if (steep := math.degrees(math.asin(max(-1.0, min(1.0, up))))) > LEVEL:
            return f"it would stay on {what}, since the hand is turned up by {steep:.0f} deg; up to {LEVEL:.0f} deg it falls"
    return ""


def falls_in(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that what is let go of falls into the container, and not onto what is between, such as the cabinet of a closed drawer."""
    belief, to = wanted.belief, wanted.target.pose.inverse()
    for name in (o.name for o in wanted.covers) if spot.height > 0 else ():
        between = footprint(belief.world.thing(name), to * belief.pose(name), 2 * FLAT, spot.height)
        if (overlap := float(footprint(wanted.thing, to * spot.thing).intersection(between).area)) > 0:
            said = f"'{name}' is over {1e4 * overlap:.1f} cm2 of it, between it and '{wanted.entity}': it would come to rest on that"
            return refusal(said, blocking=(name,))
    return ""


def in_region(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that its origin is over the region that is asked for, a little inside, since what is let go may shift, and no higher than
    that reaches."""
    if not (region := wanted.where.region):
        return ""
    x, y, z = (wanted.target.pose.inverse() * spot.thing).position
    at, area = shapely.Point(x, y), wanted.target.area
    by = float(area.boundary.distance(at)) if area.covers(at) else -float(area.distance(at))
    if by < WELL_IN:
        said = f"{-1000 * by:.0f} mm beside" if by < 0 else f"only {1000 * by:.0f} mm from the edge of"
        return f"its origin would be {said} '{region}'; {1000 * WELL_IN:.0f} mm inside is needed"
    feature = next(f for f in wanted.belief.thing(thing_of(wanted.entity)).features if f.name == region)
    over = 0.0 if wanted.depth else z - spot.height - feature.size.get("height", math.inf) + BELOW_TOP
    return too_high(wanted.thing.name, f"{thing_of(wanted.entity)}/{region}", feature.size["height"], over) if over > 0 else ""


def over_region(spot: Spot, wanted: Wanted) -> str:
    """Check that its origin is over the region that is asked for, which may lean: what comes to rest of itself shifts no more."""
    resting = np.asarray(spot.thing.position) - (0.0, 0.0, spot.height)
    at = shapely.Point(*wanted.target.pose.inverse().apply(resting)[:2])
    if not wanted.where.region or wanted.target.area.covers(at):
        return ""
    return f"its origin would be {1000 * wanted.target.area.distance(at):.0f} mm beside '{wanted.where.region}'"


def near(spot: Spot, wanted: Wanted) -> str:
    """Check that the placement is near another thing, from middle to middle, seen from above."""
    other = wanted.where.near
    if not other:
        return ""
    gap = math.dist(spot.thing.position[:2], wanted.belief.pose(other).position[:2])
    within = wanted.where.within
    return "" if gap <= within else f"{1000 * gap:.0f} mm from '{other}', up to {1000 * within:.0f} mm are near"


def beside(spot: Spot, wanted: Wanted) -> str:
    """Check that the placement is on the right side of other things, as the base looks: x forwards, y to the left."""
    for side, (axis, sign) in SIDES.items():
        other = getattr(wanted.where, side)
        if not other:
            continue
        by = sign * (spot.thing.position[axis] - wanted.belief.pose(other).position[axis])
        if by < ASIDE:
            said = side.replace("_", " ")
            return f"{1000 * by:.0f} mm {said} '{other}', at least {1000 * ASIDE:.0f} mm is needed"
    return ""


def room(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that there is room for the hand and the thing at the placement and above it, wherever the arm is; of what is out of reach that
    is left to be said."""
    base = wanted.belief.base()
    for pose, where in ((spot.before, Stage.BEFORE), (spot.pose, Stage.POSE)):
        no: Refused | None = None if reach_shortfall(wanted.context.robot, pose) else wanted.scene.met(base * pose)
        if no is not None:
            return _at(where, no)
    return ""


def _at(where: Stage, no: Refused) -> Refused:
    """A refusal that says where on the way to a placement it objects."""
    return replace(no, reason=f"{'above it' if where is Stage.BEFORE else 'at it'}: {no.reason}", where=where)


def reachable(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that inverse kinematics has solutions for the placement and its approach, whatever is in the way."""
    robot = wanted.context.robot
    for pose, where in ((spot.before, Stage.BEFORE), (spot.pose, Stage.POSE)):
        if not inverse(robot, pose, seed=wanted.belief.joints):
            return _at(where, refusal(why_no_inverse(robot, pose), blocking=standing_there(wanted), remedy=no_inverse(robot, pose)))
    return ""


def collision_free(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that arm and thing are free of collision at the placement and above it."""
    above = collision_free_ik(wanted.scene, wanted.context, spot.before, wanted.belief.joints)
    if isinstance(above, Refused):
        return _at(Stage.BEFORE, above)
    there = collision_free_ik(wanted.scene, wanted.context, spot.pose, above)
    return _at(Stage.POSE, there) if isinstance(there, Refused) else ""


def room_to_open(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the fingers can open where they let go: beside them there may be less room than around what they hold. What is put onto
    something is lowered before."""
    _, blocked = opened(spot, wanted)
    return replace(blocked, reason=f"with open fingers {blocked.reason}") if blocked else ""


def opened(spot: Spot, wanted: Wanted) -> tuple[Any, Refused | None]:
    """Return the first of the scenes with open fingers in which they have room; or None with what is in the way of the last."""
    low, blocked = spot.pose if wanted.depth else shift(spot.pose, (0.0, 0.0, -spot.height)), None
    for scene in wanted.opened:
        there = collision_free_ik(scene, wanted.context, low, wanted.belief.joints)
        if not isinstance(there, Refused):
            return scene, None
        blocked = there
    return None, blocked


def hand_off(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the thing comes to rest on what is not level before the hand meets that: fingers around a bowl's side reach below the rim
    of another one that it is put into."""
    if wanted.lowered is None:
        return ""
    there = collision_free_ik(wanted.lowered, wanted.context, shift(spot.pose, (0.0, 0.0, -spot.height)), wanted.belief.joints)
    return replace(there, reason=f"lowered {there.reason}") if isinstance(there, Refused) else ""


def visible(spot: Spot, wanted: Wanted) -> str:
    """Check that other things hide no more than half of it, and a camera looks its way."""
    asked = wanted.where.visible_from
    if asked is None:
        return ""
    eye, axis, field = _eye(asked, wanted)
    if eye is None:
        return "it cannot be said whether a camera sees it: none is fixed in the world; give 'visible_from' a point"
    points = spot.thing.apply(_grid(wanted.thing))
    middle = points.mean(axis=0) - eye
    off = math.acos(float(np.clip(middle @ axis / np.linalg.norm(middle), -1, 1))) if axis is not None else 0.0
    if off > field:
        return f"{math.degrees(off):.0f} deg off the camera's axis, it sees {math.degrees(field):.0f} deg to each side"
    others = (t for t in wanted.belief.world.things if t.name != wanted.thing.name)
    hidden, by = hidden_by(points, eye, wanted.belief, others)
    share = 1.0 - float(hidden.mean())
    if share >= SEEN:
        return ""
    return f"{100 * share:.0f} % of it is seen, {100 * SEEN:.0f} % is needed; '{by}' hides most"


def _grid(thing: Thing) -> Floats:
    """27 points in the box around a thing."""
    low, high = box_around(thing.geoms)
    shares = np.array([(x, y, z) for x in (0.1, 0.5, 0.9) for y in (0.1, 0.5, 0.9) for z in (0.1, 0.5, 0.9)])
    found: Floats = low + shares * (high - low)
    return found


def _eye(asked: Any, wanted: Wanted) -> tuple[Floats | None, Floats | None, float]:
    """Where the camera is and the way that it looks, if that is known, and how far to each side it sees [rad]."""
    base = wanted.belief.base().inverse()
    if asked != "camera":
        return base.apply(np.asarray(asked, dtype=float)), None, math.pi
    camera = wanted.context.camera
    if camera is None or camera.mount is not None:
        return None, None, 0.0
    pose = base * camera.pose
    return np.asarray(pose.position), pose.rotate((0.0, 0.0, 1.0)), camera.intrinsics.min_half_field_of_view


def hidden_by(points: Floats, eye: Floats, belief: Belief, others: Iterable[Thing]) -> tuple[Floats, str]:
    """Return the occlusion (n,) of points (n, 3) in the base frame from an eye (1 is hidden), and the main occluder."""
    hidden, counts = np.zeros(len(points)), dict[str, int]()
    for other in others:
        to = belief.pose(other.name).inverse()
        shape, start = rays.body(other.geoms), to.apply(eye)
        stopped = [rays.crossed(shape, start[None], to.apply(p)[None]) for p in points]
        counts[other.name] = sum(stopped)
        hidden = np.maximum(hidden, np.array(stopped, dtype=float))
    return hidden, max(counts, key=lambda n: counts[n], default="")


CHEAP: Mapping[str, Mapping[str, Filter]] = {
    "on": {"supported": supported, "clear": clear, "near": near, "beside": beside, "in its region": in_region},
    "at rest": {"near": near, "beside": beside, "over its region": over_region},
    "in": {"inside": inside, "falls": falls, "near": near, "beside": beside, "in its region": in_region},
}
"""Asked of the shapes alone, by relation; "at rest" on what is not level physics have said already what supports it."""
DEAR: Mapping[str, Filter] = {
    "free to fall": falls_in, "collision-free": room, "reachable": reachable, "visible": visible,
    "collision-free with the arm": collision_free, "free to open": room_to_open,
    "let down by the thing alone": hand_off,
}  # fmt: skip
"""Asked of the arm and the camera, in this order."""
