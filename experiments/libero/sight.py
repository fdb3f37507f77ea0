"""Scene that a picture of LIBERO's fixed camera shows: known kinds with their poses, and the table that bears
them.

Poses are in the frame of the robot's base, z up. The errors of a stereo camera and of a calibration are added here, by the seed of the
episode; the camera's pose is found again from the robot's own body in the picture, and from the table, which is level.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from cramlite import Engine, UserError
from cramlite.model import Camera, Depth, Geom, Intrinsics, Pose, RobotMount, Thing, Vector3, View, World, vector3
from cramlite.perception.active_perception import SURE, ask
from cramlite.perception.camera_check import camera_offset
from cramlite.perception.own_body import own_depth
from cramlite.perception.query import ObjectQuery
from cramlite.perception.recognition import thing_from_percept
from cramlite.perception.result import Percept
from cramlite.plugin import UNKNOWN
from cramlite_plugins.perception.values import Box
from cramlite_plugins.simulation.camera.noise import Noise, noisy_colour, noisy_depth

NOISE = Noise(disparity=0.029)
"""Noise of depth: 1.5 mm at 1 m, growing with the square; holes, edges, shadows and steps as of any stereo camera."""
CALIBRATION = (0.002, math.radians(0.3))
"""Standard deviation of the camera's place along each axis [m], and of its turn about each [rad]."""
REACH = ((0.15, 1.05), (-0.75, 0.75))
"""Bounds within which things are looked for [m]: x in front of the robot's base, and y."""
DEEP, HIGH = 0.05, 0.60
"""Depth below the table, and height above it, to which things are looked for [m]."""
SOLID = 0.5
"""Thickness of the table for perception [m]: no pose is so deep in it that it comes out at the other side."""
BIN, THICK, LEVEL = 0.004, 0.012, 0.9
"""Bin of heights [m], how far points of the table lie from the commonest height, and the least share of the vertical in its normal."""
SMALL = 0.06
"""Longest side of what is no obstacle [m]: some points at the edges of things."""


class Found(NamedTuple):
    """Thing that was recognised: kind, pose, confidence of that pose, and (name, value, standard deviation) of each joint [m, rad]."""

    kind: str
    pose: Pose
    confidence: float
    joints: tuple[tuple[str, float, float], ...]


def pictured(said: Mapping[str, Any], seed: int, number: int = 0) -> View:
    """Return the picture that a benchmark's answer to ``look`` holds, with the errors of a camera and of its calibration.

    Args:
        seed: of the calibration's errors, and of those of the first picture.
        number: of the picture; one without colours is grey.
    """
    steps = _png(said["depth"])
    rgb = _png(said["rgb"]) if "rgb" in said else np.full((*steps.shape, 3), 128, np.uint8)
    height, width = steps.shape
    fx, fy, cx, cy = said["intrinsics"]
    intrinsics = Intrinsics(fx, fy, cx, cy, width, height)
    depth = np.where(steps > 0, steps / 1e4, np.inf)
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = np.reshape(said["rotation"], (3, 3)), said["position"]
    rng = np.random.default_rng([seed, 2207])
    askew = Pose.from_rotvec(tuple(rng.normal(0, CALIBRATION[0], 3)), tuple(rng.normal(0, CALIBRATION[1], 3)))
    rng = np.random.default_rng([seed, 2207, number]) if number else rng
    seen = noisy_depth(depth, _cosines(depth, intrinsics), intrinsics, NOISE, rng)
    pixels = np.clip(np.rint(noisy_colour(rgb.astype(float), NOISE, rng)), 0, 255).astype(np.uint8)
    return View(pixels, seen.astype(np.float32), intrinsics, Pose.from_matrix(place) * askew, 0.0)


def _png(text: str) -> Any:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(base64.b64decode(text))))


def _cosines(depth: Any, intrinsics: Intrinsics) -> Any:
    """Cosine between each ray and the normal of what it hits, by differences of neighbouring pixels."""
    points = intrinsics.rays * np.where(np.isfinite(depth), depth, 0.0)[..., None]
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    lengths = np.linalg.norm(normal, axis=2) * np.linalg.norm(points, axis=2)
    return np.abs(np.einsum("ijk,ijk->ij", normal, points)) / np.maximum(lengths, 1e-12)


