"""Pictures of a rollout and its scene for a viewer, from its recorded poses."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from cramlite.model import EntityName, Floats, Pose, Robot, Rollout, Scene, Thing, World, vector3

from ...shapes.bounds import corners, radius
from ..camera.ray_tracer import Backdrop, Camera, backdrop, cast, part_still, render_before
from ..model.compile import Compiled, compile_world
from ..model.index import Data, Model, RobotIndex
from ..model.triangles import body_name, solids
from .recorder import effector_of

NEAREST = 0.9
"""Least distance of a camera that is fitted to things [m]: the hand is seen around a small one, too."""
MARGIN = 0.15
"""Margin around the positions of things in a picture, for the extents of the things [m]."""
WHOLE = 0.5
"""Radius beyond which only the place of a thing is to be in the picture [m], not all of the thing: floors and tables are larger."""


def picture(
    rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int], about: Collection[str] = ()
) -> Any:
    """Render one sample of a rollout as an image (height, width, 3) of uint8.

    Args:
        size: (width, height) [pixel].
        about: names of things; all of them are in the picture wherever they were in the run, and it shows little else. None for the
            view that is usual.
    """
    key = _ById(rollout, robots)
    compiled = _compiled(key)
    data = compiled.places()
    _put(compiled, data, rollout, sample)
    mujoco.mj_kinematics(compiled.model, data)
    camera = fitted(camera_of(rollout.world, compiled.model, data), rollout, about, size)
    return render_before(_backdrop(key, camera, size), compiled.model, data)


def fitted(usual: Camera, rollout: Rollout, about: Collection[str], size: tuple[int, int]) -> Camera:
    """Return a camera with the usual direction, moved so close that all positions of the things in ``about``
    just fit into the picture."""
    named = [t for t in rollout.world.things if t.name in about]
    moved = {t.name: rollout.poses[t.name][:, :3] for t in named if t.name in rollout.poses and (t.movable or t.joint)}
    if not named:
        return usual
    places = np.concatenate([moved.get(t.name, _outline(t)) for t in named])
    axes = usual.pose.rotation  # columns: right, down, forward
    seen = places @ axes
    middle, deep = (seen.min(axis=0) + seen.max(axis=0))[:2] / 2, seen[:, 2].mean()
    spread = math.tan(usual.vertical_fov / 2) * np.array([size[0] / size[1], 1.0])
    nearest = ((np.abs(seen[:, :2] - middle) + MARGIN) / spread).max(axis=1) - (seen[:, 2] - deep)
    eye = axes @ [*middle, deep - max(float(nearest.max()), NEAREST)]
    return Camera(vector3(eye), vector3(eye + axes[:, 2]), usual.vertical_fov)


def _outline(thing: Thing) -> Floats:
    """Corners (P, 3) of a thing in the world; only its origin if the thing is too large for a picture."""
    whole = bool(thing.geoms) and radius(thing) <= WHOLE
    return corners(thing, thing.pose) if whole else np.array([thing.pose.position])


def camera_of(world: World, model: Model, data: Data) -> Camera:
    """Return the camera beside the first robot: on its right, or on its left if something near the camera
    hides the place in front of the robot."""
    usual, base = Camera(), world.robots[0].base if world.robots else Pose()
    x, y, z = usual.eye
    right, left = (Camera((base * Pose(e)).position, (base * Pose(usual.target)).position) for e in (usual.eye, (x, -y, z)))
    return right if _clear(model, data, right) or not _clear(model, data, left) else left


def _clear(model: Model, data: Data, camera: Camera) -> bool:
    """Whether the first half of a camera's line of sight to its target is free."""
    eye, way = np.asarray(camera.eye), np.subtract(camera.target, camera.eye)
    geom, distance, _ = cast(model, data, eye, way[None] / np.linalg.norm(way))
    return bool(geom[0] < 0 or distance[0] > np.linalg.norm(way) / 2)


def scene(rollout: Rollout, robots: Mapping[str, Robot], samples: Sequence[int]) -> Scene:
    """Build the scene of a rollout for a viewer: its solids, and their poses at some samples."""
    compiled = _compiled(_ById(rollout, robots))
    model, data = compiled.model, compiled.data()
    shapes, rows = solids(model), []
    for sample in samples:
        _put(compiled, data, rollout, sample)
        mujoco.mj_kinematics(model, data)
        rows.append(np.hstack([data.xpos, data.xquat]))
    names = {body_name(model, b): b for b in range(model.nbody)}
    owners = {body_name(model, int(model.geom_bodyid[g])): o.name for g, o in enumerate(compiled.owners)}
    return Scene(rollout.times[list(samples)], shapes, _tracks(np.array(rows), names, owners), owners)


def _tracks(rows: Floats, names: Mapping[str, int], shown: Mapping[str, str]) -> dict[str, Floats]:
    """Poses of the bodies that a viewer shows, from (N, bodies, 7); a body that stands still has one row
    instead of N."""
    tracks = {name: rows[:, body] for name, body in names.items() if name in shown}
    return {name: track if np.ptp(track, axis=0).max() > 1e-6 else track[:1] for name, track in tracks.items()}


def _put(compiled: Compiled, data: Data, rollout: Rollout, sample: int) -> None:
    """Put every body where it was at a sample; kinematics must be computed afterwards."""
    index = effector_of(compiled, rollout.effector)
    for thing in rollout.world.things:
        if thing.movable:
            row = rollout.poses[thing.name][sample]
            compiled.place(data, thing.name, Pose.from_row(row))
    for name, centres in rollout.grains.items():
        addresses = np.array([address for _, address in compiled.things[name].grains])
        data.qpos[addresses[:, None] + np.arange(3)] = centres[sample]
    if isinstance(index, RobotIndex):
        data.qpos[list(index.joints)] = rollout.joints[sample]
        index.set_opening(data, float(rollout.opening[sample]))
        if index.platform is not None:
            row = rollout.poses[str(EntityName(index.name, "base"))][sample]
            start = next(m.base for m in rollout.world.robots if m.name == index.name)
            index.platform.put(data, start, Pose.from_row(row))


class _ById:
    """Rollout that is compared by identity, as a cache key: all its pictures use one model."""

    def __init__(self, rollout: Rollout, robots: Mapping[str, Robot]) -> None:
        self.rollout, self.robots = rollout, robots

    def __hash__(self) -> int:
        return id(self.rollout)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ById) and other.rollout is self.rollout


@lru_cache(maxsize=1)
def _compiled(key: _ById) -> Compiled:
    compiled = compile_world(key.rollout.world, key.robots, hand=not key.rollout.world.robots)
    part_still(compiled.model)
    return compiled


@lru_cache(maxsize=1)
def _backdrop(key: _ById, camera: Camera, size: tuple[int, int]) -> Backdrop:
    compiled = _compiled(key)
    return backdrop(compiled.model, compiled.data(), camera, size)
