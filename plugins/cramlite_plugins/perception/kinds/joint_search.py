"""Joints of a recognised kind: the values at which what they move agrees best with the depth image."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace
from scipy.optimize import minimize_scalar

from cramlite.model import Floats, Mask, MeshFile, Pose, Value, View

from ..pose.model import PoseModel
from ..pose.outline import tolerance
from ..pose.registration import JointValue
from .appearance import Appearance
from .joint_states import displaced, step_of
from .reading import Reading
from .region import Region
from .registered import again

POINTS = 600
STEP = 0.01
"""Distance by which neighbouring values of the first search displace a point, at most [m]: within the depth image's tolerance."""
FALL = 0.05
"""Share of the best agreement that is lost one standard deviation beside it."""
AS_WELL = 0.97
"""Share of the best agreement with which another stand agrees as well."""
NEAR = 0.005
"""Difference of values below which the model's surface is not made anew [m of displacement]: half the depth image's tolerance."""


class Stand(Value, eq=False):
    """Pose of a model, the values of its joints, and their standard deviations."""

    pose: Pose
    values: tuple[float, ...]
    doubts: tuple[float, ...]


def settled(region: Region, reading: Reading) -> Reading:
    """Return an explanation with the model's joints at the values that the picture shows, registered once more.

    Where the picture does not fit better so, the explanation is as before.
    """
    appearance = reading.appearance
    before = tuple(_mesh(appearance).joint_values.values())
    stand = searched(region, appearance, reading.pose, both=True)
    if _moved(appearance, before, stand.values):
        there = at_values(appearance, stand.values)
        better = again(region, there, stand.pose, _said(there))
        if better is None or better.score < reading.score:
            return reading
        reading = better
    stand = searched(region, reading.appearance, reading.pose, both=False)
    shut = _shut(region, reading.appearance, reading.pose, stand.values)
    return replace(reading, pose=shut.pose, joints=_named(reading.appearance, replace(stand, values=shut.values)))


def searched(region: Region, appearance: Appearance, pose: Pose, *, both: bool) -> Stand:
    """Search each joint of a model along its range, one after another.

    Args:
        both: search also with what a joint moves kept in its place, so that the rest of the model moves, and judge by both.
    """
    mesh, doubts = _mesh(appearance), list[float]()
    values = list(mesh.joint_values.values())
    for k, moving in enumerate(mesh.joints):
        own, now = moving.joint, values[k]
        count = max(3, math.ceil(moving.lever * (own.upper - own.lower) / STEP))
        ways = [(_agreement(region, appearance, pose, k, values, kept=kept, whole=both), kept) for kept in (False, True)[: 1 + both]]
        found = [(_best(agrees, own.lower, own.upper, count, now), kept) for agrees, kept in ways]
        (value, _, doubt), kept = max(found, key=lambda f: f[0][1])
        if moving.lever * abs(value - own.value) < region.scene.limits["shut_m"]:
            value, kept = own.value, False
        pose = pose * step_of(mesh, appearance.moved, k, values, value).inverse() if kept else pose
        values[k] = value
        doubts.append(doubt)
    return Stand(pose, tuple(values), tuple(doubts))


def _shut(region: Region, appearance: Appearance, pose: Pose, values: tuple[float, ...]) -> Stand:
    """Return a stand in which several drawers are shut that were all open by the same little, if it agrees as well: then not they moved,
    but the whole was registered too far back or forth along them.

    Args:
        pose: of the model with its joints as the appearance has them.
        values: of the joints as they were found.
    """
    found = Stand(pose, values, ())
    there = shut_together(_mesh(appearance), pose, values, 2 * region.scene.limits["shut_m"])
    return there if there and _agrees(region, appearance, there) >= AS_WELL * _agrees(region, appearance, found) else found


def shut_together(mesh: MeshFile, pose: Pose, values: Sequence[float], most: float) -> Stand | None:
    """Return the stand of a model that is moved along its drawers by what several of them are open by, which are shut then; None if no two
    are open by the same.

    Args:
        most: by which a drawer may be open that may be shut [m].
    """
    slides = [k for k, j in enumerate(mesh.joints) if j.joint.kind == "slide"]
    slides = [k for k in slides if _parallel(mesh.joints[slides[0]].step(1.0), mesh.joints[k].step(1.0))]
    off = {k: values[k] - mesh.joints[k].joint.value for k in slides}
    alike = [k for k in slides if NEAR < abs(off[k]) < most]
    same = [k for k in alike if abs(off[k] - off[alike[0]]) < NEAR]
    if len(same) < 2:
        return None
    by = float(np.mean([off[k] for k in same]))
    nearer = (v if k not in slides else mesh.joints[k].joint.value if k in same else v - by for k, v in enumerate(values))
    first = mesh.joints[same[0]]
    return Stand(pose * first.step(first.joint.value + by), tuple(nearer), ())


def _parallel(one: Pose, other: Pose) -> bool:
    a, b = np.array(one.position), np.array(other.position)
    return bool(np.dot(a, b) > 0.99 * np.linalg.norm(a) * np.linalg.norm(b))


