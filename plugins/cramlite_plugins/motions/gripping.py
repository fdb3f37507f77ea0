"""Gripper motions, and motions that set the payload in the controller of the arm."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    Estimate,
    ExpectedGrip,
    Fingers,
    Gripper,
    Held,
    Motion,
    Place,
    Pose,
    Robot,
    SetGripper,
    SetPayload,
    enclosing_names,
    thing_of,
)
from cramlite.plugin import Answers, Context, Grounding, hookimpl  # fmt: skip

from ..predicates.motion import OPENED
from ..shapes.bounds import lowest
from ..shapes.carried_along import carried_along
from ..shapes.surfaces import resting_height
from .free_motion import place_of
from .grip_force import grip_force, grip_of, load, overload
from .motion_kinds import value, word

Groundings = Iterator[Grounding]
PADS_SPEED = 0.10  # of the gripper's pads [m/s]: mid-range of the 2F-85's 20 to 150 mm/s, the most of a Franka Hand
LET_GO, DROPPED = 0.005, 0.1  # standard deviation of where a released thing is, in place and fallen [m]


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motions "gripper" and "payload"; None for other kinds."""
    if motion.kind == "payload":
        return _payload(motion, belief, context)
    if motion.kind == "gripper":
        closed = word(motion, "to", Fingers) is Fingers.CLOSED
        return _close(motion, belief, context) if closed else _open(motion, belief, context)
    return None


