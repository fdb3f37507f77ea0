"""Pictures of states that planning refused: both bodies that are too near one another in strong colours, all else pale.

What hides the two bodies is looked through, and so is each where it hides the other; a ring is around the place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import mujoco
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import Collision, Floats, Robot, Value, World

from ..camera.ray_tracer import Camera, Image, cast, only, rays_of, shade
from ..model.build import Carried
from ..model.compile import Compiled, compile_world
from ..model.index import Data, Model

PALE = (0.80, 0.82, 0.84, 1.0)
STRONG = ((0.86, 0.28, 0.12, 1.0), (0.05, 0.38, 0.78, 1.0))
"""Colours of the two bodies, which colour-blind people can tell apart, too."""
THROUGH = 0.6
"""Opacity of an occluder in front of one of the two bodies."""
AZIMUTHS, ELEVATIONS = range(0, 360, 45), (20.0, 50.0)
"""Directions from which a picture may be taken [deg]; the picture is taken from the direction that shows most of both bodies."""
COARSE = (32, 24)
"""Size of the pictures by which camera directions are compared [pixel]."""
NEAREST, FARTHEST = 0.45, 0.9
"""Least and largest distance of the camera from the place of the collision [m]."""
REACH = 1.0
"""Distance up to which the nearest points of the two bodies are looked for [m]."""
LOCAL = 0.35
"""Distance from the place of the collision at which a body has faded to 1/e of its colour [m]: a floor is not blue all over."""
RING = (0.075, 0.085)
"""Inner and outer radius of the ring that marks the collision, as shares of the picture's height."""


class _Seen(Value):
    """Hits of rays on one group of geoms: distances (N,) [m], infinite for none, and colours (N, 3), 0 to 1."""

    distance: Floats
    colour: Floats

    @property
    def hit(self) -> NDArray[np.bool_]:
        return np.isfinite(self.distance)


def collision_picture(world: World, robots: Mapping[str, Robot], collision: Collision, size: tuple[int, int]) -> Image:
    """Draw a refused state as (height, width, 3) uint8.

    Args:
        world: as it is at the start; the collision says what is elsewhere.
        size: (width, height) [pixel].

    Raises:
        KeyError: the world has no such robot or thing.
    """
    compiled, data = _state(world, robots, collision)
    bodies = [_geoms(compiled, name) for name in (collision.one, collision.other)]
    _paint(compiled.model, bodies)
    place = _place(compiled.model, data, bodies)
    smaller = min(float(compiled.model.geom_rbound[b].max()) for b in bodies)
    far = min(max(4 * smaller, NEAREST), FARTHEST)
    camera = max(_cameras(place, far), key=lambda c: _shown(compiled.model, data, c))
    image = _blended(compiled.model, data, camera, size).reshape(size[1], size[0], 3)
    image[_ring(size)] = 0.1
    return (image * 255).astype(np.uint8)


def _state(world: World, robots: Mapping[str, Robot], collision: Collision) -> tuple[Compiled, Data]:
    """MuJoCo model, compiled for planning, of the state that was refused for a collision, and its data with
    all poses computed."""
    mounts = tuple(replace(m, base=collision.base) if m.name == collision.robot else m for m in world.robots)
    placed = replace(world.moved(dict(collision.moved)), robots=mounts)
    carried = {name: Carried(collision.robot, pose) for name, pose in collision.held.items()}
    compiled = compile_world(placed, robots, planning=True, carried=carried)
    index, data = compiled.robots[collision.robot], compiled.data()
    data.qpos[list(index.joints)] = collision.joints
    index.set_opening(data, collision.opening)
    mujoco.mj_kinematics(compiled.model, data)
    return compiled, data


def _geoms(compiled: Compiled, name: str) -> list[int]:
    found = [g for g, owner in enumerate(compiled.owners) if owner.touch == name]
    if not found:
        raise KeyError(name)
    return found


def _paint(model: Model, bodies: Sequence[Sequence[int]]) -> None:
    """Give the two colliding bodies strong colours and geom groups 1 and 2, and the rest a pale colour and group 0.

    Rays tell the bodies apart by the group.
    """
    model.geom_rgba[:], model.geom_group[:] = PALE, 0
    for group, (geoms, colour) in enumerate(zip(bodies, STRONG, strict=True), 1):
        model.geom_rgba[geoms], model.geom_group[geoms] = colour, group


