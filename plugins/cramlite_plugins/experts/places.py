"""Where to bring the hand or what it holds: into a container, onto a surface, along a peg, away, up, home."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from cramlite import Answers, Belief, Context, Grounding, Location, Place, Pose, Refused, Thing, Unresolvable, hookimpl

Found = Iterator[Grounding | Refused]
YAWS = (
    0.0,
    30.0,
    -30.0,
    60.0,
    -60.0,
    90.0,
    -90.0,
    135.0,
    -135.0,
    180.0,
)  # turns about the vertical that are tried [deg]
DEPTHS = (-0.08, -0.05, -0.02, 0.01, 0.04)  # lowest point of a held thing above a container's rim when let go [m]
ABOVE = 0.06  # stand-off above a rim or surface [m]
CLEAR = 0.04  # past a peg's tip before a pull ends [m]
BACK = (0.12, 0.08, 0.05)  # retreat distances that are tried [m]


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    finders: Mapping[str, Callable[[Location, Belief, Context], Found]] = {
        "home": _home, "retreat": _retreat, "lift": _lift, "in": _inside, "on": _onto,
        "extract": _extract, "insert": _insert, "slide": _slide,
    }  # fmt: skip
    finder = finders.get(location.relation)
    return finder(location, belief, context) if finder else None


def _home(location: Location, belief: Belief, context: Context) -> Found:
    from cramlite_plugins.motions.kinematics import forward

    pose = forward(context.robot, context.robot.home)
    yield Grounding(Place(pose, pose), f"the home position of '{context.robot.type}'", key="home")


def _retreat(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import tcp

    here = tcp(belief, context)
    ways = [("back", here.turn((0, 0, -1))), ("up", np.array([0.0, 0.0, 1.0]))]
    options = [(f"{d * 1000:.0f} mm {way}", _shift(here, v * d)) for way, v in ways for d in BACK]
    yield from _reachable(options, belief, context, cost=0.1)


def _lift(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import tcp

    height = float(location.parameters["height_m"])
    options = [(f"{h * 1000:.0f} mm up", _shift(tcp(belief, context), (0, 0, h))) for h in (height, height * 0.6)]
    yield from _reachable(options, belief, context, cost=0.1)


def _reachable(options: list[tuple[str, Pose]], belief: Belief, context: Context, cost: float) -> Found:
    """Options whose end is reachable and free, in order."""
    from .reach import make_scene, stance

    scene = make_scene(belief, context)
    for k, (name, pose) in enumerate(options):
        there = stance(scene, context, pose, belief.joints)
        if isinstance(there, str):
            yield Refused(name, there)
        else:
            yield Grounding(Place(pose, pose, approach=(0, 0, 1)), name, cost * k, key=name)


def _inside(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import bound

    container = belief.thing(bound(context, location.of))
    cavity = container.feature("cram:Cavity")
    if cavity is None:
        raise Unresolvable(f"'{container.name}' has no cavity to put anything into", (location.of or "",))
    opening = belief.pose(container.name) * cavity.pose
    yield from _set_down(belief, context, opening, DEPTHS, f"into '{container.name}'", (location.of or "",))


def _onto(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import bound

    surface = _surface(belief, bound(context, location.of))
    yield from _set_down(
        belief, context, surface, (0.02,), f"onto '{bound(context, location.of)}'", (location.of or "",)
    )


def _surface(belief: Belief, entity: str) -> Pose:
    """The upward face that an entity is or has."""
    feature = belief.feature(entity, "vrps:SurfaceFeature")
    if feature is None:
        raise Unresolvable(f"'{entity}' has no surface")
    return belief.pose(entity.split("/")[0]) * feature.pose


def _set_down(
    belief: Belief, context: Context, target: Pose, heights: tuple[float, ...], where: str, because: tuple[str, ...]
) -> Found:
    """Held things above ``target``: every yaw, every height, the lowest first; hand and thing must be free."""
    from .reach import held_pose, make_scene, stance, tcp

    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    scene, thing = make_scene(belief, context), belief.world.thing(belief.held.thing)
    now, hand = held_pose(belief, context), tcp(belief, context)
    bottom, best = lowest(thing, now), ""
    facing = math.atan2(target.position[1], target.position[0]) - math.atan2(hand.position[1], hand.position[0])
    for yaw in YAWS:
        turn = Pose.from_rotvec((0, 0, 0), (0, 0, facing + math.radians(yaw)))
        for k, height in enumerate(heights):
            centre = (*target.position[:2], target.position[2] + height - bottom)
            thing_pose = Pose(centre, (turn * Pose((0, 0, 0), now.quaternion)).quaternion)
            pose = thing_pose * belief.held.tcp_to_thing.inverse()
            name = f"{where} turned {yaw:+.0f} deg, {1000 * height:+.0f} mm from the rim"
            before = _shift(pose, (0, 0, ABOVE - height if height < ABOVE else ABOVE))
            place = _both(scene, context, pose, before, belief, stance)
            if isinstance(place, str):
                best = best or place
                yield Refused(name, place)
                continue
            values = {"height_m": height, "floor_z_m": target.position[2]}
            cost = abs(math.radians(yaw)) * 0.1 + k * 0.02
            yield Grounding(
                Place(pose, before, approach=(0, 0, -1), thing=thing.name, values=values), name, cost, key=name
            )
            break


def _both(scene: Any, context: Context, pose: Pose, before: Pose, belief: Belief, stance: Any) -> str | None:
    above = stance(scene, context, before, belief.joints)
    if isinstance(above, str):
        return f"above it: {above}"
    there = stance(scene, context, pose, above)
    return f"at it: {there}" if isinstance(there, str) else None


def lowest(thing: Thing, pose: Pose) -> float:
    """How far the lowest point of a thing is below (negative) its origin, at this orientation [m]."""
    reach = []
    for geom in thing.geoms:
        down = (Pose((0, 0, 0), pose.quaternion) * geom.pose).rotation[2]
        centre = float(pose.turn(geom.pose.position)[2])
        half = geom.size if geom.shape == "box" else (geom.size[0], geom.size[0], sum(geom.size))
        reach.append(centre - float(np.abs(down) @ np.array(half)))
    return min(reach)


def _extract(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import held_pose, tcp

    peg, offset, tip, up = _peg(belief, context, location, held_pose(belief, context))
    length, sunk = peg["length"], max(peg["slack"] - offset[1], 0.0)
    if not 0 <= offset[0] <= length:
        raise Unresolvable(
            f"the hole is {1000 * offset[0]:.0f} mm along a peg of {1000 * length:.0f} mm: not on it",
            _causes(location, belief),
        )
    axis = np.array(peg["axis"])
    shifts = [up * sunk]
    shifts.append(shifts[-1] + axis * (length - offset[0]))
    shifts.append(shifts[-1] + tip)
    shifts.append(shifts[-1] + axis * CLEAR)
    yield from _traverse(
        location,
        belief,
        context,
        tcp(belief, context),
        shifts,
        f"{1000 * (length - offset[0]):.0f} mm along the peg, over its tip",
    )


def _insert(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import held_pose, tcp

    peg, _, tip, _ = _peg(belief, context, location, held_pose(belief, context))
    axis, here = np.array(peg["axis"]), tcp(belief, context)
    depth = min(peg["length"] * 0.5, 0.06)
    root_to_hole = np.array(peg["hole"]) - np.array(peg["root"])
    start = axis * (peg["length"] + CLEAR) + tip - root_to_hole
    shifts = [start, start - axis * CLEAR, start - axis * CLEAR - tip, start - axis * (CLEAR + depth) - tip]
    yield from _traverse(location, belief, context, here, shifts, f"over the tip, {1000 * depth:.0f} mm along the peg")


def _peg(belief: Belief, context: Context, location: Location, thing: Pose) -> tuple[dict[str, Any], Any, Any, Any]:
    """The peg, (how far along it the hole is, how far below it), the way over its bent tip, and up."""
    from .reach import bound

    assert belief.held is not None
    entity = bound(context, location.of)
    owner = belief.thing(entity)
    peg, tip = owner.feature("vrps:Peg"), owner.feature("vrps:Tip")
    hole = belief.world.thing(belief.held.thing).feature("vrps:Hole")
    if peg is None or hole is None:
        raise Unresolvable(f"'{entity}' has no peg or '{belief.held.thing}' no hole", _causes(location, belief))
    slack = hole.size["diameter"] / 2 - peg.size["radius"]
    if slack <= 0.0003:
        raise Unresolvable(
            f"a hole of {1000 * hole.size['diameter']:.1f} mm does not move on a peg of {2000 * peg.size['radius']:.1f} mm",
            _causes(location, belief),
        )
    root = belief.pose(owner.name) * peg.pose
    axis, up = root.turn((0, 0, 1)), np.array([0.0, 0.0, 1.0])
    centre = (thing * hole.pose).position
    delta = np.array(centre) - np.array(root.position)
    end = (
        np.array((belief.pose(owner.name) * tip.pose).position) - root.apply((0, 0, peg.size["length"]))
        if tip
        else np.zeros(3)
    )
    numbers = {"length": peg.size["length"], "slack": slack, "axis": axis, "root": root.position, "hole": centre}
    return numbers, (float(delta @ axis), float((delta @ up) + slack)), end, up


def _slide(location: Location, belief: Belief, context: Context) -> Found:
    from .reach import tcp

    distance = float(location.parameters["distance_m"])
    here = tcp(belief, context)
    for angle in (0.0, 180.0, 90.0, -90.0):
        way = distance * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0])
        yield from _traverse(
            location, belief, context, here, [way], f"{1000 * distance:.0f} mm at {angle:.0f} deg", angle / 90
        )


def _traverse(
    location: Location, belief: Belief, context: Context, here: Pose, shifts: list[Any], name: str, cost: float = 0.0
) -> Found:
    """A path of translations of the TCP; every corner must be reachable."""
    from .reach import bound, make_scene, stance

    scene = make_scene(belief, context, [bound(context, location.of)])
    path = tuple(_shift(here, s) for s in shifts)
    seed = belief.joints
    for k, pose in enumerate(path, 1):
        there = stance(scene, context, pose, seed)
        if isinstance(there, str):
            raise Unresolvable(f"corner {k} of {len(path)} of '{name}': {there}", _causes(location, belief, context))
        seed = there
    yield Grounding(Place(path[0], path[0], path=path, thing=bound(context, location.of)), name, abs(cost), key=name)


def _causes(location: Location, belief: Belief, context: Context | None = None) -> tuple[str, ...]:
    """A path from where the hand is depends on how the thing is held, and on what it moves along."""
    grasps = tuple(k for k in (context.bindings if context else {}) if k.startswith("grasp("))
    return (*grasps, location.of or "") if context else ()


def _shift(pose: Pose, by: Any) -> Pose:
    return Pose(tuple(np.asarray(pose.position) + np.asarray(by)), pose.quaternion)
