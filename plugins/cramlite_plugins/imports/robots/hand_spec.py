"""Hand of a file as an MjSpec of its own: its colliding geoms, joints and drives under one body at the flange.

Physics stay those of the file: joints, tendons, equalities, actuators, contact parameters, masses. What only looks is left out, and
meshes become their convex hulls, as MuJoCo collides them.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Pose
from cramlite.plugin import UserError

from ..scenes.source import Source
from .model_text import hull_of

ROOT = "gripper"
"""The body at the flange; names of the hand's own elements begin with it and a slash."""
FLAT = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
MESH, FREE = int(mujoco.mjtGeom.mjGEOM_MESH), int(mujoco.mjtJoint.mjJNT_FREE)


def hand_spec(source: Source, at: Pose, last: int | None) -> Any:
    """Extract a hand from its file, as an MjSpec with the hand's bodies only.

    Args:
        at: of the hand's root in the flange; of the last link, where the hand is in the arm's own file.
        last: id of the arm's last link in that case; None for a file of its own.

    Raises:
        UserError: there is no hand behind the last link, or it uses what a body on a flange cannot have.
    """
    child = source.spec.copy()
    _state_inertia(child, child.compile())
    _drop_loose(child)
    spec = mujoco.MjSpec()
    spec.compiler.degree, spec.compiler.autolimits = False, True
    spec.option = child.option
    root = spec.worldbody.add_body(name=ROOT)
    frame = root.add_frame(pos=at.position, quat=at.quaternion)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of options that differ: the world's physics count
        if last is None:
            spec.attach(child, prefix=f"{ROOT}/", frame=frame)
        else:
            _attach_from_arm(source, child, frame, last)
        _simplify(source, spec)
    return spec


def _attach_from_arm(source: Source, child: Any, frame: Any, last: int) -> None:
    roots = [b for b in child.bodies if b.parent is not None and int(b.parent.id) == last and _moves(b)]
    if not roots:
        raise UserError(
            f"{source.path}: nothing moves behind the arm's last joint, so there is no hand in this file; state one by 'gripper': a name "
            "such as robotiq_2f85, or {file: hand.xml}."
        )
    for body in roots:
        frame.attach_body(body, f"{ROOT}/", "")


def _moves(body: Any) -> bool:
    return bool(body.joints) or any(_moves(b) for b in body.bodies)


def _state_inertia(spec: Any, model: Any) -> None:
    """State the masses of bodies explicitly, before visual shapes, which may have mass, are removed."""
    for body in spec.bodies:
        b = int(body.id)
        if b > 0 and model.body_mass[b] > 0:
            body.explicitinertial = True
            body.mass, body.ipos, body.iquat = float(model.body_mass[b]), model.body_ipos[b], model.body_iquat[b]
            body.inertia, body.fullinertia = model.body_inertia[b], np.full(6, np.nan)


def _drop_loose(spec: Any) -> None:
    """Remove elements that no hand needs: keyframes, sensors, lights, cameras, skins, planes and free joints."""
    for kind in ("keys", "sensors", "lights", "cameras", "skins"):
        for element in list(getattr(spec, kind)):
            spec.delete(element)
    for geom in list(spec.worldbody.geoms):
        if int(geom.type) in FLAT:
            spec.delete(geom)
    for joint in list(spec.joints):
        if int(joint.type) == FREE:
            spec.delete(joint)


def _simplify(source: Source, spec: Any) -> None:
    """Keep only shapes that collide, name each of them, and replace meshes by convex hulls that need no file."""
    for geom in list(spec.geoms):
        if not (geom.contype or geom.conaffinity):
            spec.delete(geom)
    try:
        model = spec.compile()
    except ValueError as error:
        raise UserError(f"{source.path}: MuJoCo does not take the hand alone: {' '.join(str(error).split())}.") from error
    for body in spec.bodies:
        body.gravcomp = 1.0
        if not body.name:
            body.name = f"{ROOT}/body_{body.id}"
    for geom in spec.geoms:
        geom.info, geom.name, geom.material = geom.name.removeprefix(f"{ROOT}/"), f"{ROOT}/{geom.id}", ""
        if int(geom.type) == MESH:
            geom.meshname = _hull(spec, model, int(geom.id))
    for kind in ("meshes", "materials", "textures"):
        for element in list(getattr(spec, kind)):
            if not element.name.startswith("hull_"):
                spec.delete(element)


def _hull(spec: Any, model: Any, geom: int) -> str:
    """Add the convex hull of a geom's mesh to the MuJoCo spec as a new mesh, in the coordinates of the mesh file, and return its name."""
    mesh = int(model.geom_dataid[geom])
    name = f"hull_{mesh}"
    if spec.mesh(name) is None:
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
        corners = hull_of(model, mesh) @ turn.reshape(3, 3).T + model.mesh_pos[mesh]
        spec.add_mesh(name=name, uservert=corners.ravel())
    return name


def moving_joints(where: Path, spec: Any) -> Iterator[Any]:
    """Yield the hinges and slides of a hand.

    Raises:
        UserError: it has a joint of another kind.
    """
    for joint in spec.joints:
        if int(joint.type) not in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)):
            raise UserError(f"{where}: joint '{joint.name}' of the hand is neither a hinge nor a slide; fingers have no others.")
        yield joint