def _place(model: Model, data: Data, bodies: Sequence[Sequence[int]]) -> Floats:
    """The point (3,) midway between the nearest points of the two colliding bodies, in the world [m]."""
    ends = np.zeros(6)
    pairs = ((g, h) for g in bodies[0] for h in bodies[1])
    g, h = min(pairs, key=lambda p: mujoco.mj_geomDistance(model, data, *p, REACH, None))
    mujoco.mj_geomDistance(model, data, g, h, REACH, ends)
    return np.asarray(ends.reshape(2, 3).mean(axis=0))


def _cameras(place: Floats, far: float) -> Iterator[Camera]:
    for elevation in ELEVATIONS:
        up = math.radians(elevation)
        for azimuth in AZIMUTHS:
            a = math.radians(azimuth)
            x, y, z = place + far * np.array([math.cos(up) * math.cos(a), math.cos(up) * math.sin(a), math.sin(up)])
            yield Camera((x, y, z), (float(place[0]), float(place[1]), float(place[2])))


def _seen(model: Model, data: Data, camera: Camera, size: tuple[int, int]) -> list[_Seen]:
    """Rendered views of three groups of geoms, each alone: first all geoms but the two bodies that collide,
    then each of these bodies."""
    directions = rays_of(camera, *size)
    found = []
    for group in range(3):
        geom, distance, normal = cast(model, data, np.asarray(camera.eye), directions, only(group))
        away = np.linalg.norm(np.asarray(camera.eye) + directions * distance[:, None] - camera.target, axis=1)
        colour = _faded(shade(model, geom, normal, directions), np.where(geom >= 0, away, 0.0))
        found.append(_Seen(np.where(geom >= 0, distance, np.inf), colour))
    return found


def _depths(model: Model, data: Data, camera: Camera, size: tuple[int, int]) -> Iterator[Floats]:
    """Yield the distances of three groups of geoms as ``_seen`` has them, without their colours [m]."""
    directions = rays_of(camera, *size)
    for group in range(3):
        geom, distance, _ = cast(model, data, np.asarray(camera.eye), directions, only(group))
        yield np.where(geom >= 0, distance, np.inf)


def _faded(colour: Floats, away: Floats) -> Floats:
    """Colours (N, 3) that fade to grey with the distance (N,) from a point [m]."""
    near = np.exp(-away / LOCAL)[:, None]
    grey = 0.5 + 0.4 * colour.mean(axis=1, keepdims=True)
    return np.asarray(near * colour + (1 - near) * grey)


def _shown(model: Model, data: Data, camera: Camera) -> float:
    """Return the quality of a camera's view of two colliding bodies: pixels of the less visible one; a hidden pixel counts a quarter."""
    rest, *bodies = _depths(model, data, camera, COARSE)
    return min(float(np.where(b < rest, 1.0, 0.25)[np.isfinite(b)].sum()) for b in bodies)


def _blended(model: Model, data: Data, camera: Camera, size: tuple[int, int]) -> Floats:
    """Colours of the pixels (N, 3), 0 to 1, with both bodies seen through whatever hides them."""
    rest, one, other = _seen(model, data, camera, size)
    front = (one.distance <= other.distance)[:, None]
    near, behind = np.where(front, one.colour, other.colour), np.where(front, other.colour, one.colour)
    both = (one.hit & other.hit)[:, None]
    body = np.where(both, THROUGH * near + (1 - THROUGH) * behind, near)
    distance = np.minimum(one.distance, other.distance)
    hidden = (rest.distance < distance)[:, None]
    shown = np.where(hidden, THROUGH * rest.colour + (1 - THROUGH) * body, body)
    return np.where(np.isfinite(distance)[:, None], shown, rest.colour)


def _ring(size: tuple[int, int]) -> NDArray[np.bool_]:
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    radius = np.hypot(x, y) / height
    return np.asarray((RING[0] <= radius) & (radius <= RING[1]))
