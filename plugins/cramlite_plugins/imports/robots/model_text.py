"""The arm of a file as MJCF text with the names that ``cramlite.model.Robot`` lists, and one of our grippers on its flange.

Angles in the text are those of the Denavit-Hartenberg table. Shapes are those of the file that collide; capsules become cylinders of
their volume (docs/explanation/simulation.md says why), meshes their convex hulls, as MuJoCo collides them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Pose, Value

from ...robots.universal_robots import UR5E_INERTIA, WRIST
from ..scenes.geoms import collides
from ..scenes.source import Source
from .chain import Chain, pose_of
from .dh_table import Table, reach_of

KINDS = {"SPHERE": "sphere", "ELLIPSOID": "ellipsoid", "CYLINDER": "cylinder", "CAPSULE": "cylinder", "BOX": "box", "MESH": "mesh"}
ARMATURE = 0.1  # of joints whose file has less [kg m2]: our servos are stable with it
ALWAYS = 0.9  # share of random postures in which shapes that overlap by construction do
SAMPLES = 50


class RigidPart(Value):
    """Bodies of the file that are fixed to each other: they move with one joint, or stand still.

    Args:
        name: of the first of them.
        bodies: their ids, the first one first.
        place: of the first one, in the frame of the part before, all joints at the file's zero.
    """

    name: str
    bodies: tuple[int, ...]
    place: Pose


class Posed(Value):
    """Compiled model of a robot file, with all joints of the arm at zero.

    ``urdf`` is whether the file is a URDF whose root link became the world body.
    """

    urdf: bool
    model: Any
    data: Any

    def body(self, b: int) -> Pose:
        """Return the pose of a body in the world."""
        return pose_of(self.data.xpos[b], self.data.xmat[b])


def posed(source: Source, chain: Chain) -> Posed:
    """Compute where the parts of a robot file's model are when all joints of the arm are at zero."""
    data = mujoco.MjData(source.model)
    for b in chain.bodies:
        data.qpos[source.model.jnt_qposadr[source.model.body_jntadr[b]]] = 0.0
    mujoco.mj_kinematics(source.model, data)
    mujoco.mj_comPos(source.model, data)
    return Posed(source.urdf, source.model, data)


def parts_of(at_zero: Posed, chain: Chain) -> tuple[RigidPart, ...]:
    """Return the rigid parts of an arm, its base and its links, each with its pose in the part before it."""
    model, first = at_zero.model, (chain.base, *chain.bodies)
    found = []
    for k, b in enumerate(first):
        before = at_zero.body(first[max(k - 1, 0)])
        fixed = [b] if b == chain.bodies[-1] or b == 0 else [b, *_fixed(model, b)]
        found.append(RigidPart(("base_link", *chain.links)[k], tuple(fixed), before.inverse() * at_zero.body(b)))
    return tuple(found)


def _fixed(model: Any, body: int) -> Iterator[int]:
    """Bodies that are fixed to a body, directly or through others, without a joint between."""
    for b in range(1, model.nbody):
        if int(model.body_parentid[b]) == body and not model.body_jntnum[b]:
            yield b
            yield from _fixed(model, b)


def write_model(
    name: str, at_zero: Posed, chain: Chain, table: Table, tool: tuple[str, str], apart: tuple[tuple[str, str], ...]
) -> tuple[str, tuple[str, ...]]:
    """Write the MJCF text of an arm that was read from a file, with a gripper on its flange.

    Args:
        tool: (element for the flange, elements beside worldbody) of the gripper.
        apart: pairs of bodies that never meet, beside those that the file excludes.

    Returns:
        the text, and what is said of shapes that overlap by construction.
    """
    parts = parts_of(at_zero, chain)
    known = {*apart, *_excluded(at_zero.model, parts)}
    pairs = _overlapping(_text(name, at_zero, chain, table, parts, tool, sorted(known)), {p.name for p in parts}, table, chain)
    said = tuple(f"'{a}' and '{b}' overlap in the file in almost every posture: contacts between them are left out" for a, b in pairs)
    return _text(name, at_zero, chain, table, parts, tool, sorted({*known, *pairs})), said


def is_drawn(at_zero: Posed, chain: Chain) -> bool:
    """Check whether a robot file has purely visual shapes of its arm."""
    return any(not collides(at_zero.model, g) for part in parts_of(at_zero, chain) for g in _own(at_zero, part))


def write_looks(name: str, at_zero: Posed, chain: Chain, table: Table, tool: tuple[str, str]) -> str:
    """Write the MJCF text of an arm as cameras see it: with the purely visual shapes of its file, where a part has some.

    Args:
        tool: (element for the flange, elements beside worldbody) of the gripper.
    """
    return _text(name, at_zero, chain, table, parts_of(at_zero, chain), tool, (), seen=True)


