"""Problem of placing a payload: the payload, its support or container, and the obstacles on it, in it and
over it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Held, Location, Pose, Release, Thing, Value, thing_of
from cramlite.plugin import Context, Refused, Unresolvable

from ...motion_planning.cartesian import interpolate
from ...motion_planning.planning_scene import PlanningScene
from ...motion_planning.reach import bound, held_pose, reference_pose, shift, uncertainty_margins, unfit
from ...motions.gripping import DROPPED, LET_GO, release_opening
from ...shapes.bounds import box_around, corners, height, near
from ...shapes.roofs import has_own_roof, roof_over, roofed, stands_under
from ...shapes.surfaces import FLAT, Surface, footprint, outline, stated_surface, surfaces
from ..parameters import Where, asked
from ..pinching.grips import SLACK, WIDE
from ..reached import Arm, Leg

PARTS, STRAIGHTEN = (0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0), (0.25, 0.5, 0.75)
"""Fractions of a straight way out, and of a turn on it, at which hand and payload have to be free of
collision before the arm is checked."""
# Gap between outlines seen from above, and around what is over an opening [m]: a little more than paths keep
GAP = 0.006
AS_LET_GO = Pose()


class Obstacle(Value):
    """Obstacle to a placement: a thing that stands on the target, lies in it or hangs over it.

    Args:
        name: of the thing.
        area: its outline with the gap around, in the frame of the target [m].
        top: how high it reaches over the target [m]: what is put there may stick out over it.
    """

    name: str
    area: Any
    top: float = math.inf


class Query(Value, dict=True):
    """Problem of placing a payload: its target, and all that constrains a placement.

    Args:
        thing: the payload.
        entity: what it is put on or in.
        target: the surface, or the opening of the cavity, in the base frame.
        arm: that brings it there.
        where: further constraints, as scenarios write them.
        obstacles: what stands on the target, or lies in it.
        depth: of a cavity [m]; 0 for a surface.
        covers: what is over the opening of a cavity.
        room: over a surface, under a roof [m].
        roof: name of the thing that has this roof; "" for the target's own thing.
        under: what the payload comes to rest on in its middle, where that is not level.
        uneven: nothing of the target is level: what is put there has to come to rest of itself.
        settles: whether the payload comes to rest on what is not level, where it alone may touch that.
        clearance: to everything else [m]; the planner's own by default.
    """

    thing: Thing
    entity: str
    target: Surface
    arm: Arm
    where: Where
    obstacles: tuple[Obstacle, ...] = ()
    depth: float = 0.0
    covers: tuple[Obstacle, ...] = ()
    room: float = math.inf
    roof: str = ""
    under: Thing | None = None
    uneven: bool = False
    settles: bool = False
    clearance: float | None = None

    @property
    def belief(self) -> Belief:
        """Return the belief."""
        return self.arm.belief

    @property
    def context(self) -> Context:
        """Return the context of the placing problem: robot, bindings, later tasks, seed and limits."""
        return self.arm.context

    @property
    def held(self) -> Held:
        """Return the name of the held thing with its pose in the hand and the opening of the fingers."""
        return self.belief.payload

    @property
    def whole(self) -> Thing:
        """Return the thing on or in which the payload is put; the target, a surface or an opening, is a
        part of it."""
        return self.belief.world.thing(thing_of(self.entity))

    @property
    def at(self) -> Pose:
        """Return the pose of the target's thing in the base frame."""
        return self.belief.pose(self.whole.name)

    @property
    def roofing(self) -> Thing:
        """Return the thing whose roof would be over the target: by default the target's own thing."""
        return self.belief.thing(self.roof) if self.roof else self.whole

    @cached_property
    def now(self) -> Pose:
        """Return the pose of the payload in the base frame."""
        return held_pose(self.belief, self.context)

    @cached_property
    def around(self) -> Thing:
        """Return one thing with the geoms of the target's thing and of all things near it, in the frame of
        the target's thing."""
        back, (low, high) = self.at.inverse(), box_around(self.whole.geoms)
        reach, geoms = float(np.linalg.norm(high - low)), list(self.whole.geoms)
        for name in self.belief.poses.keys() - {self.whole.name, self.thing.name}:
            to = back * self.belief.pose(name)
            near_it = ((g, to * g.pose) for g in self.belief.thing(name).geoms)
            geoms += [
                replace(g, pose=p)
                for g, p in near_it
                if math.dist(p.position, (low + high) / 2) < reach + g.bounding_radius
            ]
        return replace(self.whole, geoms=tuple(geoms), features=())

    @property
    def region(self) -> str:
        """Return the name of the target's region or feature where the payload is to be placed, or ""."""
        return self.where.region or EntityName.parse(self.entity).part

    @property
    def lowest(self) -> float:
        """Return the height over the target's face at which the region for the payload begins [m]."""
        return next((f.size.get("lowest", 0.0) for f in self.whole.features if f.name == self.region), 0.0)

    @property
    def scene(self) -> PlanningScene:
        """Return the planning scene."""
        return self.arm.scene(clearance=self.clearance)

    @cached_property
    def openings(self) -> tuple[float, ...]:
        """Return the openings of the fingers for a release [m], the widest first."""
        widest = release_opening(self.belief, self.context)
        more = (min(widest, self.held.opening + by) for by in (WIDE, SLACK)) if self.settles else ()
        return (widest, *more)

    def let_down(self, pose: Pose, opening: float | None = None) -> Leg:
        """Return the TCP pose to reach (``Leg``) at which the payload is released, with the fingers open by
        ``opening`` [m]; the payload may touch its support there."""
        touching = (thing_of(self.entity),) if self.settles else () if self.depth else (self.entity,)
        return Leg(pose, touching, opening, 0.0, hand=not self.settles)

    def hand(self, thing: Pose) -> Pose:
        """Return the TCP pose at which the held payload is at a given pose."""
        return thing * self.held.tcp_to_thing.inverse()

    def standing_there(self) -> tuple[str, ...]:
        """Return the names of the obstacles at the target, without the target's own thing."""
        return tuple(n for n in dict.fromkeys(o.name for o in self.obstacles) if n != thing_of(self.entity))

    def release(
        self, height: float, opening: float | None = None, settles: Pose = AS_LET_GO, falls: bool = True
    ) -> Release:
        """Return the release of the payload at a height over the target [m]: it falls into a cavity, or is
        let go of on a surface."""
        into = thing_of(self.entity) if self.depth and falls else ""
        return Release(height, opening, settles, into, DROPPED if into else LET_GO)


