"""Things of a world: their shapes, features, meshes and contents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ..geometry import Pose, Vector3
from .joint import Joint
from .kind_joint import KindJoint
from .looks import Looks


class Contact(Value):
    """MuJoCo's contact parameters of a geom, as a file states them, in MuJoCo's units and with its defaults.

    Two geoms that both have them meet by MuJoCo's own rule; with any other geom, friction is that of ``pair_friction``.

    Args:
        condim: 1, 3, 4 or 6 dimensions.
        torsional, rolling: friction coefficients [m].
        priority: the higher one's parameters are taken.
        solref, solimp: of its constraint solver.
        solmix: weight in the mean of both.
        margin, gap: [m].
    """

    condim: int = 3
    torsional: float = 0.005
    rolling: float = 0.0001
    priority: int = 0
    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float, float, float] = (0.9, 0.95, 0.001, 0.5, 2.0)
    solmix: float = 1.0
    margin: float = 0.0
    gap: float = 0.0


class Geom(Value):
    """Convex part of a thing's shape.

    Args:
        shape: box, cylinder, capsule (both along local z), sphere, or the convex hull of ``corners``.
        size: box half-extents; (radius, half-length) of cylinder and capsule; (radius,) of a sphere; for a convex hull
            half-extents of the box around it, which is centred on the geom's origin [m].
        pose: in the thing's frame.
        part: the name of the feature that this geom belongs to; empty for the body itself.
        friction: sliding friction coefficient; None takes the thing's.
        rgba: colour for pictures.
        corners: of a convex hull, in the geom's frame [m]; empty for the primitives.
        contact: further contact parameters, where a file states them; None takes this simulation's.
    """

    shape: Literal["box", "cylinder", "capsule", "sphere", "convex"]
    size: tuple[float, ...]
    pose: Pose = Pose()
    part: str = ""
    friction: float | None = None
    rgba: tuple[float, float, float, float] = (0.6, 0.6, 0.65, 1.0)
    corners: tuple[Vector3, ...] = ()
    contact: Contact | None = None

    @property
    def half_extents(self) -> Vector3:
        """Half side lengths of the geom's bounding box, along the geom's own axes [m]."""
        if self.shape in ("box", "convex"):
            return (self.size[0], self.size[1], self.size[2])
        radius = self.size[0]
        along = radius if self.shape == "sphere" else self.size[1] + (radius if self.shape == "capsule" else 0.0)
        return (radius, radius, along)

    @property
    def bounding_radius(self) -> float:
        """Radius of the geom's bounding sphere, whose centre is the geom's origin [m]."""
        if self.shape == "convex":
            return max(math.hypot(*c) for c in self.corners)
        return sum(self.size) if self.shape == "capsule" else math.hypot(*self.size)


class Inertia(Value):
    """Inertia of a thing whose geoms would give a wrong one.

    Args:
        centre: of mass, in the thing's frame [m].
        moments: (xx, yy, zz, xy, xz, yz) about the centre, axes of the thing's frame [kg m2].
    """

    centre: Vector3
    moments: tuple[float, float, float, float, float, float]


class MeshFile(Value):
    """Visual mesh of a thing, which is drawn; in collisions the thing's geoms stand for it.

    Args:
        path: of an STL, OBJ, PLY, OFF or GLB file; an OBJ's material and a GLB may have a texture.
        scale: from the file's unit to metres.
        up: direction of the thing's frame that usually points up; None where nobody says.
        joints: that move parts of it, each after what it carries: a door before its lever.
        values: of these joints, where they do not stand as in the file [m, rad].
    """

    path: str
    scale: float = 1.0
    up: Vector3 | None = None
    joints: tuple[KindJoint, ...] = ()
    values: tuple[float, ...] = ()

    @property
    def joint_values(self) -> dict[str, float]:
        """Return the values at which the mesh's joints stand, by name [m, rad]."""
        values = self.values or tuple(j.joint.value for j in self.joints)
        return dict(zip((j.name for j in self.joints), values, strict=True))


class Feature(Value):
    """Functional part of a thing: a hole, a peg, its tip, a surface, a cavity.

    Args:
        name: unique within the thing, e.g. "peg".
        type: class as a CURIE, e.g. "vrps:Peg".
        pose: in the thing's frame; z is the functional axis (along a peg towards its tip,
            through a hole, out of a surface, out of a container's opening).
        size: named lengths [m], e.g. {"radius": 0.003, "length": 0.138}.
    """

    name: str
    type: str
    pose: Pose = Pose()
    size: dict[str, float] = field(default_factory=dict)


class Filling(Value):
    """Granular content of a thing's cavity at the start, or of its surface, where it has no cavity: small balls.

    Args:
        count: how many balls.
        radius: of each [m].
        mass: of each [kg].
        friction: sliding friction coefficient.
    """

    count: int
    radius: float
    mass: float
    friction: float = 0.4


