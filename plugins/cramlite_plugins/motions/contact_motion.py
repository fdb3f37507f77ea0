"""Force-controlled motions: compliant paths, motion until contact, spiral search, insertion, extraction, holding."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    GRAVITY,
    Belief,
    CompliantSlide,
    ErrorModel,
    ExpectedContact,
    Floats,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Held,
    Motion,
    MoveLinear,
    MoveUntilContact,
    Place,
    Pose,
    Remedy,
    SpiralSearch,
    Wait,
    ZeroSensor,
    enclosing_names,
    task_of,
    thing_of,
)
from cramlite.plugin import Answers, Context, Grounding, Unresolvable, hookimpl

from ..kinematics.timing import steady_speed
from ..motion_planning.cartesian import line
from ..shapes.carried_along import carried_along, driven, driven_before, pushed_along
from .free_motion import place_of
from .motion_kinds import KINDS, value, word
from .ontology_limits import adapted, known, noted
from .sprung import across, tangent, with_lever

Groundings = Iterator[Grounding]
Kind = Callable[[Motion, Belief, Context], Groundings]
DEEPER = 0.01  # than the surface below a place it goes, where that is more than ``beyond_m`` [m]: two sigma of a 5 mm estimate
GUARDED = 0.015  # before it expects to touch something a motion is slow [m]: three sigma of a 5 mm estimate
LEAST_GUARDED, SIGMAS = 0.002, 3.0  # of what is slow, for a robot that has a pace: in any case [m], and standard deviations of errors
COMPLIANT_SPEED = 0.02  # of compliant axes [m/s]; faster oscillates against a stiff peg in simulation
STIFF = 0.15, 0.35  # deviation limits of the other axes [m, rad]: documented, the controller stops beyond them
ON_THE_SPOT = 0.03  # [m]: about what is no farther away the hand only turns, and gives way across that axis
STRAIGHT = 0.01  # [rad]: of a path that turns less the hand goes straight, and forces do not grow with speed as on a hinge's arc
TURN = 0.25  # way of a radian [m]: at a speed given in m/s, controllers turn by so much for each metre
PATIENCE = 2.0, 3.0  # a time-out is the nominal time times the first plus the second [s]


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve force-controlled motions; None for other kinds."""
    kinds: Mapping[str, Kind] = {
        "force_path": _force_path, "until_contact": _until_contact, "zero_sensor": _zero, "hold": _hold,
        "spiral_search": spiral_search, "force_insert": force_insert, "force_extract": force_extract,
        "compliant_slide": _slide,
    }  # fmt: skip
    kind = kinds.get(motion.kind)
    return _known(kind, motion, belief, context) if kind else None