def levelled(view: View) -> tuple[View, float]:
    """Rotate a view about the camera's position until the table in it is level; return the view and the table's
    height [m].

    Raises:
        UserError: there is no table in the picture.
    """
    for _ in range(2):
        points = view.world_cloud[view.valid].astype(float)
        near = np.all([(points[:, k] > low) & (points[:, k] < high) for k, (low, high) in enumerate(REACH)], axis=0)
        points = points[near]
        if len(points) < 1000:
            raise UserError(f"The picture shows {len(points)} points within the robot's reach; at least 1000 are needed to find the table.")
        counts, edges = np.histogram(points[:, 2], np.arange(points[:, 2].min(), points[:, 2].max() + BIN, BIN))
        level = points[np.abs(points[:, 2] - edges[int(counts.argmax())] - BIN / 2) < THICK]
        centre = level.mean(axis=0)
        normal = np.linalg.svd((level - centre)[:: max(1, len(level) // 5000)], full_matrices=False)[2][2]
        normal = normal * np.sign(normal[2])
        if normal[2] < LEVEL:
            raise UserError(f"What the picture shows most of is no table: it slopes by {math.degrees(math.acos(normal[2])):.0f} deg.")
        axis = np.cross(normal, (0.0, 0.0, 1.0))
        there = Pose(view.camera.position)
        view = replace(view, camera=there * Pose.from_rotvec((0, 0, 0), tuple(axis)) * there.inverse() * view.camera)
    points = view.world_cloud[view.valid].astype(float)
    height = float(np.median(points[np.abs(points[:, 2] - edges[int(counts.argmax())]) < THICK][:, 2]))
    return view, height


def located(engine: Engine, view: View, mount: RobotMount) -> tuple[View, float, str]:
    """Correct the pose of a view's camera by the table in the picture, and by the robot, if it is known what this looks like;
    return the view, the table's height [m], and how far the camera was off, or why that is not known.

    Raises:
        UserError: there is no table in the picture.
    """
    level, table = levelled(view)
    if engine.knowledge.robots[mount.type].looks is None:
        return level, table, "it is not known what the robot looks like"
    offset, said = camera_offset(level, (), engine.knowledge, _own(engine, level, mount))
    return (*(levelled(replace(level, camera=offset.camera)) if offset else (level, table)), said)


def _own(engine: Engine, view: View, mount: RobotMount) -> Depth:
    return own_depth(World((), (mount,)), Camera(view.camera, intrinsics=view.intrinsics), engine.knowledge)


def seen(
    engine: Engine, view: View, table: float, kinds: Sequence[Thing], mount: RobotMount
) -> tuple[list[Found], list[Thing]]:
    """Return what a picture shows on a table, without the robot's own pixels: known kinds, and obstacles around what is none."""
    own = _own(engine, view, mount)
    said = _recognised(engine, view, table, kinds, own)
    there = [replace(t, name=f"{k}") for k, p in enumerate(said) if (t := thing_from_percept(p, kinds))]
    found = [
        Found(str(p.value("model")), t.pose, p.values["pose"].judged.confidence, p.value("joints", ()))
        for p, t in zip(said, there, strict=True)
    ]
    return found, obstacles(engine, view, table, there, own)


def around(table: float) -> tuple[Vector3, Vector3]:
    """Return the lowest and the highest corner of the box in which things are looked for on a table at a height [m]."""
    low, high = zip(*REACH, (table - DEEP, table + HIGH), strict=True)
    return vector3(low), vector3(high)


def _recognised(engine: Engine, view: View, table: float, kinds: Sequence[Thing], own: Depth) -> list[Percept]:
    query = ObjectQuery(wanted=("type", "pose", "model"))
    said = ask(query, view, (_table(table),), engine.knowledge, models=tuple(kinds), robot=own, region=Box(*around(table)))
    return [p for p in said.answers if p.value("type") != UNKNOWN and p.value("model") and p.value("pose")]


def again(
    engine: Engine, view: View, table: float, kinds: Sequence[Thing], believed: World
) -> tuple[list[Thing], list[Thing]]:
    """Return what a later picture shows on a table, in which the arm hides some of it: things of known kinds whose poses are sure, named
    after these, and obstacles around points of neither such things nor believed ones."""
    own = _own(engine, view, believed.robots[0])
    said = _recognised(engine, view, table, kinds, own)
    sure = [p for p in said if p.values["pose"].judged.confidence >= SURE]
    there = [t for p in sure if (t := thing_from_percept(p, kinds)) is not None]
    known = [*there, *(t for t in believed.things if t.name != "table")]
    return there, obstacles(engine, view, table, [replace(t, name=f"{k}") for k, t in enumerate(known)], own)


def obstacles(engine: Engine, view: View, table: float, known: Sequence[Thing], own: Depth) -> list[Thing]:
    """Return bodies around what a picture shows within reach that neither known things nor the robot explain."""
    fixed, loose = ([t for t in known if t.furniture == kind] for kind in (True, False))
    under, wanted = _table(table), ObjectQuery(wanted=("obstacles",))
    rest = ask(wanted, view, (under, *fixed), engine.knowledge, recognised=tuple(loose), robot=own)
    return [body for body in rest.scene["obstacles"].value if _in_the_way(body)] if "obstacles" in rest.scene else []


def _table(height: float) -> Thing:
    half = (0.6, 1.0, SOLID / 2)
    return Thing("table", "soma:Table", Pose((0.5, 0.0, height - half[2])), (Geom("box", half),))


def _in_the_way(body: Thing) -> bool:
    """Whether an obstacle is within reach, and more than a few points."""
    inside = all(low < v < high for v, (low, high) in zip(body.pose.position, REACH, strict=False))
    return inside and 2 * max(v for g in body.geoms for v in g.half_extents) > SMALL
