"""Parts of an MJCF file's model that its joints move: triangles of its visual mesh, and geoms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from cramlite.model import Floats, Joint, KindJoint, Pose, Vector3, vector3

if TYPE_CHECKING:
    from ..scenes.source import Source

ENDLESS = np.pi
"""Range of a hinge without ends, to each side [rad]; a slide without ends moves nothing here."""
Counted = Sequence[tuple[int, int]]
"""(geom of the file, how many triangles or geoms it became), in their order."""


def kind_joints(source: Source, root: int, frame: Pose, corners: Floats, triangles: Counted, geoms: Counted) -> tuple[KindJoint, ...]:
    """Return the hinges and slides that move a part of a model against its first body, in the order of their bodies.

    Args:
        root: first body that has a shape, whose frame is that of the model.
        frame: of the model, in the world.
        corners: (F, 3, 3) of all triangles [m].
    """
    found = []
    for j in range(source.model.njnt):
        moved = _carried(source.model, int(source.model.jnt_bodyid[j]))
        faces = tuple(_ranges(source.model, moved, triangles))
        joint = _joint(source, j, frame)
        if joint is not None and root not in moved and faces:
            own = tuple(k for first, last in _ranges(source.model, moved, geoms) for k in range(first, last))
            found.append(KindJoint(source.model.joint(j).name or f"joint {j}", joint, faces, own, _lever(joint, corners, faces)))
    return tuple(found)


def _lever(joint: Joint, corners: Floats, faces: Sequence[tuple[int, int]]) -> float:
    """Return the greatest distance of what a hinge moves from its axis [m]; 1 for a slide."""
    if joint.kind == "slide":
        return 1.0
    points = np.concatenate([corners[first:last].reshape(-1, 3) for first, last in faces])
    return float(np.linalg.norm(joint.pose.inverse().apply(points)[:, :2], axis=1).max())


def _carried(model: Any, body: int) -> set[int]:
    """Return a body, and those that it carries."""
    found = {body}
    for b in range(body + 1, model.nbody):
        if int(model.body_parentid[b]) in found:
            found.add(b)
    return found


def _ranges(model: Any, bodies: set[int], counted: Counted) -> Iterator[tuple[int, int]]:
    first = 0
    for geom, count in counted:
        if int(model.geom_bodyid[geom]) in bodies and count:
            yield first, first + count
        first += count


def _joint(source: Source, j: int, frame: Pose) -> Joint | None:
    """Return a hinge or slide whose z axis is the joint's, in the model's frame; None for another joint."""
    model, data = source.model, source.data
    kinds = {int(mujoco.mjtJoint.mjJNT_SLIDE): "slide", int(mujoco.mjtJoint.mjJNT_HINGE): "hinge"}
    kind = kinds.get(int(model.jnt_type[j]))
    low, high = (float(v) for v in (model.jnt_range[j] if model.jnt_limited[j] else (-ENDLESS, ENDLESS)))
    if kind is None or (kind == "slide" and not model.jnt_limited[j]):
        return None
    axis = frame.inverse().rotate(data.xaxis[j])
    pose = Pose.from_axes(_place(frame, data.xanchor[j]), tuple(axis), tuple(np.eye(3)[int(np.abs(axis).argmin())]))
    return Joint("slide" if kind == "slide" else "hinge", pose, low, high, float(data.qpos[model.jnt_qposadr[j]]))


def _place(frame: Pose, point: Any) -> Vector3:
    return vector3(frame.inverse().apply(point))