def _known(kind: Kind, motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a force-controlled motion: its parameters limited to what the things bear, and its position
    uncertainty added to the belief after it."""
    motion = adapted(motion, belief, context)
    for found in kind(motion, belief, context):
        after, widened = widen(motion, found.belief or belief)
        reason = "; ".join(filter(None, (found.reason + noted(motion), widened)))
        yield replace(found, belief=after, reason=reason)


def widen(motion: Motion, belief: Belief) -> tuple[Belief, str]:
    """Add the position uncertainty of a motion in contact to the held thing's pose in the hand; variances add."""
    added, held = KINDS[motion.kind].widens, belief.held
    if held is None or added == 0.0:
        return belief, ""
    sigma = math.hypot(held.sigma, added)
    said = f"the position of '{held.thing}' in the hand is uncertain by {1000 * sigma:.1f} mm now, by {1000 * held.sigma:.1f} mm before"
    return replace(belief, held=replace(held, sigma=sigma)), said


def _force_path(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a compliant motion along the path of a place, or a part of that path; the arm gives way across
    the path."""
    from ..motion_planning.reach import tcp

    place = place_of(motion, context)
    out = np.subtract(place.path[-1].position, tcp(belief, context).position)
    belief = driven_before(belief, place, out / np.linalg.norm(out)) if driven(place) else belief
    moved = belief
    if (way := place.carried.joint if place.carried else None) is not None and belief.held is None:
        belief, moved = _along(place.thing, belief, context), _with_joint_moved(place.thing, way, belief)
    elif way is not None and belief.held is not None and belief.held.thing != place.thing:
        belief, moved = with_lever(place.thing, belief, context), _with_joint_moved(place.thing, way, belief)
    elif belief.held is not None and (joint := belief.world.thing(belief.held.thing).joint) is not None and joint.spring:
        yield _against_spring(motion, place, belief, context)
        return
    first, last = (motion.parameters.get(name) for name in ("corner", "end"))
    path = place.path if first is None or last is None else place.path[first + 1 : last + 1]
    points = line(motion, belief, context, list(path))
    here = tcp(belief, context)
    corners = np.array([here.position, *(p.position for p in path)])
    legs = np.diff(corners, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    turned = np.array([a.rotate((a.inverse() * b).rotvec) for a, b in pairwise((here, *path))])
    turns = np.linalg.norm(turned, axis=1)
    ways = np.maximum(lengths, TURN * turns)
    straight = lengths.max() > ON_THE_SPOT * turns.max()
    frame = frame_along(legs[int(np.argmax(lengths))] if straight else turned[int(np.argmax(turns))])
    speed, limit = _along_legs(motion, float(ways.max()), float(turns.max()), context), value(motion, "force_limit_n")
    sprung = tangent(belief, context)
    frame = frame if sprung is None else across(sprung, frame)
    x, y, _ = frame.inverse().rotate((0.0, 0.0, carried(motion, belief)))  # 0 of what is on a joint
    step = ForceMove(
        path, frame, (sprung is None, True, False, False, False, False), (float(x), float(y), 0.0, 0.0, 0.0, 0.0),
        (COMPLIANT_SPEED, COMPLIANT_SPEED, STIFF[0], STIFF[1], STIFF[1], STIFF[1]), speed, limit,
        timeout(float(ways.sum()), speed), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * ways.sum():.0f} mm at {1000 * speed:.0f} mm/s, sideways compliant, abort over {limit:.0f} N"
    yield Grounding((step,), reason, 0.0, moved.moved(points[-1]), key="force path")


def _along_legs(motion: Motion, longest: float, turn: float, context: Context) -> float:
    """Speed along the legs of a path [m/s]. Where they turn, forces grow with it: there it is higher by the root of the robot's pace, and
    no higher than the longest leg reaches from rest to rest."""
    slow, pace = value(motion, "speed_m_s"), context.robot.pace if value(motion, "paced") else 1.0
    return pace * slow if turn < STRAIGHT else max(slow, min(math.sqrt(pace) * slow, math.sqrt(CORRECTION * longest)))


def _against_spring(motion: Motion, place: Place, belief: Belief, context: Context) -> Grounding:
    """Force-controlled motions, one for each leg of a path, that move a thing against the spring of its joint: the hand never gives way
    along the spring's pull."""
    from ..motion_planning.reach import tcp

    speed, limit = value(motion, "speed_m_s"), value(motion, "force_limit_n")
    steps, now = list[ForceMove](), belief
    for target in place.path:
        points, here = line(motion, now, context, [target]), tcp(now, context)
        metres, radians = here.distance(target)
        frame = frame_along(np.subtract(target.position, here.position))
        steps.append(ForceMove(
            (target,), frame, (True, True, False, False, False, False), (0.0,) * 6,
            (COMPLIANT_SPEED, COMPLIANT_SPEED, STIFF[0], STIFF[1], STIFF[1], STIFF[1]), speed, limit,
            timeout(max(metres, TURN * radians), speed), points[-1], origin=motion.name, comment=motion.reason,
        ))  # fmt: skip
        now = now.moved(points[-1])
    return Grounding(tuple(steps), f"{len(steps)} legs, against its spring, abort over {limit:.0f} N", 0.0, now, key="against a spring")


def _along(thing: str, belief: Belief, context: Context) -> Belief:
    """Belief in which a pushed thing and its content move with the hand, as if they were held."""
    from ..motion_planning.reach import tcp

    with_it = carried_along(belief, thing)
    return belief.grasped(Held(thing, tcp(belief, context).inverse() * belief.pose(thing), 0.0, carries=with_it))


def _with_joint_moved(thing: str, way: float, belief: Belief) -> Belief:
    """Belief in which a thing's joint has moved by a distance or an angle [m, rad] and has taken the
    thing's content along."""
    joint, known = belief.world.thing(thing).joint, belief.poses[thing]
    assert joint is not None
    there, with_it = joint.moved(known.pose, way), carried_along(belief, thing)
    poses = {thing: replace(known, pose=there, source="predicted: pushed")}
    poses |= {name: replace(e, pose=there * e.pose) for name, e in with_it.items()}
    return replace(belief, poses={**belief.poses, **poses})


def frame_along(axis: Floats) -> Pose:
    """Return a frame with z along an axis (3,); x up, unless the axis itself goes up."""
    upright = abs(axis[2]) > 0.9 * float(np.linalg.norm(axis))
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))