class Thing(Value):
    """Object of the world.

    Args:
        name: unique in the world.
        type: class as a CURIE, e.g. "shop:Hanger".
        pose: in the world frame.
        geoms, features: in the thing's frame.
        mass: [kg]; None for things that are fixed to the world.
        friction: sliding friction coefficient of its geoms.
        inertia: how the mass is spread; None spreads it evenly over the geoms.
        mesh: what the thing looks like; None where its geoms say it all.
        joint: how it moves against what carries it; None for things that stand free or are fixed.
        filling: what is loose in its cavity, or on its surface, at the start; None for nothing.
        max_grip_force: that each finger may press it with [N]; None where nobody says.
        parts: things of which a model with joints consists, in its frame, the fixed one first and each after its carrier; () for a thing
            that is one piece.
        notes: what was changed or concluded when the thing was made, for people: a mesh that was closed, a hole found.
        looks: words for its shape and colours, where its model tells them.
    """

    name: str
    type: str
    pose: Pose
    geoms: tuple[Geom, ...]
    features: tuple[Feature, ...] = ()
    mass: float | None = None
    friction: float = 0.6
    inertia: Inertia | None = None
    mesh: MeshFile | None = None
    notes: tuple[str, ...] = ()
    joint: Joint | None = None
    filling: Filling | None = None
    max_grip_force: float | None = None
    parts: tuple[Thing, ...] = ()
    looks: Looks = Looks()

    @property
    def least_friction(self) -> float:
        """Smallest sliding friction coefficient of the thing's geoms, without those of parts such as a tab."""
        own = [self.friction if g.friction is None else g.friction for g in self.geoms if not g.part]
        return min(own, default=self.friction)

    @property
    def movable(self) -> bool:
        """Whether the thing can move: it has a mass, and is not fixed to the world."""
        return self.mass is not None

    @property
    def furniture(self) -> bool:
        """Whether the thing is furniture, which the map for perception contains: it is fixed, or mounted on a
        joint, as a drawer is."""
        return not self.movable or self.joint is not None

    def moved_to(self, pose: Pose, carrier: Pose | None = None) -> Thing:
        """Return the thing at another pose, and, if it is on a joint, with the joint value of that pose.

        Args:
            carrier: displacement of what it is mounted in, in the world frame; None where that has not moved.
        """
        if self.joint is None:
            return replace(self, pose=pose)
        value = self.joint.value + self.joint.between(self.pose if carrier is None else carrier * self.pose, pose)
        return replace(self, pose=pose, joint=replace(self.joint, value=value))

    def allowed(self, pose: Pose, carrier: Pose | None = None) -> Pose:
        """Return the pose nearest to another one that the thing's joint allows; the other one itself if it is on none.

        Args:
            carrier: displacement of the body that the joint is mounted on, in the world frame; None where that has not moved.
        """
        if self.joint is None:
            return pose
        joint, start = self.joint, self.pose if carrier is None else carrier * self.pose
        by = joint.between(start, pose)
        return joint.moved(start, min(max(joint.value + by, joint.lower), joint.upper) - joint.value)

    def at_joints(self, values: Mapping[str, float]) -> Thing:
        """Return the thing with joints of its mesh at other values [m, rad], and their geoms; joints that are not named stay."""
        if self.mesh is None or not self.mesh.joints:
            return self
        before, geoms = self.mesh.joint_values, list(self.geoms)
        after = {**before, **values}
        steps = [(j, j.step(before[j.name]).inverse()) for j in self.mesh.joints]
        for moving, step in (*steps, *((j, j.step(after[j.name])) for j in reversed(self.mesh.joints))):
            for k in moving.geoms:
                geoms[k] = replace(geoms[k], pose=step * geoms[k].pose)
        return replace(self, geoms=tuple(geoms), mesh=replace(self.mesh, values=tuple(after[j.name] for j in self.mesh.joints)))

    def as_parts(self) -> tuple[Thing, ...]:
        """Return the things of which a model with joints consists, with its joints where they stand; only the thing itself without any.

        The first has the model's name, the others have it before their own.
        """
        if not self.parts:
            return (self,)
        names = {p.name: f"{self.name}_{p.name}" for p in self.parts} | {self.parts[0].name: self.name}
        values, joints = (self.mesh.joint_values, self.mesh.joints) if self.mesh else ({}, ())
        steps = {j.part: j.step(values[j.name]) for j in joints if j.part}
        carried, found = dict[str, Pose](), list[Thing]()
        for part in self.parts:
            parent = part.joint.parent if part.joint else ""
            carrier = carried.get(parent, Pose())
            carried[part.name] = carrier * steps.get(part.name, Pose())
            at = part.moved_to(carried[part.name] * part.pose, carrier)
            joint = at.joint and replace(at.joint, parent=names.get(parent, parent))
            found.append(replace(at, name=names[part.name], pose=self.pose * at.pose, joint=joint))
        return (replace(found[0], type=self.type, max_grip_force=self.max_grip_force), *found[1:])

    def feature(self, type_: str) -> Feature | None:
        """Return the first feature whose class is exactly ``type_``; None if there is none."""
        return next((f for f in self.features if f.type == type_), None)
