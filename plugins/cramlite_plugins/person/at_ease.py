"""Start pose of a person's hand for a list of tasks: in front of the things, pointing forward and down."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Pose, Thing, World

from ..shapes.bounds import support


def facing(world: World) -> Floats:
    """Compute the unit vector (3,) that the person looks along: level, from where the robot stands (else the origin) to the things."""
    base = world.robots[0].base.position if world.robots else (0.0, 0.0, 0.0)
    to = _middle(world) - base
    level = np.array([to[0], to[1], 0.0])
    length = float(np.linalg.norm(level))
    return level / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])


def forward_and_down(ahead: Floats) -> Pose:
    """Compute the hand's orientation at rest: half way between down and the level unit vector ``ahead`` (3,), the fingers side by side."""
    return Pose.from_axes((0.0, 0.0, 0.0), (ahead[0], ahead[1], -1.0), (0.0, 0.0, -1.0))


def at_ease(world: World, rng: np.random.Generator) -> Pose:
    """Draw a start pose of the hand: in front of the things, 0.2 to 0.35 m above the highest movable thing, turned a little."""
    ahead = facing(world)
    aside = np.cross(ahead, (0.0, 0.0, 1.0))
    top = max(support(t, t.pose, (0, 0, 1)) for t in _handled(world))
    place = _middle(world) - ahead * rng.uniform(0.15, 0.3) + aside * rng.uniform(-0.2, 0.2)
    turned = forward_and_down(ahead) * Pose.from_rotvec((0, 0, 0), rng.normal(0, 0.1, 3).tolist())
    return Pose((place[0], place[1], top + rng.uniform(0.2, 0.35)), turned.quaternion)


def _handled(world: World) -> list[Thing]:
    """Things that are movable or on a joint; all things if none is."""
    return [t for t in world.things if t.movable or t.joint] or list(world.things)


def _middle(world: World) -> Floats:
    return np.asarray(np.mean([t.pose.position for t in _handled(world)], axis=0))
