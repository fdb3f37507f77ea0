"""First sightings: when the cameras of a run first see the things whose poses were unknown."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from cramlite.model import Floats, Intrinsics, Pose

from ...shapes.bounds import corners
from ..camera.ray_tracer import cast
from ..model.compile import Compiled
from ..model.index import Data

PERIOD = 0.1  # a camera that stands looks so often [s]; a D435 takes 30 images a second
STILL = (0.05, 0.13)
"""Largest speed of a camera that counts as standing [m/s, rad/s], as where a robot takes its pictures: in an exposure of 10 ms half a
pixel of a D435 (1/385 rad), and the translation that shows as much at 0.4 m."""
PIXELS = 60  # of a thing in the image: the least of which perception makes a segment (perception/segments.py, "pixels")
RAYS = 400  # are cast at a thing: of PIXELS of a small one each has its own, of larger ones each stands for more


class Sight:
    """Detector of first sightings, for worlds in which things are known once they are seen; without effect in
    others.

    A camera looks where it stands, as a robot's does: what it sees in passing, nobody has looked at.

    Args:
        compiled: the model.
    """

    def __init__(self, compiled: Compiled) -> None:
        self._compiled = compiled
        world = compiled.world
        unknown = [t for t in world.things if t.movable] if world.poses == "camera" else []
        self.seen = {t.name: math.inf for t in unknown}
        self._corners = {t.name: corners(t, Pose()) for t in unknown}
        self._intrinsics = {c.name: c.intrinsics for c in world.cameras}
        self._last: dict[str, tuple[float, Pose]] = {}
        self._looked: dict[str, float] = {}

    def look(self, data: Data, cameras: Mapping[str, Pose], time: float) -> None:
        """Record the time at which a camera first sees each thing.

        Args:
            cameras: name -> optical frame in the world.
            time: since the start [s]; it rises from call to call.
        """
        unseen = [n for n, since in self.seen.items() if math.isinf(since)]
        for name, camera in cameras.items() if unseen else ():
            stands = name not in self._last or _stands(*self._last[name], time, camera)
            self._last[name] = time, camera
            if not stands or time < self._looked.get(name, -math.inf) + PERIOD - 1e-9:
                continue
            self._looked[name] = time
            for thing in unseen:
                if self._pixels(data, thing, camera, self._intrinsics[name]) >= PIXELS:
                    self.seen[thing] = min(time, self.seen[thing])

    def _pixels(self, data: Data, thing: str, camera: Pose, intrinsics: Intrinsics) -> float:
        """Number of pixels of a camera's image that show a thing; estimated from a part of the pixels if the
        thing is large in the image."""
        body = self._compiled.things[thing].body
        pose = Pose(tuple(data.xpos[body]), tuple(data.xquat[body]))
        columns, rows = _window(intrinsics, camera.inverse().apply(pose.apply(self._corners[thing])))
        stride = max(1, math.isqrt(len(columns) * len(rows) // RAYS))
        rays = intrinsics.rays[rows.start : rows.stop : stride, columns.start : columns.stop : stride].reshape(-1, 3)
        if not len(rays):
            return 0.0
        ways = camera.rotate(rays / np.linalg.norm(rays, axis=1)[:, None])
        hit, _, _ = cast(self._compiled.model, data, np.asarray(camera.position), ways)
        owners = self._compiled.owners
        count = sum(owners[g].kind == "thing" and owners[g].name == thing for g in hit[hit >= 0].tolist())
        return float(count * stride * stride)


def _stands(before: float, was: Pose, now: float, camera: Pose) -> bool:
    way, turn = was.distance(camera)
    return way <= STILL[0] * (now - before) and turn <= STILL[1] * (now - before)


def _window(intrinsics: Intrinsics, points: Floats) -> tuple[range, range]:
    """Ranges of columns and rows of pixels that contain the projected points (optical frame); all pixels if
    some points are beside or behind the camera."""
    width, height = intrinsics.width, intrinsics.height
    ahead = points[:, 2] > 0
    if not ahead.any():
        return range(0), range(0)
    if not ahead.all():
        return range(width), range(height)
    low, high = (f(intrinsics.project(points), axis=0) for f in (np.min, np.max))
    first, last = np.floor(low).astype(int), np.ceil(high).astype(int) + 1
    return range(max(0, first[0]), min(width, last[0])), range(max(0, first[1]), min(height, last[1]))
