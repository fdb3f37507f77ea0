"""States of known kinds with joints: those in which a kind is looked for, and what of its surface each joint moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cramlite.model import Floats, KindJoint, Mask, MeshFile, Pose, Thing

from ...shapes.skins import Skin
from ..pose.registration import JointValue

APART = 0.08
"""Distance by which neighbouring states displace a point [m], at least: registration draws in what is half of that off. A joint that moves
less, such as a knob's, is looked for in the state of the file alone."""


def states_of(model: Thing) -> list[Thing]:
    """Return a known model in the states in which it is looked for: as its file has it, and with one joint elsewhere in its range."""
    joints = model.mesh.joints if model.mesh is not None else ()
    return [model, *(model.at_joints({j.name: v}) for j in joints for v in _values(j))]


def _values(moving: KindJoint) -> Iterator[float]:
    """Yield values between that of a joint in its file, and each end of its range."""
    own = moving.joint
    for end in (own.lower, own.upper):
        count = int(moving.lever * abs(end - own.value) / APART + 1e-6)
        yield from (own.value + (end - own.value) * k / count for k in range(1, count + 1))


def moved_by(joints: Sequence[KindJoint], skin: Skin, points: Floats, normals: Floats) -> Mask:
    """Return which of a surface's points (N, 3) each of J joints moves, (J, N)."""
    found = np.zeros((len(joints), len(points)), bool)
    if joints:
        face = skin.triangles_at(points, normals)[0]
        for k, moving in enumerate(joints):
            for first, last in moving.faces:
                found[k] |= (face >= first) & (face < last)
    return found


def displaced(mesh: MeshFile, moved: Mask, values: Sequence[float], points: Any, normals: Any) -> tuple[Floats, Floats]:
    """Return points (N, 3) and normals of a mesh's surface with its joints at other values than now."""
    points, normals = np.array(points, float), np.array(normals, float)
    now = tuple(mesh.joint_values.values())
    steps = [(k, j.step(now[k]).inverse()) for k, j in enumerate(mesh.joints)]
    steps += [(k, j.step(values[k])) for k, j in reversed([*enumerate(mesh.joints)])]
    for k, step in steps:
        points[moved[k]], normals[moved[k]] = step.apply(points[moved[k]]), step.rotate(normals[moved[k]])
    return points, normals


def step_of(mesh: MeshFile, moved: Mask, k: int, values: Sequence[float], value: float) -> Pose:
    """Return the displacement of what the k-th joint moves, in the mesh's frame, when the joint goes to a value.

    Args:
        moved: (J, N) points that each joint moves.
        values: of all joints now.
    """
    before = Pose()
    for j in range(k):
        if (moved[j] & moved[k]).any():  # it carries the k-th joint
            before = before * mesh.joints[j].step(values[j])
    moving = mesh.joints[k]
    return before * moving.step(value) * moving.step(values[k]).inverse() * before.inverse()


def unsettled(model: Thing) -> tuple[JointValue, ...]:
    """Return the joints of a model in one of its states, each known to half the distance of neighbouring states."""
    if model.mesh is None:
        return ()
    values = model.mesh.joint_values
    return tuple((j.name, values[j.name], APART / 2 / j.lever) for j in model.mesh.joints)