class Placement(Value):
    """Candidate of a placement: the payload's pose at its release, and the way of the hand to it from a
    stand-off outside.

    Args:
        name: for people; it also identifies the candidate.
        thing: the payload where it is let go of, in the base frame.
        pose, before: the TCP there, and at the stand-off in the open.
        height: of the payload's lowest point above the target [m].
        kind: of stable pose; it says which checks of the shapes there are.
        through: TCP poses on the way from the stand-off.
        led: whether hand and payload have to be free, and led by the arm, all the way; else at its two ends
            alone.
        lies: the payload where it comes to rest; the same as where it is let go of by default, or straight
            below.
        back: the TCP to which the hand goes back right after letting go; None where it need not.
        cost: as of groundings.
        aside: whether it is only worth a look where the way straight up is blocked.
        reorients: whether the payload is turned, so that it need not be kept as it is held.
        opens: whether the place says how far the fingers open.
        pushed: the payload where fingers push it after its release; None where they do not.
    """

    name: str
    thing: Pose
    pose: Pose
    before: Pose
    height: float
    kind: str = "on"
    through: tuple[Pose, ...] = ()
    led: bool = False
    lies: Pose | None = None
    back: Pose | None = None
    cost: float = 0.0
    aside: bool = False
    reorients: bool = False
    opens: bool = False
    pushed: Pose | None = None

    @property
    def rests(self) -> Pose:
        """Return the payload's pose in the end if it is known, else its pose at the release."""
        return self.pushed or self.lies or self.thing

    @property
    def begins(self) -> Pose:
        """Return the TCP pose at which the straight line from the stand-off ends, on the way to the
        placement."""
        return (*self.through, self.pose)[0]

    @property
    def way(self) -> list[tuple[Pose, float]]:
        """Return TCP poses on the way to the placement that must be checked for room, each with its distance
        from the placement [m]."""
        if not self.led:
            return [(self.before, 0.0), (self.pose, 0.0)]
        out = np.subtract(self.before.position, self.begins.position)
        far, turns = float(np.linalg.norm(out)), pairwise((self.pose, *reversed(self.through)))
        turning = [(interpolate(a, b, part), 0.0) for a, b in turns for part in (0.0, *STRAIGHTEN)]
        return turning + [(shift(self.begins, part * out), part * far) for part in PARTS]


Found = tuple[Query, Placement]
Groups = Iterator[Iterator[Found] | Refused]
"""Groups of candidate placements, best group first: one successful candidate of a group is enough, and a
group without candidates is a refusal."""


