"""Where the arm can stand: joint positions for TCP poses, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from cramlite import Belief, Context, Pose
from cramlite_plugins.motions.kinematics import forward, inverse, reach_shortfall
from cramlite_plugins.motions.scene import Scene, scene

Joints = tuple[float, ...]
TRIED = 24  # nearest inverse solutions that are looked at: eight branches with their nearest turns


def tcp(belief: Belief, context: Context) -> Pose:
    """The TCP in the base frame, now."""
    return forward(context.robot, belief.joints)


def held_pose(belief: Belief, context: Context) -> Pose:
    """Pose of the held thing in the base frame."""
    assert belief.held is not None
    return tcp(belief, context) * belief.held.tcp_to_thing


def make_scene(
    belief: Belief,
    context: Context,
    touch: Iterable[str] = (),
    opening: float | None = None,
    clearance: float | None = None,
) -> Scene:
    """The planning scene of a belief.

    Args:
        touch: entities that gripper and held thing may touch.
        opening: of the fingers [m]; the believed one by default.
    """
    poses = {name: e.pose for name, e in belief.poses.items() if belief.world.thing(name).movable}
    held = (belief.held.thing, belief.held.tcp_to_thing) if belief.held else None
    movers = ("effector", *((belief.held.thing,) if belief.held else ()))
    pairs = frozenset(frozenset((m, t)) for m in movers for e in touch for t in _touchable(belief, e) if m != t)
    extra = {} if clearance is None else {"clearance": clearance}
    width = belief.opening if opening is None else opening
    robots = {context.robot.type: context.robot}
    return scene(belief.world, robots, belief.robot, poses=poses, held=held, opening=width, allowed=pairs, **extra)


def _touchable(belief: Belief, entity: str) -> tuple[str, ...]:
    """A thing as a whole; of a feature, all named parts of its thing but not the rest of its body."""
    thing, _, part = entity.partition("/")
    return tuple(f"{thing}/{f.name}" for f in belief.world.thing(thing).features) if part else (thing,)


def touched(names: Iterable[str], context: Context) -> list[str]:
    """Entities behind variables."""
    return [str(context.bindings[n]) for n in names if n in context.bindings]


def stance(place: Scene, context: Context, pose: Pose, seed: Joints) -> Joints | str:
    """A free joint position for a TCP pose, the nearest to ``seed``; or why there is none."""
    solutions = inverse(context.robot, pose, seed=seed)
    if not solutions:
        return reach_shortfall(context.robot, pose) or "no inverse solution: the wrist cannot be turned that way there"
    free = next((q for q in solutions[:TRIED] if place.free(q)), None)
    return free or place.why(solutions[0])


def bound(context: Context, name: str | None) -> str:
    """The entity that a variable was bound to."""
    return str(context.bindings[name]) if name else ""


def named(bindings: Mapping[str, object], prefix: str) -> tuple[str, ...]:
    """Names of choices that begin so."""
    return tuple(k for k in bindings if k.startswith(prefix))
