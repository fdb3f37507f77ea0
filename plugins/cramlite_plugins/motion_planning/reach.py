"""Reachability: joint positions for TCP poses in a belief, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import ArrayLike

from cramlite.model import (
    Belief,
    EntityName,
    Location,
    Motion,
    Place,
    Pose,
    Remedy,
    World,
    enclosing_names,
    thing_of,
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..kinematics.forward import forward
from ..kinematics.inverse import inverse, postures, why_no_inverse
from ..shapes.joints import mounts
from .planner import in_the_way
from .planning_scene import PlanningScene
from .postures import TOUCH
from .scene_of_world import scene
from .space import refusal
from .too_far import no_inverse

Joints = tuple[float, ...]
SIGMAS = 2.0
"""Distance that paths keep from an uncertain thing beyond their clearance, in standard deviations of its
position: 98 % of normal errors along the line between two bodies are smaller."""
WIDEST = 0.01
"""Largest distance that paths keep beyond their clearance for an uncertain pose [m]; less certain things,
such as those in a basket, are kept in place by something else."""
TRIED = 24  # nearest inverse solutions that are looked at: eight branches with their nearest turns


def tcp(belief: Belief, context: Context) -> Pose:
    """Return the believed TCP pose in the base frame."""
    return forward(context.robot, belief.joints)


def held_pose(belief: Belief, context: Context) -> Pose:
    """Return the pose of the held thing in the base frame.

    Raises:
        Unresolvable: nothing is held.
    """
    if belief.held is None:
        raise Unresolvable("the hand holds no payload")
    return tcp(belief, context) * belief.held.tcp_to_thing


def make_scene(
    belief: Belief,
    context: Context,
    touch: Iterable[str] = (),
    opening: float | None = None,
    clearance: float | None = None,
    hand: bool = True,
    pushes: Iterable[str] = (),
    wider: Mapping[str, float] | None = None,
) -> PlanningScene:
    """Build the planning scene of a belief.

    Args:
        touch: entities that gripper, held thing and what that carries may touch.
        hand: whether the gripper may.
        opening: of the fingers [m]; the believed one by default.
        clearance: to everything else [m]; the planner's own by default, and more to what is not surely known.
        pushes: things that the held thing and what that carries may touch, and the gripper may not.
        wider: thing -> distance to it beyond the clearance [m], where ``clearance`` is None; by default
            ``uncertainty_margins``.
    """
    poses = {name: e.pose for name, e in belief.poses.items() if belief.world.thing(name).movable}
    held = belief.in_hand()
    movers = ("effector", *held) if hand else held
    pairs = frozenset(
        frozenset((m, t)) for m in movers for e in touch for t in _touchable(belief, e) if m != t
    )
    pairs |= frozenset(frozenset((m, t)) for m in held for t in pushes if m != t)
    jointed = [t for t in belief.world.things if t.name in held and t.joint is not None]
    pairs |= frozenset(frozenset((t.name, name)) for t in jointed for name in mounts(t, belief.world))
    margins = uncertainty_margins(belief) if wider is None else wider
    extra: dict[str, Any] = {"wider": margins} if clearance is None else {"clearance": clearance}
    width = belief.opening if opening is None else opening
    robots = {context.robot.type: context.robot}
    return scene(
        standing(belief, context), robots, belief.robot, poses=poses, held=held, opening=width, allowed=pairs,
        **extra,
    )  # fmt: skip


def pushed_off(belief: Belief, context: Context) -> tuple[str, ...]:
    """Return the loose things that touch the payload where it is, and that it may push off as it leaves: it
    cannot be moved without them. None where no plan may push things, none for what runs on a joint, and
    nothing that must keep its place."""
    if belief.held is None or not context.limits.may_push:
        return ()
    held = belief.in_hand()
    if belief.world.thing(belief.held.thing).joint is not None:
        return ()
    stay = {*held, *dict(context.limits.keep)}
    loose = {t.name for t in belief.world.things if t.movable} - stay
    near = make_scene(belief, context, clearance=TOUCH).collisions(belief.joints)
    pairs = [{thing_of(a), thing_of(b)} for a, b, _ in near]
    return tuple(sorted({one for pair in pairs if pair & held.keys() for one in pair & loose}))


def uncertainty_margins(belief: Belief) -> dict[str, float]:
    """Return the distance [m] to keep from each thing, in addition to the clearance, since its pose is
    uncertain."""
    spread = {name: e.sigma for name, e in belief.poses.items()}
    if belief.held:
        spread[belief.held.thing] = belief.held.sigma
        spread |= {name: e.sigma for name, e in belief.held.carries.items()}
    return {name: min(SIGMAS * sigma, WIDEST) for name, sigma in spread.items() if sigma > 0}


def standing(belief: Belief, context: Context) -> World:
    """Return the world with the acting robot's base where it is believed to be."""
    if belief.at is None:
        return belief.world
    stand = context.robot.stand_of(belief.at)
    mounts = (replace(m, base=stand) if m.name == belief.robot else m for m in belief.world.robots)
    return replace(belief.world, robots=tuple(mounts))