def _close(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a gripper motion that closes on the thing at a place; the thing moves with the hand from
    then on."""
    from ..motion_planning.reach import tcp

    place, gripper = place_of(motion, context), context.robot.gripper
    width = place.grip.width_m if place.grip else 0.0
    held = Held(
        place.thing, place.swing.start if place.swing else tcp(belief, context).inverse() * belief.pose(place.thing), width,
        carries=carried_along(belief, place.thing), swing=place.swing,
    )  # fmt: skip
    grip, is_it = grip_of(held, belief.world, gripper), _names_of(place.thing, context)
    asked, within = value(motion, "force_n"), tuple(enclosing_names(motion.name))
    force, why = grip_force(grip, asked, context, is_it, within, value(motion, "most_n") or math.inf)
    expect: Any = word(motion, "expect", ExpectedGrip, ExpectedGrip.ANY).value
    comment = "; ".join(filter(None, (motion.reason, why)))
    step = SetGripper(gripper.opening[0], _speed(context.robot), force, expect, origin=motion.name, comment=comment)
    lifted = belief.unrelated("on", place.thing).unrelated("in", place.thing)  # nothing else supports it until that is known
    yield Grounding(
        (step,), "; ".join(filter(None, (f"close on {1000 * width:.0f} mm with {force:.0f} N", why))), 0.0,
        lifted.grasped(held), key="close",
    )


def _names_of(thing: str, context: Context) -> tuple[str, ...]:
    """Names of the object designators that are bound to a thing or to a part of it."""
    return tuple(n for n, v in context.bindings.items() if isinstance(v, str) and thing_of(v) == thing)


def _open(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a gripper motion: open fully or as far as the grasp needs ("open"), close on nothing
    ("shut"), or open as the place states ("place")."""
    gripper = context.robot.gripper
    opening = _opening(motion, belief, context)
    enough = word(motion, "to", Fingers) is Fingers.OPEN and _is_open(belief, gripper)
    if belief.held is None and (abs(belief.opening - opening) < 1e-6 or enough):
        yield Grounding((), f"{1000 * belief.opening:.0f} mm open already", key="there")
        return
    expect: Any = word(motion, "expect", ExpectedGrip, ExpectedGrip.ANY).value
    after = _let_go(motion, belief, context, opening) if belief.held else replace(belief, opening=opening)
    step = SetGripper(opening, _speed(context.robot), gripper.force[0], expect, origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"open to {1000 * opening:.0f} mm", 0.0, after, key="open")


def _is_open(belief: Belief, gripper: Gripper) -> bool:
    """Whether the fingers are open enough for the predicate ``gripper_open``.

    A task that opens them has nothing left to do then.
    """
    low, high = gripper.opening
    return (belief.opening - low) / (high - low) > OPENED


def _speed(robot: Robot) -> float:
    low, high = robot.gripper.speed
    return min(max(PADS_SPEED * robot.pace, low), high)


def release_opening(belief: Belief, context: Context) -> float:
    """Return the opening of the fingers for a release [m]: as the payload's latest place states for its
    release, else for its grasp; else the widest."""
    held, most = belief.held.thing if belief.held else "", context.robot.gripper.opening[1]
    said = [
        v.release.opening_m if v.release and v.release.opening_m is not None else v.opening
        for v in context.bindings.values()
        if isinstance(v, Place) and v.thing == held and (v.grip or (v.release and v.release.opening_m is not None))
    ]
    return said[-1] or most if said else most


def _opening(motion: Motion, belief: Belief, context: Context) -> float:
    low, high = context.robot.gripper.opening
    match word(motion, "to", Fingers):
        case Fingers.OPEN:
            return release_opening(belief, context)
        case Fingers.SHUT:
            return low
        case _:
            return place_of(motion, context).opening or high


def _let_go(motion: Motion, belief: Belief, context: Context, opening: float) -> Belief:
    """Belief after a release: the payload stays where it is let go; over a container, or put down, it is on its
    support."""
    from ..motion_planning.reach import held_pose

    release = context.bindings[motion.to.name].release if motion.to is not None else None
    let_go_at = belief.base() * held_pose(belief, context)
    pose, into = (let_go_at * release.settles, release.into) if release else (let_go_at, "")
    if into or belief.relates("on", belief.payload.thing):
        pose = fallen(belief, pose)
    deepest = fallen(belief, pose, onto=into) if into else pose  # what lies in there may give way
    on_rails = belief.world.thing(belief.payload.thing).joint is not None  # or on hinges: it neither falls nor shifts
    sigma = math.hypot(release.sigma_m if release else 0.0 if on_rails else LET_GO, belief.payload.sigma)
    fall = max(0.0, float(let_go_at.position[2] - min(pose.position[2], deepest.position[2])))
    return belief.released(Estimate(pose, sigma, f"predicted: let go by {motion.name}", fall), opening)


def fallen(belief: Belief, pose: Pose, onto: str = "") -> Pose:
    """Return the payload's pose in the world after a straight fall onto what is below it; its present pose if
    nothing is.

    Args:
        onto: the only thing that counts as a support; "" for all.
    """
    thing = belief.world.thing(belief.payload.thing)
    under = [(belief.world.thing(name), e.pose) for name, e in belief.poses.items() if onto in ("", name)]
    height, _ = resting_height(thing, pose, under)
    return Pose((*pose.position[:2], height - lowest(thing, pose)), pose.quaternion) if math.isfinite(height) else pose


def _hanging(belief: Belief) -> Iterator[tuple[float, Pose]]:
    """Payload and its content: mass [kg] and pose in the frame of the TCP; nothing where a joint carries
    them."""
    if (held := belief.held) is None or belief.world.thing(held.thing).joint is not None:
        return
    yield load(belief.world.thing(held.thing)), held.tcp_to_thing
    for name, estimate in held.carries.items():
        yield load(belief.world.thing(name)), held.tcp_to_thing * estimate.pose


def _payload(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Mass of gripper, payload and its content, and the common centre of gravity in the flange frame."""
    gripper = context.robot.gripper
    mass, moment = gripper.mass, gripper.mass * np.array([0.0, 0.0, gripper.tcp.position[2] / 2])
    for carried, pose in _hanging(belief):
        moment = moment + carried * np.array((gripper.tcp * pose).position)
        mass += carried
    if mass > context.robot.payload:
        load_of = [n for n, v in context.bindings.items() if belief.held and v == belief.held.thing]
        because = (*load_of, *enclosing_names(motion.name)) if load_of else ()  # places and grasps change no mass
        raise overload(belief.held.thing if belief.held else "", mass, context.robot, because)
    center = (float(moment[0] / mass), float(moment[1] / mass), float(moment[2] / mass))
    step = SetPayload(mass, center, origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"{mass:.2f} kg on the flange", key=f"{mass:.3f}")