def carried(motion: Motion, belief: Belief) -> float:
    """Return the upward force that the compliant arm applies [N]: its load's weight, less the force that
    it shall press on a surface with."""
    held = belief.world.thing(belief.held.thing) if belief.held else None
    weight = GRAVITY * (held.mass or 0.0) if held is not None and held.joint is None else 0.0  # rails carry a drawer
    return weight - float(motion.parameters.get("press_n", 0.0))


def timeout(length: float, speed: float) -> float:
    """Return the time-out [s] of a motion of a length [m] at a speed [m/s]."""
    return float(math.ceil(PATIENCE[0] * length / speed + PATIENCE[1]))


def _slide(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve motion "slide": along a place's path, pressing down on the surface that the path lies on."""
    from ..motion_planning.reach import tcp

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(c.position for c in place.path)])
    length = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    speed, press = value(motion, "speed_m_s"), value(motion, "press_n")
    step = CompliantSlide(
        place.path, frame_along(np.array([0.0, 0.0, -1.0])), press, speed, value(motion, "lost_s"),
        value(motion, "force_limit_n"), timeout(length, speed), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * length:.0f} mm at {1000 * speed:.0f} mm/s, pressing with {press:.0f} N, abort over {step.force_limit:.0f} N"
    yield Grounding((step,), reason, 0.0, pushed_along(belief, place).moved(points[-1]), key="slide")


