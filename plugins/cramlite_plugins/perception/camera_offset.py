"""Expert that finds a camera whose pose differs from the believed one, from the fixtures and the robot in its picture.

Measured points near fixtures, and near the robot where its joints put it, are registered to their surfaces, point to plane with
Tukey's weights (Chen and Medioni, IVC 10, 1992; Beaton and Tukey, Technometrics 16, 1974); what these do not tell, such as a shift
along the only table in the picture, stays as believed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from cramlite.model import CameraOffset, Floats, Pose, Value
from cramlite.plugin import Expert, Inputs, Judged, Parameter, Unresolvable, hookimpl

from .own_surface import OwnSurface
from .segmentation.surroundings import facing_distances

Surface = Callable[[Floats, Floats], tuple[Floats, Floats]]
"""Function from points (N, 3) and their camera rays to the signed distances (N,) [m] from a surface's side that faces the camera, and
its normals there (N, 3), world frame."""

PRIMITIVES = ("box", "cylinder", "capsule", "sphere")
BLOCK = 40
"""Side of a block of the image in which errors of depth belong together [pixel]: matching and lenses err over such patches."""


class _Points(Value, eq=False):
    """Measured points near surfaces (N, 3), with camera rays, standard deviations [m], and the square block
    of the image that each is in."""

    at: Floats
    rays: Floats
    spread: Floats
    blocks: Any


def camera_offset(inputs: Inputs) -> Mapping[str, Any]:
    """Estimate how far a camera is from its believed pose, from the fixtures and the robot in its picture.

    Raises:
        Unresolvable: too little of them is in the picture, or what is there is not where any near pose would see it.
    """
    limits, view = inputs.parameters, inputs["view"]
    points, surfaces = _near(inputs, _surfaces(inputs))
    centre = points.at.mean(axis=0)
    prior = _prior(np.array(view.camera.position) - centre, limits)
    whole = _registered(points, surfaces, centre, prior, limits)
    points, surfaces = _clear(points, whole, surfaces, limits)
    whole = _registered(points, surfaces, centre, prior, limits)
    away, j, weight = _linear(points, whole, centre, surfaces, limits["last_m"])
    used = weight > 0
    if used.mean() < limits["share"]:
        share = f"{100 * used.mean():.0f} % of {len(used)} points near fixtures and robot are on their surfaces"
        raise Unresolvable(f"even at the camera pose that fits best, only {share}")
    start = np.abs(_linear(points, Pose(), centre, surfaces, limits["reach_m"])[0])
    covariance, open_ = _covariance(points, away, j, weight, prior)
    found = _judged(view.camera, whole, centre, covariance, points, used, limits)
    offset = CameraOffset(*found[:4], float(np.median(start[used])), float(np.median(np.abs(away[used]))), *found[4:], open_)
    return {"camera_offset": Judged(offset, float(used.mean()), _said(offset))}


def _surfaces(inputs: Inputs) -> list[Surface]:
    """Surfaces whose places are known: those of fixtures, and that of the robot where it would be seen."""
    solids = [(g, t.pose * g.pose) for t in inputs["fixtures"] if t.joint is None for g in t.geoms if g.shape in PRIMITIVES]
    own = OwnSurface.of(inputs["view"], inputs.get("robot"))
    return [partial(facing_distances, g, p) for g, p in solids] + ([own.distances] if own else [])


def _measured(inputs: Inputs) -> Any:
    """Indices of pixels, ``most`` of all and ``most`` of those on which the robot would be seen."""
    most, own = int(inputs.parameters["most"]), inputs.get("robot")
    masks = [inputs["cloud"].mask] + ([np.isfinite(own) & inputs["view"].valid] if own is not None else [])
    return np.unique(np.concatenate([i[:: max(1, len(i) // most)] for i in map(np.flatnonzero, masks)]))


def _near(inputs: Inputs, surfaces: Sequence[Surface]) -> tuple[_Points, list[Surface]]:
    """Points of a subsample of the picture that are within ``reach_m`` of a surface, and the surfaces that have at least five of
    these points."""
    cloud, view, limits = inputs["cloud"], inputs["view"], inputs.parameters
    index = _measured(inputs)
    at, eye = cloud.points.reshape(-1, 3)[index].astype(float), np.array(view.camera.position)
    rays = at - eye
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    depth = view.depth.reshape(-1)[index].astype(float)
    distances = [np.abs(surface(at, rays)[0]) for surface in surfaces]
    near = np.min(distances, axis=0) < limits["reach_m"] if distances else np.zeros(len(at), bool)
    if near.sum() < limits["least"]:
        few = f"{int(near.sum())} of {len(at)} measured points are near fixtures and robot"
        raise Unresolvable(f"{few}; at least {limits['least']:.0f} are needed to locate the camera")
    kept = [s for s, d in zip(surfaces, distances, strict=True) if (d < limits["reach_m"]).sum() >= 5]
    row, column = np.divmod(index[near], view.depth.shape[1])
    blocks = (row // BLOCK) * 1000 + column // BLOCK
    spread = np.hypot(limits["rough_m"], limits["noise"] * depth[near] ** 2)
    return _Points(at[near], rays[near], spread, blocks), kept


def _registered(points: _Points, surfaces: Sequence[Surface], centre: Floats, prior: Floats, limits: Mapping[str, float]) -> Pose:
    """Motion of the camera's points that brings them onto the surfaces, by Gauss-Newton steps.

    Points farther off than a limit have no weight; the limit shrinks from ``reach_m`` to ``last_m``.
    """
    whole = Pose()
    for scale in np.geomspace(limits["reach_m"], limits["last_m"], int(limits["iterations"])):
        away, j, weight = _linear(points, whole, centre, surfaces, scale)
        step = np.linalg.solve(j.T @ (weight[:, None] * j) + prior, -j.T @ (weight * away) - prior @ _twist(whole, centre))
        whole = _about(centre, np.asarray(step, float)) * whole
    return whole


def _clear(
    points: _Points, whole: Pose, surfaces: Sequence[Surface], limits: Mapping[str, float]
) -> tuple[_Points, list[Surface]]:
    """Points that a camera sees on surfaces, and these; surfaces that other things hide or surround are left out.

    A surface is kept if most of the points nearest to it lie on it.

    Others are left out: a thing that hangs on a peg has points near the peg, which do not tell where
    the camera is.
    """
    at, rays = whole.apply(points.at), whole.rotate(points.rays)
    distances = np.array([np.abs(surface(at, rays)[0]) for surface in surfaces])
    nearest, on = distances.argmin(axis=0), distances.min(axis=0) < limits["last_m"]
    clear = [k for k in range(len(surfaces)) if (own := nearest == k).sum() >= limits["part"] and on[own].mean() >= limits["clear"]]
    kept = np.isin(nearest, clear)
    if kept.sum() < limits["least"]:
        raise Unresolvable(f"things hide or surround fixtures and robot: {int(kept.sum())} points are on what nothing hides")
    return _Points(points.at[kept], points.rays[kept], points.spread[kept], points.blocks[kept]), [surfaces[k] for k in clear]


def _linear(
    points: _Points, whole: Pose, centre: Floats, surfaces: Sequence[Surface], scale: float
) -> tuple[Floats, Floats, Floats]:
    """Return the distances of points to the surfaces, the derivatives of these distances by a small rotation
    and shift of the points, and Tukey weights."""
    at, rays = whole.apply(points.at), whole.rotate(points.rays)
    best, normal = np.full(len(at), np.inf), np.zeros((len(at), 3))
    for surface in surfaces:
        away, n = surface(at, rays)
        nearer = np.abs(away) < np.abs(best)
        best[nearer], normal[nearer] = away[nearer], n[nearer]
    j = np.column_stack([np.cross(at - centre, normal), normal])
    weight = np.where(np.abs(best) < scale, (1 - (best / scale) ** 2) ** 2, 0.0) / (points.spread**2)
    return best, j, weight / max(1.0, len(at) / len(np.unique(points.blocks)))


def _prior(eye: Floats, limits: Mapping[str, float]) -> Floats:
    """Prior information matrix of a small motion of the camera (twist about the points' mean), from the errors of its
    position and angle."""
    lever = np.array([[0, -eye[2], eye[1]], [eye[2], 0, -eye[0]], [-eye[1], eye[0], 0]])
    moves = np.hstack([-lever, np.eye(3)])  # what the camera moves by
    turns = np.hstack([np.eye(3), np.zeros((3, 3))])
    return np.asarray(moves.T @ moves / limits["prior_m"] ** 2 + turns.T @ turns / limits["prior_rad"] ** 2)


def _about(centre: Floats, twist: Floats) -> Pose:
    turn = Pose.from_rotvec((0, 0, 0), tuple(twist[:3].tolist()))
    return Pose(tuple((centre - turn.rotate(centre) + twist[3:]).tolist()), turn.quaternion)


def _twist(whole: Pose, centre: Floats) -> Floats:
    return np.concatenate([whole.rotvec, whole.apply(centre) - centre])


def _covariance(points: _Points, away: Floats, j: Floats, weight: Floats, prior: Floats) -> tuple[Floats, int]:
    """Covariance of the camera's estimated motion, and the number of directions in which the prior is more
    certain than the points.

    The covariance is that of noise and of the residuals of each block of the image.
    """
    from scipy.linalg import eigh

    data = j.T @ (weight[:, None] * j)
    pull = [j[own].T @ (weight[own] * away[own]) for b in np.unique(points.blocks) if (own := points.blocks == b).any()]
    inverse = np.linalg.inv(data + prior)
    told = eigh(data, prior, eigvals_only=True)
    return inverse @ np.array(pull).T @ np.array(pull) @ inverse + inverse, int((told < 1).sum())


def _judged(
    believed: Pose, whole: Pose, centre: Floats, covariance: Floats, points: _Points, used: Any, limits: Mapping[str, float]
) -> tuple[Pose, Pose, float, float, float, bool]:
    """Return the corrected pose of a camera, its motion from the believed pose, and whether it was moved.

    Between the last two come the standard deviations of position [m] and angle [rad], and the points' shift
    [m].
    """
    camera = whole * believed
    eye = np.array(believed.position) - centre
    lever = np.array([[0, -eye[2], eye[1]], [eye[2], 0, -eye[0]], [-eye[1], eye[0], 0]])
    moves = np.hstack([-lever, np.eye(3)])
    position = math.sqrt(float(np.trace(moves @ covariance @ moves.T)))
    angle = math.sqrt(float(np.trace(covariance[:3, :3])))
    shift = math.sqrt(float(((whole.apply(points.at[used]) - points.at[used]) ** 2).sum(axis=1).mean()))
    twist = _twist(whole, centre)
    sure = float(twist @ np.linalg.solve(covariance, twist)) > limits["chance"]
    return camera, believed.inverse() * camera, position, angle, shift, bool(sure and shift > limits["off_m"])


def _said(offset: CameraOffset) -> str:
    position, angle = offset.moved.distance(Pose())
    return (
        f"the camera is {1000 * position:.1f} mm (+-{1000 * offset.position:.1f}) and {math.degrees(angle):.2f} deg "
        f"(+-{math.degrees(offset.angle):.2f}) from where it is believed: fixtures and robot are seen {1000 * offset.before:.1f} mm off, "
        f"and {1000 * offset.after:.1f} mm with it moved" + (f"; {offset.open} of 6 directions are undetermined" if offset.open else "")
    )


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("reach_m", 0.040, "a camera that is off by 25 mm and 1 deg, at .8 m"),
        Parameter("last_m", 0.008, "three times the noise of depth at 1 m; what stands on a table is farther away"),
        Parameter("iterations", 16, "it moves less than .1 mm afterwards, measured"),
        Parameter("most", 4000, "points: 20 a block of the image"),
        Parameter("least", 400, "points, a tenth of them"),
        Parameter("share", 0.35, "of the points near fixtures: else they are of something else"),
        Parameter("clear", 0.6, "of the points near a part of a fixture lie on it, or it does not count"),
        Parameter("part", 20, "points of a part of a fixture that counts: fewer lie on it by chance"),
        Parameter("noise", 0.0025, "per metre, of inverse depth, as for segments"),
        Parameter("rough_m", 0.001, "how true fixtures are to their shapes"),
        Parameter("prior_m", 0.020, "a camera that was taken off and put back"),
        Parameter("prior_rad", 0.035, "2 deg: the same"),
        Parameter("chance", 22.5, "squared length of six standard normal numbers that one of a thousand exceeds"),
        Parameter("off_m", 0.006, "twice the hand-eye error that programs are proven for (error model)"),
    )
    return [
        Expert("fixture_registration", "how far the camera is from where it is believed", ("view", "cloud", "fixtures"),
               ("camera_offset",), camera_offset, uses=("robot",), cost_ms=60.0, parameters=parameters),
    ]  # fmt: skip