def _excluded(model: Any, parts: Sequence[RigidPart]) -> Iterator[tuple[str, str]]:
    """Yield the pairs of an arm's rigid parts between which the robot file excludes contacts."""
    owner = {b: p.name for p in parts for b in p.bodies}
    for signature in model.exclude_signature:
        a, b = owner.get(int(signature) >> 16), owner.get(int(signature) & 0xFFFF)
        if a and b and a != b:
            yield a, b


def _text(
    name: str, at_zero: Posed, chain: Chain, table: Table, parts: Sequence[RigidPart], tool: tuple[str, str],
    apart: Iterable[tuple[str, str]], *, seen: bool = False,
) -> str:  # fmt: skip
    meshes: dict[str, str] = {}
    inner = f'<site name="flange" {_place(at_zero.body(chain.bodies[-1]).inverse() * at_zero.body(chain.base) * table.last)}/>{tool[0]}'
    for k in reversed(range(len(parts))):
        part = parts[k]
        joint = _joint(at_zero.model, chain, table, k - 1) + _inertial(at_zero, part) if k else ""
        shape = "".join(_geoms(at_zero, part, meshes, seen))
        inner = f'<body name="{part.name}" {_place(part.place)} gravcomp="{min(k, 1)}">{joint}{shape}{inner}</body>'
    pairs = (("base_link", parts[1].name), *apart)
    skip = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in pairs)
    assets = "".join(f'<mesh name="{n}" {attributes}/>' for n, attributes in meshes.items())
    return (
        f'<mujoco model="{name}"><compiler angle="radian" autolimits="true"/><asset>{assets}</asset>'
        f"<worldbody>{inner}</worldbody><actuator>{_servos(at_zero.model, chain, table)}</actuator>"
        f"<contact>{skip}</contact>{tool[1]}</mujoco>"
    )


def _joint(model: Any, chain: Chain, table: Table, k: int) -> str:
    """MJCF of a joint whose angles are those of the Denavit-Hartenberg table: ``ref`` is its angle at the
    file's zero."""
    j = int(model.body_jntadr[chain.bodies[k]])
    (low, high), zero = chain.limits[k], table.zeros[k]
    damping = float(model.dof_damping[model.jnt_dofadr[j]])
    armature = max(float(model.dof_armature[model.jnt_dofadr[j]]), ARMATURE)
    return (
        f'<joint name="{chain.joints[k]}" pos="{numbers(model.jnt_pos[j])}" axis="{numbers(model.jnt_axis[j])}" ref="{zero:.12g}"'
        f' range="{low + zero:.12g} {high + zero:.12g}" damping="{damping:.9g}" armature="{armature:.9g}"/>'
    )


def _servos(model: Any, chain: Chain, table: Table) -> str:
    """Return position servos for an arm's joints as MJCF, with a stiffness that grows with the arm's inertia."""
    count = len(chain.joints)
    mass = float(sum(model.body_mass[b] for b in chain.bodies))
    stiff = 2000.0 * max(1.0, mass * reach_of(table, chain.limits) ** 2 / UR5E_INERTIA)
    lines = []
    for k, (joint, torque, zero, limits) in enumerate(zip(chain.joints, chain.torques, table.zeros, chain.limits, strict=True)):
        kp = stiff if k < count - 3 else WRIST[1] * max(1.0, torque / WRIST[0])
        low, high = (v + zero for v in limits)
        lines.append(
            f'<position name="{joint}" joint="{joint}" kp="{kp:.9g}" kv="{0.04 * kp:.9g}" ctrlrange="{low:.12g} {high:.12g}"'
            f' forcerange="{-torque} {torque}"/>'
        )
    return "".join(lines)


def _inertial(at_zero: Posed, part: RigidPart) -> str:
    """Mass, centre of mass and inertia of all bodies of a rigid part together, in the frame of its first body."""
    model, data, frame = at_zero.model, at_zero.data, at_zero.body(part.bodies[0])
    masses = model.body_mass[list(part.bodies)]
    mass = float(masses.sum())
    centre = masses @ data.xipos[list(part.bodies)] / mass
    total = np.zeros((3, 3))
    for b in part.bodies:
        turn, off = data.ximat[b].reshape(3, 3), data.xipos[b] - centre
        total += turn @ np.diag(model.body_inertia[b]) @ turn.T + model.body_mass[b] * (off @ off * np.eye(3) - np.outer(off, off))
    own = frame.rotation.T @ total @ frame.rotation
    full = (own[0, 0], own[1, 1], own[2, 2], own[0, 1], own[0, 2], own[1, 2])
    where = frame.rotation.T @ (centre - np.array(frame.position))
    return f'<inertial pos="{numbers(where)}" mass="{mass:.9g}" fullinertia="{numbers(full)}"/>'


