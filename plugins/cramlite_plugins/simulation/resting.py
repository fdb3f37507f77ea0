"""Poses in which a thing comes to rest on another that is not flat: a bottle in the trough of a rack, a book in a slot.

The two are simulated in a world of their own. A thing is let go of where it first touches the other, or beside that; what only
friction would hold slides off, since there is little of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import product

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Thing, World
from cramlite.plugin import checkpoint

from ..shapes.bounds import corners
from ..shapes.itself import Itself
from .model.compile import Compiled, compile_world, divergence, unstable
from .model.index import Data

FRICTION = 0.2
"""Largest friction coefficient that a rest pose may rely on: wood on wood slides at 11 deg, as in ``shapes.surfaces``. A bottle on a
board of 31 deg stays with a friction of .95."""
SECONDS, LOOK = 2.0, 0.1
"""Longest time that a thing may take to come to rest, and the time between two looks at it [s]."""
STILL = 0.02, 0.2
"""Largest speed and rate of turn of a thing at rest [m/s, rad/s]."""
LOOKS = 4
"""Number of looks in a row at which a thing is slow enough before it is at rest: a fall over an edge begins slowly."""
ASIDE = 0.005
"""Error of the place at which a thing is let go of [m]: a streamed arm is up to 5 mm off its path."""
LEANING = math.radians(3.0)
"""Lean of a thing at its test release beside its place: a thing that only stands on an edge, as no hand could put it, then falls over."""
AGAIN = 0.015, math.radians(15.0)
"""Largest difference between two rest poses that count as the same [m, rad]."""
STEP = 0.003  # in which a thing is let down until it touches [m]


def resting_pose(thing: Thing, start: Pose, below: Thing, at: Pose) -> Pose | None:
    """Find the rest pose of a thing on another after it is let down straight and released.

    Args:
        start: of the thing in a frame whose z is up: its height does not matter.
        below: what it is let down onto.
        at: its pose in the same frame.

    Returns:
        The pose, to which the thing also comes when it is let go of 5 mm aside on both axes and leans by 3 deg about each; None if
        it falls off or goes elsewhere.
    """
    return _firm(Itself(thing), start, Itself(below), at)


def let_down(thing: Thing, start: Pose, below: Thing, at: Pose) -> Pose | None:
    """Return the pose of a thing 3 to 6 mm above where it first touches another when let down straight; None
    if it misses the other.

    Args:
        start: of the thing in a frame whose z is up: its height does not matter.
        below: what it is let down onto, or into.
        at: its pose in the same frame.
    """
    compiled = _alone(Itself(thing), Itself(below), at)
    return _let_down(compiled, compiled.data(), thing, start, corners(below, at))


def rests(thing: Thing, start: Pose, below: Thing, at: Pose, aside: float, there: bool = False) -> Iterator[Pose | None]:
    """Generate the rest poses of a thing that is released at its first contact with another: at a pose and to
    each side of it, with full and with little friction; None where it falls off.

    Args:
        start: as for ``let_down``.
        aside: how far off it may be on either axis [m].
        there: whether it is let go of at the pose itself, such as under a roof.
    """
    for (x, y), friction in product(((0.0, 0.0), *product((-aside, aside), repeat=2)), (math.inf, FRICTION)):
        near = Pose(tuple(np.add(start.position, (x, y, 0.0)).tolist()), start.quaternion)
        yield _dropped(Itself(thing), near, Itself(below), at, friction, there)


@lru_cache(maxsize=2048)
def _firm(thing: Itself[Thing], start: Pose, below: Itself[Thing], at: Pose) -> Pose | None:
    """Return the pose in which a thing comes to rest, if it ends there also when released to either side and leaning; else None."""
    found = _dropped(thing, start, below, at)
    if found is None:
        return None
    ends = (_dropped(thing, _beside(found, *way), below, at) for way in product((-1.0, 1.0), repeat=2))
    return found if all(end is not None and _same(end, found) for end in ends) else None


def _beside(pose: Pose, x: float, y: float) -> Pose:
    """Return a thing's pose shifted sideways and leaning to the same side, for another simulated release."""
    turn = Pose.from_rotvec((0.0, 0.0, 0.0), (-y * LEANING, x * LEANING, 0.0))
    there = np.add(pose.position, (x * ASIDE, y * ASIDE, 0.0))
    return Pose(tuple(there.tolist()), (turn * Pose((0.0, 0.0, 0.0), pose.quaternion)).quaternion)


def _same(one: Pose, other: Pose) -> bool:
    way, turn = one.distance(other)
    return way <= AGAIN[0] and turn <= AGAIN[1]


def _dropped(
    thing: Itself[Thing], start: Pose, below: Itself[Thing], at: Pose, friction: float = FRICTION, there: bool = False
) -> Pose | None:
    """Rest pose of a thing that is released just above its first contact; None if it falls off.

    If ``there``, it is released at ``start`` instead.
    """
    compiled = _alone(thing, below, at, friction)
    data = compiled.data()
    if there:
        compiled.place(data, thing.it.name, start)
    elif _let_down(compiled, data, thing.it, start, corners(below.it, at)) is None:
        return None
    bottom, quiet = float(corners(below.it, at)[:, 2].min()), 0
    for _ in range(round(SECONDS / LOOK)):
        checkpoint()
        mujoco.mj_step(compiled.model, data, round(LOOK / compiled.model.opt.timestep))
        pose = compiled.pose(data, thing.it.name)
        if unstable(divergence(data)) or float(corners(thing.it, pose)[:, 2].min()) < bottom - ASIDE:
            return None
        quiet = quiet + 1 if _rests(compiled, data) else 0
        if quiet == LOOKS:
            return pose
    return None


def _let_down(compiled: Compiled, data: Data, thing: Thing, start: Pose, below: Floats) -> Pose | None:
    """Place a thing just above its first contact on the way down onto another, whose corners are ``below``
    (n, 3); None if it falls past the other."""
    lowest = float(corners(thing, start)[:, 2].min())
    bottom, top = (float(v) for v in (below[:, 2].min(), below[:, 2].max()))
    for drop in np.arange(0.0, top - bottom, STEP):
        x, y, z = start.position
        compiled.place(data, thing.name, Pose((x, y, z - lowest + top + STEP - float(drop)), start.quaternion))
        mujoco.mj_fwdPosition(compiled.model, data)
        if data.ncon > 0:
            there = Pose((x, y, z - lowest + top + 2 * STEP - float(drop)), start.quaternion)
            compiled.place(data, thing.name, there)
            return there
    return None


def _rests(compiled: Compiled, data: Data) -> bool:
    """Whether the released thing is at rest and touches the thing below it."""
    return data.ncon > 0 and float(np.linalg.norm(data.qvel[:3])) < STILL[0] and float(np.linalg.norm(data.qvel[3:])) < STILL[1]


@lru_cache(maxsize=16)
def _alone(thing: Itself[Thing], below: Itself[Thing], at: Pose, friction: float = FRICTION) -> Compiled:
    """World of a movable thing and a fixed one, with low friction."""
    under = replace(below.it, pose=at, mass=None, joint=None, filling=None, inertia=None)
    compiled = compile_world(World((under, replace(thing.it, filling=None))), {})
    model = compiled.model
    model.geom_friction[:, 0] = np.minimum(model.geom_friction[:, 0], friction)
    model.pair_friction[:, :2] = np.minimum(model.pair_friction[:, :2], friction)
    model.geom_friction[:, 1:] = model.pair_friction[:, 2:] = 0.0  # that against turning would hold up what stands on two points
    return compiled
