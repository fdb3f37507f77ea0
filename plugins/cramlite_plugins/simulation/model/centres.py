"""Things of a twin whose centres of mass are displaced from those that follow from their shapes.

A twin is a copy of a world with drawn errors.
"""

from __future__ import annotations

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Inertia, Pose, Thing, Vector3, World, vector3

from .build import add_thing, finish


def real_things(world: World) -> tuple[Thing, ...]:
    """Return the things of a world; the centre of mass of each that ``Disturbance.centres`` names is
    displaced."""
    centres = world.disturbance.centres
    return tuple(_off(t, centres[t.name]) if t.movable and t.name in centres else t for t in world.things)


def _off(thing: Thing, by: Vector3) -> Thing:
    spread = thing.inertia or of_shape(thing)
    x, y, z = (a + b for a, b in zip(spread.centre, by, strict=True))
    return replace(thing, inertia=Inertia((x, y, z), spread.moments))


def of_shape(thing: Thing) -> Inertia:
    """Return the inertia of a thing whose mass is spread evenly over its geoms, as MuJoCo computes it."""
    spec = mujoco.MjSpec()
    add_thing(spec, replace(thing, pose=Pose(), joint=None, inertia=None), planning=False, carried=None)
    body = finish(spec).body(thing.name)
    turn = Pose(quaternion=tuple(body.iquat)).rotation
    m = turn @ np.diag(body.inertia) @ turn.T
    return Inertia(vector3(body.ipos), tuple(float(m[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))  # type: ignore[arg-type]