def _own(at_zero: Posed, part: RigidPart) -> list[int]:
    """Geoms of a rigid part."""
    own_world = part.bodies[0] > 0 or at_zero.urdf  # an MJCF's world is the room, not the arm's base
    return [g for g in range(at_zero.model.ngeom) if own_world and int(at_zero.model.geom_bodyid[g]) in part.bodies]


def _seen(at_zero: Posed, part: RigidPart) -> list[int]:
    """Geoms that a camera sees of a rigid part: the purely visual ones, or those that collide if it has no others."""
    own = _own(at_zero, part)
    return [g for g in own if not collides(at_zero.model, g)] or own


def _geoms(at_zero: Posed, part: RigidPart, meshes: dict[str, str], seen: bool) -> Iterator[str]:
    """Geoms of a rigid part as MJCF, those that collide or those that are ``seen``; ``meshes`` collects the attributes of meshes."""
    model, data, back = at_zero.model, at_zero.data, at_zero.body(part.bodies[0]).inverse()
    chosen = _seen(at_zero, part) if seen else [g for g in _own(at_zero, part) if collides(model, g)]
    for k, g in enumerate(chosen):
        kind = mujoco.mjtGeom(int(model.geom_type[g])).name.removeprefix("mjGEOM_")
        if kind not in KINDS:
            continue
        size = model.geom_size[g].copy()
        if kind == "CAPSULE":
            size[1] += 2 / 3 * size[0]
        if kind == "MESH":
            mesh = f"mesh_{int(model.geom_dataid[g])}"
            if mesh not in meshes:
                meshes[mesh] = (_surface if seen else _hull)(model, int(model.geom_dataid[g]))
        own = f'mesh="{mesh}"' if kind == "MESH" else f'size="{numbers(size)}"'
        place = back * pose_of(data.geom_xpos[g], data.geom_xmat[g])
        contacts = ' contype="0" conaffinity="0"' if seen else ""
        yield (
            f'<geom name="{part.name}/{k}" type="{KINDS[kind]}" {own} {_place(place)} rgba="{numbers(model.geom_rgba[g])}" mass="0"'
            f"{contacts}/>"
        )


def _hull(model: Any, mesh: int) -> str:
    return f'vertex="{numbers(hull_of(model, mesh).ravel())}"'


def _surface(model: Any, mesh: int) -> str:
    """Vertices and triangles of a mesh, in the frame of its inertia, as MJCF attributes."""
    corner, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    points = model.mesh_vert[corner : corner + int(model.mesh_vertnum[mesh])]
    faces = model.mesh_face[face : face + int(model.mesh_facenum[mesh])]
    return f'inertia="shell" vertex="{" ".join(f"{v:.7g}" for v in points.ravel())}" face="{" ".join(map(str, faces.ravel()))}"'


def hull_of(model: Any, mesh: int) -> Floats:
    """Return the corners of the convex hull of a mesh, (n, 3), in the frame of its inertia [m]."""
    from scipy.spatial import ConvexHull, QhullError

    start = int(model.mesh_vertadr[mesh])
    points = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])].astype(float)
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return np.asarray(points)


def _overlapping(text: str, parts: set[str], table: Table, chain: Chain) -> tuple[tuple[str, str], ...]:
    """Pairs of links that are in contact in almost every posture."""
    model = mujoco.MjModel.from_xml_string(text)
    data, counted = mujoco.MjData(model), Counter[tuple[str, str]]()
    low, high = (np.array(v) + table.zeros for v in zip(*chain.limits, strict=True))
    for q in np.random.default_rng(0).uniform(low, high, (SAMPLES, len(low))):
        data.qpos[: len(q)] = q
        mujoco.mj_forward(model, data)
        bodies = {tuple(sorted(model.body(model.geom_bodyid[g]).name for g in data.contact[c].geom)) for c in range(data.ncon)}
        counted.update((a, b) for a, b in bodies if {a, b} <= parts)
    return tuple(pair for pair, count in sorted(counted.items()) if count >= ALWAYS * SAMPLES)


def _place(pose: Pose) -> str:
    return f'pos="{numbers(pose.position)}" quat="{numbers(pose.quaternion)}"'


def numbers(values: Iterable[float]) -> str:
    """Return numbers as an attribute of a model file, with 12 digits."""
    return " ".join(f"{float(v):.12g}" for v in values)
