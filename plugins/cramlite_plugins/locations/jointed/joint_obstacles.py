"""Motion of a drawer or a door along its joint, and the obstacles that it would meet; the hand is left
out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Held, Pose, Thing
from cramlite.plugin import Context, Refused, checkpoint

from ...motion_planning.reach import make_scene
from ...motion_planning.space import all_of
from ...shapes.bounds import lowest
from ...shapes.carried_along import carried_along, gone_along
from ...shapes.surfaces import standing

STEPS = 0.005, math.radians(1.0)  # between the values of a joint that are looked at [m, rad]
AHEAD = 0.005  # step of the ways on which a drawer meets a thing [m]
LEVEL = 0.1  # what a drawer drives along must not be lifted or pressed down: sine of the slope
# How high a thing is over what it stands on while it is driven along [m]: resting contacts are some
# hundredths of a millimetre deep
OVER = 0.002


def met_on_its_way(
    thing: Thing, value: float, goal: float, belief: Belief, context: Context
) -> Refused | None:
    """Return the refusal of a thing's motion along its joint from a value to a goal [m, rad]: it states the
    first obstacle of the thing and its payload, and lists all obstacles as blocking.

    None if the way is free, or if something touches the thing already, since planned paths then judge better.
    """
    assert thing.joint is not None
    met = _met(thing, value, goal, belief, context)
    if not met:
        return None
    gone, first = min(met.items(), key=lambda found: found[0])
    far = f"{1000 * gone:.0f} mm" if thing.joint.kind == "slide" else f"{math.degrees(gone):.0f} deg"
    said = f"after {far} of its own motion {first.reason}"
    return replace(first, reason=said, blocking=all_of(met.values()))


def _met(thing: Thing, value: float, goal: float, belief: Belief, context: Context) -> dict[float, Refused]:
    """Return the refusals by obstacles on a thing's way along its joint, keyed by the distance after which it
    meets them [m, rad].

    The result is empty if something touches the thing at the start.
    """
    assert thing.joint is not None
    joint, now, way = thing.joint, belief.pose(thing.name), goal - value
    count = max(1, math.ceil(abs(way) / STEPS[joint.kind == "hinge"]))
    poses = [belief.base() * joint.moved(now, way * k / count) for k in range(count + 1)]
    met = {abs(way) * k / count: no for k, no in enumerate(_met_at(poses, thing.name, belief, context)) if no}
    return {} if 0.0 in met else met


def _met_at(
    poses: Sequence[Pose], name: str, belief: Belief, context: Context, touch: Iterable[str] = ()
) -> list[Refused | None]:
    """Return at each of several poses in the world the refusal with the obstacle that a thing and its load
    meet there, or None; the thing counts as absent from its present pose."""
    held = Held(name, Pose(), 0.0, carries=carried_along(belief, name))
    scene = make_scene(belief.grasped(held), context, touch, clearance=0.0)

    def met(there: Pose) -> Refused | None:
        checkpoint()
        return scene.met(there, hand=False)

    return [met(there) for there in poses]


def driven_along(
    thing: Thing, value: float, goal: float, belief: Belief, context: Context
) -> Mapping[str, float] | Refused:
    """Return the distance by which a level drawer pushes each loose thing ahead of it between two joint
    values [m]; {} if it pushes none.

    A refusal if one would be pushed into another thing or out of its container, or tip over.
    """
    assert thing.joint is not None
    found, after, line = dict[str, float](), belief, _direction(thing, goal - value, belief)
    while met := _met(thing, value, goal, after, context):
        gone, first = min(met.items(), key=lambda one: one[0])
        names = first.in_the_way
        if thing.joint.kind != "slide" or abs(line[2]) > LEVEL or not names or names & found.keys():
            return first
        if inside := next((name for name in sorted(names) if belief.relates("in", name)), ""):
            said = f"'{inside}' is in '{belief.relates('in', inside)}', and not pushed out of it"
            return replace(first, reason=f"{first.reason}; {said}")
        if tips := next((name for name in sorted(names) if _tips(name, thing, line, after)), ""):
            return replace(first, reason=f"{first.reason}; pushed along, '{tips}' would tip over")
        found |= dict.fromkeys(names, abs(goal - value) - gone + AHEAD)
        for name in names:
            after = gone_along(after, name, line * found[name])
    along = (thing.name, *found)
    into = (_driven_into(name, line * way, along, belief, after, context) for name, way in found.items())
    return next((no for no in into if no), None) or found


def _tips(name: str, driver: Thing, line: Floats, belief: Belief) -> bool:
    """Whether a thing that is pushed by the lower edge of a drawer tips over before it slides."""
    it, pose = belief.world.thing(name), belief.pose(name)
    bottom, at = pose.position[2] + lowest(it, pose), belief.pose(driver.name)
    height = max(at.position[2] + lowest(driver, at) - bottom, 0.0)
    foot = standing(it, pose)
    ahead = (shapely.get_coordinates(foot.area) - shapely.get_coordinates(foot.centre)) @ line[:2]
    rough = max((g.friction for g in it.geoms if g.friction is not None), default=it.friction)
    return bool(rough * height > max(float(ahead.max(initial=0.0)), 0.0))


def _direction(thing: Thing, way: float, belief: Belief) -> Floats:
    """Unit vector (3,) in the base frame along which a thing moves on its sliding joint."""
    assert thing.joint is not None
    now = belief.pose(thing.name)
    axis: Floats = np.asarray((now * thing.joint.pose).rotate((0.0, 0.0, math.copysign(1.0, way))))
    return axis


def _driven_into(
    name: str, way: Floats, along: tuple[str, ...], begin: Belief, end: Belief, context: Context
) -> Refused | None:
    """Return the refusal if a thing that a drawer drives along its support hits something; None if it does
    not.

    Things that move along are left out. ``way`` is the displacement (3,) in the base frame [m].
    """
    start, line = begin.poses[name].pose, np.asarray(begin.base().rotate(way))
    count = max(1, math.ceil(float(np.linalg.norm(way)) / STEPS[0]))
    ways = (np.asarray(start.position) + (0.0, 0.0, OVER) + line * k / count for k in range(1, count + 1))
    poses = [Pose.at(point, start) for point in ways]
    no = next((no for no in _met_at(poses, name, end, context, along) if no), None)
    return no and replace(no, reason=f"'{name}', pushed along, would be {no.reason}")