def _touchable(belief: Belief, entity: str) -> tuple[str, ...]:
    """Return the names that a motion may touch if it may touch an entity: a thing's own name, or all features
    of a feature's thing."""
    name = EntityName.parse(entity)
    if not name.part:
        return (name.thing,)
    return tuple(str(EntityName(name.thing, f.name)) for f in belief.world.thing(name.thing).features)


def touched(names: Iterable[str], context: Context) -> list[str]:
    """Return the entities that the named variables are bound to; unbound variables are left out."""
    return [str(context.bindings[n]) for n in names if n in context.bindings]


def collision_free_ik(place: PlanningScene, context: Context, pose: Pose, seed: Joints) -> Joints | Refused:
    """Return the collision-free inverse kinematics solution nearest to joint position ``seed``; or the reason
    for none, and the obstacles.

    Args:
        pose: of the TCP in the base frame.
        seed: joint position [rad].
    """
    solutions = inverse(context.robot, pose, seed=seed)
    if not solutions:
        return refusal(why_no_inverse(context.robot, pose), remedy=no_inverse(context.robot, pose))
    nearest, tried = solutions[0], [*postures(solutions[:TRIED]).values()]
    free = next(filter(place.free, tried), None)
    return free or refusal(
        place.why(nearest), blocking=in_the_way(place, tried), collision=place.collision(nearest)
    )


def bound(context: Context, name: str | None) -> str:
    """Return the entity that a variable was bound to; "" for no variable."""
    return str(context.bindings[name]) if name else ""


def reference_pose(belief: Belief, location: Location, context: Context) -> Pose:
    """Return the pose in the base frame of a location's reference thing.

    Raises:
        Unresolvable: it is in the hand, or was let go of where nobody can say how it fell.
    """
    thing = thing_of(bound(context, location.of))
    if thing in belief.poses:
        return belief.pose(thing)
    held = belief.held is not None and belief.held.thing == thing
    reason = f"'{thing}' is in the hand" if held else f"where '{thing}' came to lie is not known"
    raise Unresolvable.because_of_earlier_tasks(reason, causes(location, context), blocking=())


def shift(pose: Pose, by: ArrayLike) -> Pose:
    """Translate a pose by a vector [m] of its parent frame."""
    return Pose(tuple(np.asarray(pose.position) + np.asarray(by, dtype=float)), pose.quaternion)


def traverse(
    location: Location,
    belief: Belief,
    context: Context,
    shifts: Iterable[ArrayLike],
    name: str,
    cost: float = 0.0,
) -> Grounding:
    """Return a path of translations of the TCP [m] from where it is; every corner must be reachable.

    Raises:
        Unresolvable: a corner is not; the path depends on the grasp and on what it leads along.
    """
    place = make_scene(belief, context, [bound(context, location.of)])
    here, seed = tcp(belief, context), belief.joints
    path = tuple(shift(here, s) for s in shifts)
    for k, pose in enumerate(path, 1):
        there = collision_free_ik(place, context, pose, seed)
        if isinstance(there, Refused):
            said = f"corner {k} of {len(path)} of '{name}': {there.reason}"
            raise there.impossible(said, causes(location, context))
        seed = there
    return Grounding(
        Place(path[0], path[0], path=path, thing=bound(context, location.of)), name, cost, key=name
    )


def causes(location: Location, context: Context) -> tuple[str, ...]:
    """Return the names of the choices in the search on which a path from the hand's present pose depends.

    Every place it was led to, the grasp among them, and the reference object.
    """
    return (
        *(name for name, value in context.bindings.items() if isinstance(value, Place)),
        location.of or "",
    )


def unfit(location: Location, reason: str, remedy: Remedy | None = None) -> Unresolvable:
    """Return the refusal of a location because of its reference object alone: nothing is in the way."""
    return Unresolvable(reason, (location.of or "",), blocking=(), remedy=remedy)


def taken_at(belief: Belief, context: Context) -> tuple[str, ...]:
    """Return the names of the payload's grasps, on which its pose in the hand depends."""
    held = belief.held.thing if belief.held else ""
    return tuple(
        n
        for n, v in context.bindings.items()
        if isinstance(v, Place) and v.thing == held and v.grip is not None
    )


def led_by(location: Location, context: Context) -> tuple[str, ...]:
    """Return the names of the tasks whose motions lead to a location.

    Another way of doing such a task may have a free motion.
    """
    leading = (
        m for m in context.agenda if isinstance(m, Motion) and m.to is not None and m.to.name == location.name
    )
    return tuple(dict.fromkeys(whole for m in leading for whole in [*enclosing_names(m.name)][1:2]))


def led_here(context: Context) -> tuple[str, ...]:
    """Return the names of the earlier choices that led the hand to its present pose.

    A way to a pose nearby depends on them: the last place, and earlier ones of the same thing, such as the
    grasp of a released payload.
    """
    places = {name: value.thing for name, value in context.bindings.items() if isinstance(value, Place)}
    last = next(reversed(places.values()), "")
    return tuple(name for name, thing in places.items() if thing == last)