def _agrees(region: Region, appearance: Appearance, stand: Stand) -> float:
    """How well a whole model agrees with a region, in points."""
    surface, view = appearance.surface, region.scene.picture.view
    points, normals = displaced(_mesh(appearance), appearance.moved, stand.values, surface.points, surface.normals)
    those, seen = _some(np.ones(len(points), bool)), view.camera.inverse() * stand.pose
    return _agreeing(view, region, seen.apply(points[those]), seen.rotate(normals[those]))


def _moved(appearance: Appearance, before: Sequence[float], after: Sequence[float]) -> bool:
    """Whether values of joints differ by more than a registration evens out."""
    return any(j.lever * abs(a - b) > NEAR for j, a, b in zip(_mesh(appearance).joints, after, before, strict=True))


def _named(appearance: Appearance, stand: Stand) -> tuple[JointValue, ...]:
    names = (j.name for j in _mesh(appearance).joints)
    return tuple(zip(names, stand.values, stand.doubts, strict=True))


def _mesh(appearance: Appearance) -> MeshFile:
    mesh = appearance.model.mesh
    assert mesh is not None  # a model with joints has one
    return mesh


def at_values(appearance: Appearance, values: Sequence[float]) -> Appearance:
    """Return the appearance of a model with its joints at other values, with the points that were seen at the present ones."""
    mesh, surface = _mesh(appearance), appearance.surface
    points, normals = displaced(mesh, appearance.moved, values, surface.points, surface.normals)
    there = PoseModel(surface.name, surface.type, points.astype(np.float32), normals.astype(np.float32), features=surface.features)
    model = appearance.model.at_joints(dict(zip((j.name for j in mesh.joints), values, strict=True)))
    return replace(appearance, model=model, surface=there)


def _agreement(
    region: Region, appearance: Appearance, pose: Pose, k: int, values: Sequence[float], *, kept: bool, whole: bool
) -> Callable[[float], float]:
    """Function from a value of the k-th joint to how well what it moves agrees with the region, in points.

    Args:
        kept: what the joint moves stays where it is, and the rest of the model moves.
        whole: the rest counts, too.
    """
    mesh, surface, view = _mesh(appearance), appearance.surface, region.scene.picture.view
    points, normals = displaced(mesh, appearance.moved, values, surface.points, surface.normals)
    in_camera, own = view.camera.inverse() * pose, appearance.moved[k]
    moves, stays = _some(~own if kept else own), _some(own if kept else ~own)

    def agreeing(at: Pose, those: Any) -> float:
        return _agreeing(view, region, at.apply(points[those]), at.rotate(normals[those]))

    still = agreeing(in_camera, stays) if whole else 0.0

    def agrees(value: float) -> float:
        step = step_of(mesh, appearance.moved, k, values, value)
        return still + agreeing(in_camera * (step.inverse() if kept else step), moves)

    return agrees


def _some(those: Mask) -> Any:
    """Return indices of at most some ``POINTS`` of the points that a mask has."""
    found = np.flatnonzero(those)
    return found[:: max(1, len(found) // POINTS)]


def _agreeing(view: View, region: Region, seen: Floats, normals: Floats) -> float:
    """Number of points (N, 3) in the optical frame that a region shows, the more the nearer they are to its surface, less those
    behind which the picture shows something."""
    pixels = view.intrinsics.project(seen)
    inside = np.isfinite(pixels).all(1) & (pixels > -0.5).all(1)
    inside &= (pixels[:, 0] < view.intrinsics.width - 0.5) & (pixels[:, 1] < view.intrinsics.height - 0.5)
    inside &= np.einsum("ij,ij->i", normals, seen) < -0.1 * np.linalg.norm(seen, axis=1)
    column, row = np.rint(pixels[inside]).astype(int).T
    z = seen[inside, 2]
    off = (view.depth[row, column] - z) / (2 * tolerance(z.astype(np.float32)))
    agreeing = np.clip(1.0 - off * off, 0.0, None) * region.mask[row, column]
    return float(np.nansum(agreeing)) - int(np.count_nonzero(off > 1))


def _best(agrees: Callable[[float], float], low: float, high: float, count: int, now: float) -> tuple[float, float, float]:
    """Return the value with the greatest agreement, that agreement, and the value's standard deviation."""
    grid = np.linspace(low, high, count + 1)
    rates = np.array([agrees(v) for v in grid])
    k, step = int(rates.argmax()), (high - low) / count
    ends = max(low, grid[k] - step), min(high, grid[k] + step)
    sharp = minimize_scalar(lambda v: -agrees(v), bounds=ends, method="bounded", options={"xatol": step / 20})
    best, most = max([(now, agrees(now)), (float(sharp.x), -float(sharp.fun))], key=lambda f: f[1])
    near = [abs(float(v) - best) for v in grid[rates > (1 - FALL) * most]]
    return best, most, max([*near, step / 4])


def _said(appearance: Appearance) -> tuple[str, ...]:
    mesh = _mesh(appearance)
    return tuple(f"joint '{j.name}' at {_in_words(j.joint.kind, mesh.joint_values[j.name])}" for j in mesh.joints)


def _in_words(kind: str, value: float) -> str:
    return f"{1000 * value:.0f} mm" if kind == "slide" else f"{math.degrees(value):.0f} deg"