def queries(location: Location, belief: Belief, context: Context) -> list[Query]:
    """Return a placing problem for each place where the target could take the payload: an opening of a
    cavity, or a surface.

    Raises:
        Unresolvable: there is none, or nothing is held.
    """
    entity, into = bound(context, location.of), location.relation != "on"
    if belief.held is None:
        raise Unresolvable("the hand holds no payload that could be placed")
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    where = asked(location, Where)
    region = where.region or EntityName.parse(entity).part
    found = openings(thing, pose, region) if into else [(s, 0.0) for s in surfaces(thing, pose, region)]
    uneven = not into and not found and thing.furniture
    if uneven and (whole := stated_surface(thing, pose, region) if region else outline(thing, pose)):
        found = [(whole, 0.0)]
    if not found:
        what = "cavity to put anything in" if into else "level face that looks upwards, to put anything on"
        called = f", called {region!r}" if region else ""
        raise unfit(location, f"'{entity}' has no {what}{called}")
    held, arm = belief.world.thing(belief.held.thing), Arm(belief, context)
    bare = [Query(held, entity, s, arm, where, depth=d, uneven=uneven) for s, d in found]
    if into or uneven:
        return bare
    own = {s.pose: room for s, room in roofed(thing, pose, region)}
    if not own and (roof := roof_above(thing, belief)):
        x, y, _ = corners(thing, pose).mean(axis=0).tolist()
        middles = [(x, y, q.target.pose.position[2]) for q in bare]
        rooms = [roof_over(belief.thing(roof), belief.pose(roof), middle) for middle in middles]
        return [replace(q, room=room, roof=roof) for q, room in zip(bare, rooms, strict=True)]
    return [replace(q, room=own.get(q.target.pose, math.inf)) for q in bare]


def roof_above(thing: Thing, belief: Belief) -> str:
    """Return the name of the furniture under whose roof a movable thing stands, such as a microwave; "" if
    there is none."""
    others = [belief.thing(name) for name in sorted(belief.poses) if name != thing.name]
    fixed, pose = [t for t in others if t.furniture] if not thing.furniture else [], belief.pose(thing.name)
    return next((t.name for t in fixed if stands_under(thing, pose, t, belief.pose(t.name))), "")


def is_roofed(query: Query) -> bool:
    """Check whether all of a cavity is under a roof of its own thing."""
    return query.depth > 0 and has_own_roof(query.whole, query.at, query.region)


def openings(thing: Thing, pose: Pose, region: str = "") -> list[tuple[Surface, float]]:
    """Return the opening of a thing's cavity as a surface, with the cavity's depth [m]: the first cavity, or
    the named one."""
    cavity = next((f for f in thing.features if f.type == "cram:Cavity" and region in ("", f.name)), None)
    if cavity is None:
        return []
    size = cavity.size
    x, y = (size.get(name, math.inf) / 2 for name in ("width", "depth"))
    area = shapely.Point(0, 0).buffer(size["radius"]) if "radius" in size else shapely.box(-x, -y, x, y)
    return [(Surface(pose * cavity.pose, area), size["height"])]


def standing_on(query: Query) -> tuple[Obstacle, ...]:
    """Return the outlines of the obstacles that stand on a surface, or hang over it within the payload's
    height; each is widened by ``GAP`` and the uncertainty of its place."""
    belief, to, margins = query.belief, query.target.pose.inverse(), uncertainty_margins(query.belief)
    high, reach = height(query.thing, query.now), query.target.area
    found = []
    for name in belief.poses:
        area = footprint(belief.world.thing(name), to * belief.pose(name), 2 * FLAT, high)
        if not area.is_empty and area.distance(reach) < 2 * GAP + high:
            top = float(corners(belief.world.thing(name), to * belief.pose(name))[:, 2].max()) + GAP
            found.append(Obstacle(name, area.buffer(GAP + margins.get(name, 0.0)), top))
    return tuple(found)


def lying_in(query: Query, sure: bool = False) -> tuple[Obstacle, ...]:
    """Return the outlines of a cavity's contents, widened by ``GAP`` and, unless ``sure``, by the uncertainty
    of their places."""
    belief, to, found = query.belief, query.target.pose.inverse(), []
    margins = {} if sure else uncertainty_margins(belief)
    for name in belief.poses:
        area = footprint(belief.world.thing(name), to * belief.pose(name), -query.depth, 0.0)
        if not area.is_empty and query.target.area.covers(area):
            found.append(Obstacle(name, area.buffer(GAP + margins.get(name, 0.0))))
    return tuple(found)


def covers(query: Query, high: float) -> tuple[Obstacle, ...]:
    """Return the outlines of the things over an opening, up to the height of a release [m]; each is widened
    by ``GAP``.

    What reaches through the opening lies in it, and covers nothing.
    """
    return tuple(sorted(_over(query, high), key=lambda o: o.name))


def _over(query: Query, high: float) -> Iterator[Obstacle]:
    belief, to, area = query.belief, query.target.pose.inverse(), query.target.area
    for name in belief.poses.keys() - {thing_of(query.entity), query.thing.name}:
        thing, there = belief.world.thing(name), to * belief.pose(name)
        if near(thing, there, area.bounds):
            seen = footprint(thing, there, 2 * FLAT, high)
            if seen.intersects(area) and not footprint(thing, there, -FLAT, 0.0).intersects(area):
                yield Obstacle(name, seen.buffer(GAP))
