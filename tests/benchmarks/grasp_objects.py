"""Objects for the benchmark of grasps: primitives and meshes, each made by its seed and at rest on a table."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from msgspec.structs import replace

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.objects.products_and_fixtures import block, make
from cramlite_plugins.objects.vessels import bottle, bowl, can, mug

Rng = np.random.Generator
MASS = (0.05, 0.6)  # [kg]


def thing(seed: int) -> Thing:
    """The object of a seed, always the same one: kinds follow one another."""
    kind, rng = KINDS[seed % len(KINDS)], np.random.default_rng(seed)
    made = MAKERS[kind](rng, float(rng.uniform(*MASS)))
    yaw = Pose.from_rotvec((0.5, 0.0, 0.0), (0, 0, float(rng.uniform(-math.pi, math.pi))))
    return replace(made, pose=yaw * made.pose)


def kind(seed: int) -> str:
    return KINDS[seed % len(KINDS)]


def _block(rng: Rng, mass: float) -> Thing:
    size = (float(rng.uniform(0.02, 0.075)), float(rng.uniform(0.02, 0.12)), float(rng.uniform(0.05, 0.15)))
    return block("it", Pose((0, 0, size[2] / 2)), size, mass)


def _can(rng: Rng, mass: float) -> Thing:
    r, h = float(rng.uniform(0.015, 0.038)), float(rng.uniform(0.05, 0.15))
    lying = rng.random() < 0.4
    at = Pose.from_axes((0, 0, r), (0, 1, 0), (1, 0, 0)) if lying else Pose((0, 0, h / 2))
    return can("it", at, r, h, mass)


def _bottle(rng: Rng, mass: float) -> Thing:
    r, h = float(rng.uniform(0.015, 0.038)), float(rng.uniform(0.05, 0.15))
    neck, top = r * float(rng.uniform(0.35, 0.7)), float(rng.uniform(0.03, 0.07))
    return bottle("it", Pose((0, 0, h / 2)), r, h, neck, top, mass)


def _bowl(rng: Rng, mass: float) -> Thing:
    h = float(rng.uniform(0.035, 0.07))
    return bowl("it", Pose((0, 0, h / 2)), float(rng.uniform(0.05, 0.09)), h, mass=mass)


def _mug(rng: Rng, mass: float) -> Thing:
    h = float(rng.uniform(0.07, 0.11))
    return mug("it", Pose((0, 0, h / 2)), float(rng.uniform(0.032, 0.046)), h, mass=mass)


def _ball(rng: Rng, mass: float) -> Thing:
    r = float(rng.uniform(0.015, 0.038))
    return Thing("it", "cram:Product", Pose((0, 0, r)), (Geom("sphere", (r,)),), mass=mass)


def _cross(rng: Rng, mass: float) -> Thing:
    arm = float(rng.uniform(0.06, 0.12))
    across = Pose.from_axes((0, 0, 0), (0, 1, 0), (1, 0, 0))
    bars = (Geom("box", (arm, 0.012, 0.012)), Geom("cylinder", (0.012, arm / 2), across))
    return Thing("it", "cram:Product", Pose((0, 0, 0.012)), bars, mass=mass)


def _meshed(shape: Callable[[Rng], Any], lie: bool) -> Callable[[Rng, float], Thing]:
    """A function that makes an object from a mesh, through a file as a user would; ``lie``: in one of its three likeliest
    poses at rest."""

    def maker(rng: Rng, mass: float) -> Thing:
        mesh = shape(rng)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "it.stl"
            mesh.export(path)
            found = make("mesh", "it", Pose(), {"file": str(path), "mass": mass})
        return replace(found, pose=_resting(mesh, rng) if lie else Pose((0, 0, -float(mesh.bounds[0, 2]))), mesh=None)

    return maker


def _resting(mesh: Any, rng: Rng) -> Pose:
    transforms, _ = trimesh.poses.compute_stable_poses(mesh, n_samples=1, sigma=0.0)
    pose = Pose.from_matrix(transforms[int(rng.integers(min(3, len(transforms))))])
    return Pose((0.0, 0.0, pose.position[2]), pose.quaternion)


def _u(rng: Rng, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def _at(mesh: Any, by: tuple[float, float, float], axis: tuple[float, float, float] = (0, 0, 1), angle: float = 0.0) -> Any:
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
    mesh.apply_translation(by)
    return mesh


def _union(*meshes: Any) -> Any:
    return trimesh.boolean.union(meshes, engine="manifold")


def _less(mesh: Any, *tools: Any) -> Any:
    return trimesh.boolean.difference([mesh, *tools], engine="manifold")


def _cylinder(radius: float, height: float) -> Any:
    return trimesh.creation.cylinder(radius, height, sections=32)


def _tagged(rng: Rng) -> Any:
    """A carton with a tab that has a hole."""
    w, d, h, hole = _u(rng, 0.04, 0.10), _u(rng, 0.02, 0.06), _u(rng, 0.08, 0.15), _u(rng, 0.004, 0.008)
    tab = _at(trimesh.creation.box((0.04, 0.003, 0.05)), (0, 0, h / 2 + 0.012))
    drill = _at(_cylinder(hole, 0.2), (0, 0, h / 2 + 0.020), (1, 0, 0), math.pi / 2)
    return _less(_union(trimesh.creation.box((w, d, h)), tab), drill)


def _turned_bowl(rng: Rng) -> Any:
    """A bowl of revolution, its wall slanted and thin."""
    r, h, wall, foot = _u(rng, 0.045, 0.09), _u(rng, 0.03, 0.07), _u(rng, 0.003, 0.007), _u(rng, 0.4, 0.8)
    inner = foot * r
    return trimesh.creation.revolve(
        np.array([(0, 0), (inner, 0), (r, h), (r - wall, h), (inner - wall, wall), (0, wall)]), sections=32
    )


def _jug(rng: Rng) -> Any:
    """A cup with a round handle, wider than the gripper opens in half of the cases."""
    r, h, wall = _u(rng, 0.032, 0.055), _u(rng, 0.07, 0.13), 0.005
    shell = _union(
        trimesh.creation.annulus(r - wall, r, h, sections=32), _at(_cylinder(r - 1e-4, wall), (0, 0, (wall - h) / 2))
    )
    ring = trimesh.creation.torus(0.28 * h, 0.006, major_sections=24, minor_sections=12)
    ring = _less(_at(ring, (r + 0.016, 0, 0), (1, 0, 0), math.pi / 2), _cylinder(r - wall, 2 * h))
    return _union(shell, ring)


def _bracket(rng: Rng) -> Any:
    """An L of sheet with a hole in each leg."""
    a, b, w, t = _u(rng, 0.05, 0.12), _u(rng, 0.05, 0.12), _u(rng, 0.02, 0.06), _u(rng, 0.003, 0.010)
    legs = _union(_at(trimesh.creation.box((a, w, t)), (a / 2, 0, t / 2)), _at(trimesh.creation.box((t, w, b)), (t / 2, 0, b / 2)))
    return _less(
        legs, _at(_cylinder(0.004, 0.1), (0.7 * a, 0, 0)), _at(_cylinder(0.004, 0.05), (0, 0, 0.7 * b), (0, 1, 0), math.pi / 2)
    )


def _pipe(rng: Rng) -> Any:
    r = _u(rng, 0.015, 0.06)
    return trimesh.creation.annulus(r - _u(rng, 0.004, 0.009), r, _u(rng, 0.03, 0.12), sections=32)


def _hammer(rng: Rng) -> Any:
    length, r = _u(rng, 0.12, 0.22), _u(rng, 0.009, 0.016)
    head = _at(_cylinder(_u(rng, 0.014, 0.026), _u(rng, 0.06, 0.11)), (length, 0, 0), (1, 0, 0), math.pi / 2)
    return _union(_at(_cylinder(r, length), (length / 2, 0, 0), (0, 1, 0), math.pi / 2), head)


def _spray(rng: Rng) -> Any:
    """A bottle of revolution: foot, waist, shoulder, neck."""
    r, h = _u(rng, 0.024, 0.038), _u(rng, 0.10, 0.18)
    waist, neck = r * _u(rng, 0.65, 0.95), r * _u(rng, 0.3, 0.5)
    profile = [(0, 0), (r, 0), (r, 0.15 * h), (waist, 0.45 * h), (r, 0.7 * h), (neck, 0.82 * h), (neck, h), (0, h)]
    return trimesh.creation.revolve(np.array(profile), sections=32)


def _stone(rng: Rng) -> Any:
    """The convex hull of points in an ellipsoid."""
    points = rng.normal(size=(40, 3))
    points *= rng.uniform(0.018, 0.036, 3) / np.linalg.norm(points, axis=1)[:, None]
    return trimesh.convex.convex_hull(points)


MAKERS: dict[str, Callable[[Rng, float], Thing]] = {
    "block": _block, "can": _can, "bottle": _bottle, "bowl": _bowl, "mug": _mug, "ball": _ball, "cross": _cross,
    "mesh carton": _meshed(_tagged, lie=True), "mesh bowl": _meshed(_turned_bowl, lie=False),
    "mesh jug": _meshed(_jug, lie=True), "mesh bracket": _meshed(_bracket, lie=True), "mesh pipe": _meshed(_pipe, lie=True),
    "mesh hammer": _meshed(_hammer, lie=True), "mesh spray": _meshed(_spray, lie=True),
    "mesh stone": _meshed(_stone, lie=True),
}  # fmt: skip
KINDS = tuple(MAKERS)