def _until_contact(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a guarded motion: from the present TCP pose towards the place, or a corner of its path, and a
    little beyond, until a contact is felt."""
    from ..motion_planning.reach import tcp

    place, here = place_of(motion, context), tcp(belief, context)
    corner = motion.parameters.get("corner")
    target = place.pose if corner is None else place.path[corner]
    way: Any = np.array(target.position) - np.array(here.position)
    long, (x, y, z) = float(np.linalg.norm(way)), way / np.linalg.norm(way)
    deeper = place.release.height_m if place.release and corner is None else 0.0
    free = max(long + _unguarded(motion, target, deeper, belief, context), 0.0) if value(motion, "free_m_s") else 0.0
    points = line(motion, belief, context, [target])
    before = _in_the_air(motion, belief, context, target, free * way / long) if free > GUARDED else ()
    distance = long - (free if before else 0.0) + max(value(motion, "beyond_m"), deeper + DEEPER if deeper else 0.0)
    pace = context.robot.pace if value(motion, "free_m_s") or value(motion, "paced") else 1.0
    speed, force = pace * value(motion, "speed_m_s"), value(motion, "force_n")
    expect: Any = word(motion, "expect", ExpectedContact, ExpectedContact.CONTACT).value
    step = MoveUntilContact(
        (float(x), float(y), float(z)), speed, force, distance, timeout(distance, speed),
        expect, points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"at most {1000 * distance:.0f} mm at {1000 * speed:.0f} mm/s until {force:.0f} N"
    yield Grounding((*before, step), reason, 0.0, belief.moved(points[-1]), key="until contact")


def _unguarded(motion: Motion, target: Pose, deeper: float, belief: Belief, context: Context) -> float:
    """Way beyond the target that a guarded motion goes through the air [m], negative if that ends before it. A robot at the usual pace does
    not go beyond it; a faster one is slow only where errors may have put the contact, which is expected ``deeper`` [m]."""
    if context.robot.pace <= 1.0:
        return min(deeper - GUARDED, 0.0)
    return deeper - min(GUARDED, LEAST_GUARDED + SIGMAS * _doubt(motion, target, belief, context))


def _doubt(motion: Motion, target: Pose, belief: Belief, context: Context) -> float:
    """Standard deviation of where a motion touches something [m]: of the place on what it may touch, and of the payload in the hand."""
    errors, held = context.errors or ErrorModel(), belief.held
    touched = {thing_of(str(context.bindings[n])) for n in motion.may_touch if n in context.bindings} & belief.poses.keys()
    known = [errors.sigma(n, math.dist(belief.pose(n).position, target.position)) for n in sorted(touched)]
    known += [belief.poses[n].sigma for n in sorted(touched)]
    known += [held.sigma, errors.sigma(held.thing, math.hypot(*held.tcp_to_thing.position))] if held else []
    return math.hypot(*known)


def _in_the_air(motion: Motion, belief: Belief, context: Context, target: Pose, way: Any) -> tuple[MoveLinear, ...]:
    """Motion before a guarded motion, along the part of its way that is free of contact; none if the hand or the payload is already near to
    something."""
    from ..motion_planning.reach import tcp

    there = replace(target, position=tuple(np.add(tcp(belief, context).position, way).tolist()))
    try:
        points = line(replace(motion, may_touch=()), belief, context, [there])
    except Unresolvable:
        return ()
    pace, slow, length = context.robot.pace, value(motion, "free_m_s"), float(np.linalg.norm(way))
    speed = steady_speed(context.robot, points, length, pace * slow, slow)
    comment = f"{motion.reason}, the part in the air"
    acceleration = pace * math.sqrt(pace) * CORRECTION
    return (MoveLinear(there, speed, acceleration, points[-1], origin=motion.name, comment=comment),)


def _zero(motion: Motion, belief: Belief, context: Context) -> Groundings:
    if context.robot.sensor is None:
        raise _blind(motion, context.robot.type)
    yield Grounding(
        (ZeroSensor(origin=motion.name, comment=motion.reason),), "tare the sensor standing still", key="zero"
    )


def _blind(motion: Motion, robot: str) -> Unresolvable:
    """Refusal of a motion that needs a force sensor, for a robot without one.

    No other grasp, place or path helps, only another way to do the tasks that ask for the motion.
    """
    task = task_of(motion.name)
    remedy = Remedy(
        "sensor",
        f"robot '{robot}' has no force-torque sensor, which {task} needs: if it has one, say where ('sensor: flange' beside the robot's "
        "'file'), else take a robot with one, or tasks that need none",
    )
    because = tuple(n for n in enclosing_names(motion.name) if n != motion.name)
    reason = f"robot '{robot}' has no force-torque sensor, which '{motion.name}' needs"
    return Unresolvable(reason, because, blocking=(), remedy=remedy)


def _hold(motion: Motion, belief: Belief, context: Context) -> Groundings:
    pace = context.robot.pace if value(motion, "paced") else 1.0
    step = Wait(value(motion, "duration_s") / pace, origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"stand still for {step.duration:.1f} s", key="hold")


CORRECTION = 0.25  # acceleration of the short way back to the path after a pull [m/s2]: as of motions that feel
# Where no ontology says anything of the hole (ontologies/motions.ttl has the same values, with their sources).
REACH, SHARE, PITCH = 0.008, 0.75, 0.0015


def spiral_search(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Search a hole on a spiral around the present position of the tool, pressing in the place's direction of
    approach.

    The pitch follows from the radial play of hole and peg.
    """
    place, p = place_of(motion, context), motion.parameters
    points = line(motion, belief, context, [place.path[int(p["corner"])]])
    assert place.fit is not None, f"motion '{motion.name}' needs a place on a peg"
    pitch, radius, why = _spiral(motion, place.fit.play_m, belief, context)
    speed, force = value(motion, "speed_m_s"), value(motion, "force_n")
    # length of an Archimedean spiral, to first order: pi radius^2 / pitch
    seconds = math.ceil(2 * math.pi * radius**2 / pitch / speed + 3)
    step = SpiralSearch(
        _towards(place.approach), force, pitch, radius, speed, value(motion, "advance_m"), value(motion, "force_limit_n"),
        float(seconds), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    shape = f"radius {1000 * radius:.0f} mm, pitch {1000 * pitch:.1f} mm for a play of {1000 * place.fit.play_m:.1f} mm"
    yield Grounding((step,), f"{shape}{why}, pressing with {force:.0f} N", 0.0, belief.moved(points[-1]), key="spiral")


def _spiral(motion: Motion, play: float, belief: Belief, context: Context) -> tuple[float, float, str]:
    """Pitch and radius of a spiral search [m] for the radial play of hole and peg [m], with the source of
    both; a task may state the radius."""
    hole = belief.feature(belief.held.thing, "vrps:Hole") if belief.held else None
    said = {
        name: known(hole.type if hole else "vrps:Hole", f"cram:{name}", context)
        for name in ("searchReach", "searchPitchPerPlay", "searchPitch")
    }
    reach, share, most = (k.value if k else d for k, d in zip(said.values(), (REACH, SHARE, PITCH), strict=True))
    radius, sources = value(motion, "radius_m"), dict.fromkeys(k.source.rpartition("[")[2] for k in said.values() if k)
    why = f" (from {', '.join(s.rstrip(']') for s in sources)})" if sources else ""
    return min(share * play, most), radius or max(reach - play, play), why


def force_insert(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Push the hole onto the peg by the depth that the place states.

    The tool starts at the corner of the path from which on the peg guides the hole.
    """
    place, p = place_of(motion, context), motion.parameters
    first, last = int(p["corner"]), int(p["end"])
    points = line(motion, belief, context, list(place.path[first + 1 : last + 1]))
    assert place.fit is not None, f"motion '{motion.name}' needs a place on a peg"
    depth, speed, force = place.fit.push_m, value(motion, "speed_m_s"), value(motion, "force_n")
    step = ForceInsert(
        _towards(place.approach), force, depth, speed, value(motion, "force_limit_n"), timeout(depth, speed), points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * depth:.0f} mm with {force:.0f} N, sideways compliant, abort over {step.force_limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="insert")


def force_extract(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Pull a thing's hole off a peg: the end of the place's path sets the distance, and the peg guides the thing."""
    from ..motion_planning.reach import tcp

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(c.position for c in place.path)])
    legs = np.diff(corners, axis=0)
    frame = frame_along(legs[int(np.argmax(np.linalg.norm(legs, axis=1)))])
    x, y, _ = frame.inverse().rotate((0.0, 0.0, carried(motion, belief)))
    way = float((corners[-1] - corners[0]) @ np.array(frame.rotate((0.0, 0.0, 1.0))))
    speed, force = value(motion, "speed_m_s"), value(motion, "force_n")
    step = ForceExtract(
        frame, force, (float(x), float(y)), way, speed, value(motion, "force_limit_n"), timeout(way, speed), points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    # The peg has led the tool aside; what comes next was planned from where the path ends, in the open.
    there = MoveLinear(
        place.path[-1], speed, CORRECTION, points[-1], origin=motion.name, comment="from where the peg led it"
    )  # fmt: skip
    reason = f"{1000 * way:.0f} mm with {force:.0f} N, sideways compliant, abort over {step.force_limit:.0f} N"
    yield Grounding((step, there), reason, 0.0, belief.moved(points[-1]), key="extract")


def _towards(axis: tuple[float, float, float]) -> Pose:
    """Frame with z along an axis, and x as far up as it can be."""
    upright = abs(axis[2]) > 0.9
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))
