"""MJCF scene of known kinds of things at given poses; each model, with its joints, is the file from which the
library's entry was made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cramlite.model import Pose, Thing
from cramlite.plugin import load_yaml

from .at_rest import held_up, inside, settled

TABLE = (1.0, 1.6, 0.05)
"""Sides and thickness of the table that is assumed under the things [m]; its near side is ``BEHIND`` the robot's base."""
BEHIND = 0.05
RESTS = 0.02
"""Largest distance between the table as it is seen and the lowest point of a thing that rests on it [m]."""
LEVEL = 0.01
"""Largest difference of height of things that rest on one table [m]: of 118 seen things 112 were within 7 mm, the others, 16 to 37 mm
higher, rested on things."""


def files_of(library: Path) -> dict[str, Path]:
    """Return for each kind of thing in a library the model file from which its entry was made."""
    data: Any = load_yaml(library / "library.yaml")
    return {name: Path(entry["told"]["file"]) for name, entry in data["models"].items()}


class Placed(NamedTuple):
    """Thing of a known kind at a pose, with the values of its joints that are known [m, rad]."""

    kind: str
    pose: Pose
    joints: Mapping[str, float] = {}


def scene_of(
    found: Sequence[Placed], files: dict[str, Path], table: float, obstacles: Sequence[Thing] = ()
) -> tuple[str, list[float]]:
    """Place things on a table of some height [m], among obstacles; movable ones whose pose is below the table top are left out.

    The table is as high as the lowest points of things within ``RESTS`` of where it is seen, in the median; a movable thing within
    ``LEVEL`` of that stands on it, any other where it is seen. Fixed things keep the height at which they are seen: a stove may be let
    into the table, a rack may stand on feet that its collision shapes lack. What hovers is held up by a box, as it hides what it stands on.
    What would be inside of a fixed thing is none: a drawer's front may look like a book.

    Returns:
        The scene as MJCF, and its state, at rest. Things are named after their kinds and numbered, "plate_1_main".
    """
    import mujoco

    scene, standing = mujoco.MjSpec(), _standing(found, files, table)
    lows = [one.low for one in standing if abs(one.low) < RESTS]
    top = table + float(np.median(lows)) if lows else table
    half = [s / 2 for s in TABLE]
    body = scene.worldbody.add_body(name="table", pos=[half[0] - BEHIND, 0.0, top - half[2]])
    body.add_geom(name="table_top", type=mujoco.mjtGeom.mjGEOM_BOX, size=half, friction=[1.0, 0.005, 0.0001])
    for obstacle in obstacles:
        _add(obstacle, scene)
    named = _attached(scene, standing, table, top)
    model = scene.compile()
    state, held = settled(model, _at_joints(model, named))
    if none := [one for prefix, one in named.items() if any(name.startswith(prefix) for name in inside(model, state, held))]:
        return scene_of([one for one in found if not any(one is n for n in none)], files, table, obstacles)
    if hidden := held_up(model, state, held):
        for k, (middle, half) in enumerate(hidden, 1):
            scene.worldbody.add_body(name=f"hidden_{k}", pos=middle).add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
        state, _ = settled(scene.compile(), state)
    return scene.to_xml(), state.tolist()


class _Standing(NamedTuple):
    """Thing with its model, the pose of that in the scene, and the height of its lowest point over the table as it is seen [m], infinite
    if it is fixed."""

    placed: Placed
    spec: Any
    at: Pose
    low: float


def _standing(found: Sequence[Placed], files: Mapping[str, Path], table: float) -> list[_Standing]:
    """Return the things with their models, without movable ones that would be within the table."""
    import mujoco

    standing = []
    for one in found:
        spec, frame = _kind(files[one.kind])
        at = one.pose * frame.inverse()
        loose = any(j.type == mujoco.mjtJoint.mjJNT_FREE for j in spec.joints)
        low = _lowest(spec, at) - table
        if low > -RESTS or not loose:
            standing.append(_Standing(one, spec, at, low if loose else np.inf))
    return standing


def _attached(scene: Any, standing: Sequence[_Standing], table: float, top: float) -> dict[str, Placed]:
    """Attach models to a scene whose table is seen at one height and has its top at another one [m]; return each thing by the beginning of
    its bodies' names."""
    named: dict[str, Placed] = {}
    for one in standing:
        kind, (x, y, z) = one.placed.kind, one.at.position
        down = table + one.low - top if abs(table + one.low - top) < LEVEL else 0.0
        prefix = f"{kind}_{sum(p.kind == kind for p in named.values()) + 1}_"
        scene.attach(one.spec, prefix=prefix, frame=scene.worldbody.add_frame(pos=[x, y, z - down], quat=list(one.at.quaternion)))
        named[prefix] = one.placed
    return named


def _at_joints(model: Any, named: Mapping[str, Placed]) -> Any:
    """Return the state (nq,) of a compiled scene with its joints at the values that are known."""
    state = model.qpos0.copy()
    for prefix, one in named.items():
        for name, value in one.joints.items():
            state[model.joint(prefix + name).qposadr] = value
    return state


def _add(obstacle: Thing, scene: Any) -> None:
    """Add an obstacle to a scene, as one fixed body with convex shapes."""
    import mujoco

    body = scene.worldbody.add_body(name=obstacle.name, pos=list(obstacle.pose.position), quat=list(obstacle.pose.quaternion))
    for k, geom in enumerate(obstacle.geoms):
        mesh = scene.add_mesh(name=f"{obstacle.name}_{k}", uservert=np.ravel(geom.corners).tolist())
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, pos=list(geom.pose.position), quat=list(geom.pose.quaternion))


def _kind(file: Path) -> tuple[Any, Pose]:
    """Return one kind of thing without its purely visual geoms, and the frame of its first body with a
    shape, joints at zero."""
    import mujoco

    spec = mujoco.MjSpec.from_file(str(file))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    first = next(b for b in range(1, model.nbody) if model.body_geomnum[b])
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = data.xmat[first].reshape(3, 3), data.xpos[first]
    for geom in [g for g in spec.geoms if not g.contype and not g.conaffinity]:
        spec.delete(geom)
    used = {g.meshname for g in spec.geoms}
    for geom in spec.geoms:
        geom.material = ""
    for part in (*(m for m in spec.meshes if m.name not in used), *spec.materials, *spec.textures):
        spec.delete(part)
    for mesh in spec.meshes:
        mesh.file = str(file.parent / mesh.file)
    plain = mujoco.MjSpec()  # what a kind's own file says of solver, view and memory is not about the scene
    spec.option, spec.visual, spec.njmax, spec.nconmax = plain.option, plain.visual, plain.njmax, plain.nconmax
    return spec, Pose.from_matrix(frame)


def _lowest(spec: Any, at: Pose) -> float:
    """Height of the lowest corner of a model's collision shapes, with the model at a pose [m]."""
    import mujoco

    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    low = np.inf
    for g in range(model.ngeom):
        turn = data.geom_xmat[g].reshape(3, 3)
        size = model.geom_aabb[g]
        signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
        corners = data.geom_xpos[g] + (size[:3] + signs * size[3:]) @ turn.T
        low = min(low, float(at.apply(corners)[:, 2].min()))
    return low
