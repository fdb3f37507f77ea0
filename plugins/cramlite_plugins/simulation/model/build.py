"""A world as an MjSpec, thing by thing.

Contact: robots 1/7, products 2/7, furniture 4/3 (contype/conaffinity), as measured in
docs/explanation/simulation.md, except that a robot meets itself too.
In a planning model everything but robots and what they carry is furniture, so that ``data.ncon == 0`` means
exactly: no robot touches anything.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Contact, Geom, Inertia, Joint, Physics, Pose, Robot, RobotMount, Thing, Value, World
from cramlite.plugin import UserError, nearest

from ...shapes.bounds import bounds, volume
from .hand_model import HANDS
from .index import Model

ROBOT, PRODUCT, FURNITURE = (1, 7), (2, 7), (4, 3)
SHAPES = {
    "box": (mujoco.mjtGeom.mjGEOM_BOX, 3),
    "cylinder": (mujoco.mjtGeom.mjGEOM_CYLINDER, 2),
    "capsule": (mujoco.mjtGeom.mjGEOM_CAPSULE, 2),
    "sphere": (mujoco.mjtGeom.mjGEOM_SPHERE, 1),
    "convex": (mujoco.mjtGeom.mjGEOM_MESH, 3),
}
# Contact time constant of things [s]; the least that holds is two time steps. With MuJoCo's 0.02 a product that falls
# 0.4 m onto a 10 mm floor sinks in by 28 mm and stays there (46 of 60 drops); with 0.005 by 8 mm, and it comes out
# (measured).
SOLREF = (0.005, 1.0)
ROLLING = frozenset({"cylinder", "capsule", "sphere"})
"""Shapes that have rolling friction (condim 6) where they can be moved, a lever of 0.1 mm as MuJoCo has it: a bottle of 26 mm radius
then rolls as on wood, with .004 of its weight. Without it one that lay in a drawer crept 29 mm in 13 s, by the rounding of contact normals
(measured). What hangs on a fixed round peg swings as before."""
STICKS = 0.05
"""Inertia that a joint must have for its dry friction to hold [kg m2 for a Nm, kg for a N]. MuJoCo's friction is soft: a torque of
its limit turns the joint by (1 - d) / (b I), which with the default impedance d = 0.9 and damping b = 100 / s is 0.02 rad/s for so
much. A knob of 50 g with 20 Nm of friction was turned without effort before (measured)."""
ALONG = "along"
"""Part of the name of the joint along a thread."""
THREAD = (0.99, 0.999)
"""Impedance of a thread's constraint: with MuJoCo's 0.9 a lid of 60 g sank by 0.3 mm (measured)."""
CONES = {"elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC, "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL}


ROUNDING = 1e-9
"""Distance or angle by which a joint may start outside its range: poses are rounded [m, rad]."""


class Carried(Value):
    """A thing that a planning model fixes to a robot's tool.

    Args:
        robot: name of the mount.
        pose: of the thing in the tool (tcp) frame.
    """

    robot: str
    pose: Pose


def check(world: World, robots: Mapping[str, Robot]) -> None:
    """Check a world for input that MuJoCo would refuse or silently accept.

    Raises:
        UserError: a name, type, size, mass or friction cannot be used.
    """
    names: set[str] = set()
    for name in [*(t.name for t in world.things), *(m.name for m in world.robots)]:
        if not name or "/" in name or name in names or name in ("world", "effector", *HANDS):
            why = "is used twice" if name in names else "is empty, reserved, or has a '/'"
            raise UserError(f"world: the name '{name}' {why}; every thing and robot needs a name of its own")
        names.add(name)
    for mount in world.robots:
        if mount.type not in robots:
            hint = nearest(mount.type, robots)
            raise UserError(f"robot '{mount.name}': there is no robot type '{mount.type}'; {hint}")
    for thing in world.things:
        _check_thing(thing)
        _check_joint(thing, world)


def _check_thing(thing: Thing) -> None:
    if not thing.geoms:
        raise UserError(
            f"thing '{thing.name}' has no geoms; give it at least one box, cylinder, capsule, sphere or convex"
        )
    if thing.mass is not None and not 1e-4 <= thing.mass < 1e4:
        raise UserError(f"thing '{thing.name}': mass {thing.mass} kg; it must lie between 0.0001 and 10000 kg")
    for i, geom in enumerate(thing.geoms):
        where = f"thing '{thing.name}', geom {i}"
        if geom.shape not in SHAPES:
            raise UserError(f"{where}: there is no shape '{geom.shape}'; {nearest(geom.shape, SHAPES)}")
        count = SHAPES[geom.shape][1]
        if len(geom.size) != count or not all(0 < s < 100 for s in geom.size):
            raise UserError(f"{where}: a {geom.shape} needs {count} positive size(s) in metres, not {geom.size}")
        if (geom.shape == "convex") != (len(geom.corners) >= 4):
            raise UserError(
                f"{where}: a {geom.shape} has {len(geom.corners)} corners; the shape 'convex' has 4 or more, others have none"
            )
        friction = thing.friction if geom.friction is None else geom.friction
        if not 0 <= friction < 100:
            raise UserError(f"{where}: friction {friction:g}; it must lie between 0 and 100")


def _check_joint(thing: Thing, world: World) -> None:
    joint = thing.joint
    if joint is None:
        return
    before = {t.name for t in world.things[: world.things.index(thing)]}
    carriers = [t.name for t in world.things if not t.movable or (t.joint is not None and t.name in before)]
    if joint.parent and joint.parent not in carriers:
        raise UserError(
            f"thing '{thing.name}' is mounted in '{joint.parent}', which is no fixed thing, nor one on a joint that comes before it; "
            f"{nearest(joint.parent, carriers)}"
        )
    if thing.mass is None:
        raise UserError(f"thing '{thing.name}' has a joint and no mass; give it one")
    if not joint.lower - ROUNDING <= joint.value <= joint.upper + ROUNDING or joint.lower == joint.upper:
        span = f"{joint.lower:g} .. {joint.upper:g}"
        raise UserError(f"thing '{thing.name}': its joint is at {joint.value:g}, outside {span}")


def set_options(spec: Any, physics: Physics) -> None:
    """Set physics options on the parent specification: MuJoCo takes no options from attached children, and
    only warns if they differ."""
    spec.compiler.autolimits = True
    spec.compiler.degree = False
    spec.option.timestep = physics.timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = CONES[physics.cone]
    spec.option.impratio = physics.impratio
    spec.option.noslip_iterations = physics.noslip_iterations


def attach(spec: Any, mjcf: str, mount: RobotMount) -> None:
    """Attach a robot at its mount; its names get the prefix ``{mount}/``.

    Raises:
        UserError: what its plugin gives is no MJCF.
    """
    try:
        child = mujoco.MjSpec.from_string(mjcf)
    except (ValueError, TypeError) as error:
        said = str(error).splitlines()[0] if isinstance(mjcf, str) else f"it is {mjcf!r:.80}"
        raise UserError(f"the MJCF of robot '{mount.type}' cannot be used: {said}") from error
    frame = spec.worldbody.add_frame(pos=list(mount.base.position), quat=list(mount.base.quaternion))
    spec.attach(child, prefix=f"{mount.name}/", frame=frame)


def mask_robots(spec: Any, pad_friction: float) -> None:
    """Set the contact bits of all robots and hands, and the sliding friction of their pads.

    To be called before any thing is added.
    """
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = ROBOT
        if is_pad(geom.name):
            geom.friction = [pad_friction, *geom.friction[1:]]


def is_pad(name: str) -> bool:
    """Check whether a geom of that name is a finger pad."""
    return name.split("/")[-1].startswith(("left_pad", "right_pad"))


def add_thing(spec: Any, thing: Thing, planning: bool, carried: Carried | None, carrier: Thing | None = None) -> None:
    """Add a thing as a body: fixed, free, on its joint to the thing ``carrier`` or to the world, or (when
    planning) held by a robot."""
    mask = FURNITURE if planning or not thing.movable else PRODUCT
    if planning and carried is not None:
        mask = ROBOT
        body = _carry(spec, thing, carried)
    else:
        body = _add_body(spec, thing, None if planning else carrier)
        if thing.joint is not None and not planning:
            _add_joint(spec, body, thing, thing.joint)
        elif thing.movable:
            body.add_freejoint(name=thing.name)
    if thing.inertia is not None and thing.movable:
        _set_inertia(body, thing.mass or 0.0, thing.inertia)
    geoms = [part for i, g in enumerate(thing.geoms) for part in _solid(i, g, planning)]
    whole = sum(volume(g) for _, g in geoms)
    for key, geom in geoms:
        _add_geom(spec, body, thing, key, geom, (thing.mass or 1.0) * volume(geom) / whole, mask)


def _add_body(spec: Any, thing: Thing, carrier: Thing | None) -> Any:
    """Add the body of a thing: to that of a carrier that moves on a joint, else to the world."""
    if carrier is None or carrier.joint is None:
        return spec.worldbody.add_body(name=thing.name, pos=thing.pose.position, quat=thing.pose.quaternion)
    pose = carrier.pose.inverse() * thing.pose
    return spec.body(carrier.name).add_body(name=thing.name, pos=pose.position, quat=pose.quaternion)


def _inertia(thing: Thing, joint: Joint) -> float:
    """Inertia of a thing about its hinge [kg m2], or its mass along its slide [kg].

    The inertia is that of a bar as long as the thing's farthest corner is from the hinge.
    """
    if joint.kind == "slide":
        return thing.mass or 1.0
    corners = np.vstack([c for g in thing.geoms for c in bounds(g)])
    return (thing.mass or 1.0) * float(np.linalg.norm(corners - joint.pose.position, axis=1).max()) ** 2 / 3


def _add_joint(spec: Any, body: Any, thing: Thing, joint: Joint) -> None:
    """Add the joint of a thing to its body; at the thing's stated pose, the joint has its stated value.

    A thread is a hinge and a slide behind it, coupled.
    """
    kinds = {"slide": mujoco.mjtJoint.mjJNT_SLIDE, "hinge": mujoco.mjtJoint.mjJNT_HINGE}
    body.add_joint(
        name=thing.name,
        type=kinds[joint.kind],
        pos=joint.pose.position,
        axis=tuple(joint.pose.rotate((0.0, 0.0, 1.0))),
        ref=joint.value,
        range=(joint.lower, joint.upper),
        damping=joint.damping,
        frictionloss=joint.friction,
        stiffness=joint.spring,
        springref=joint.rest,
        armature=max(STICKS * joint.friction - _inertia(thing, joint), 0.0),
    )
    if joint.pitch:
        _couple(spec, body, thing.name, joint)
    if joint.parent and not joint.meets:
        spec.add_exclude(bodyname1=thing.name, bodyname2=joint.parent)


def _couple(spec: Any, body: Any, name: str, joint: Joint) -> None:
    """Add the slide along a screw thread's axis to a body, and the constraint that couples it to the turn of the hinge."""
    axis = tuple(joint.pose.rotate((0.0, 0.0, 1.0)))
    along = body.add_joint(name=f"{name}/{ALONG}", type=mujoco.mjtJoint.mjJNT_SLIDE, pos=joint.pose.position, axis=axis)
    held = spec.add_equality(name=f"{name}/{ALONG}", type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
    held.name1, held.name2, held.solref, held.solimp[:2] = along.name, name, SOLREF, THREAD
    held.data[:2] = 0.0, joint.pitch / math.tau


def _set_inertia(body: Any, mass: float, inertia: Inertia) -> None:
    """Set the stated inertia in place of the one that follows from the geoms."""
    body.explicitinertial = True
    body.mass, body.ipos, body.fullinertia = mass, inertia.centre, inertia.moments


def _carry(spec: Any, thing: Thing, carried: Carried) -> Any:
    """Add a thing that the robot holds to the gripper's body; contacts of the thing with the gripper are excluded."""
    gripper, tcp = spec.body(f"{carried.robot}/gripper"), spec.site(f"{carried.robot}/tcp")
    if gripper is None:
        raise UserError(f"thing '{thing.name}' is carried by '{carried.robot}', which is no robot of this world")
    pose = Pose(tuple(tcp.pos), tuple(tcp.quat)) * carried.pose
    for b in [gripper, *gripper.find_all("body")]:
        spec.add_exclude(bodyname1=thing.name, bodyname2=b.name)
    return gripper.add_body(name=thing.name, pos=pose.position, quat=pose.quaternion)


def _solid(index: int, geom: Geom, planning: bool) -> list[tuple[str, Geom]]:
    """Geoms of a MuJoCo model that stand for one geom of a world, each with the end of its name: usually that
    geom alone.

    In a planning model it has no contact parameters of its own, and a capsule becomes a cylinder with two
    spheres.
    """
    geom = replace(geom, contact=None) if planning else geom
    if geom.shape != "capsule" or not planning:
        return [(str(index), geom)]
    radius, half = geom.size
    ends = [
        (f"{index}{c}", replace(geom, shape="sphere", size=(radius,), pose=geom.pose * Pose((0, 0, z))))
        for c, z in (("a", half), ("b", -half))
    ]
    return [(str(index), replace(geom, shape="cylinder")), *ends]


def _add_geom(
    spec: Any, body: Any, thing: Thing, key: str, geom: Geom, mass: float, mask: tuple[int, int]
) -> None:
    friction = thing.friction if geom.friction is None else geom.friction
    name, hull = f"{thing.name}/{geom.part or 'body'}/{key}", geom.shape == "convex"
    if hull:
        spec.add_mesh(name=name, uservert=[v for corner in geom.corners for v in corner])
    added = body.add_geom(
        name=name,
        meshname=name if hull else "",
        type=SHAPES[geom.shape][0],
        size=[0.0, 0.0, 0.0] if hull else [*geom.size, 0.0, 0.0][:3],
        pos=geom.pose.position,
        quat=geom.pose.quaternion,
        friction=[friction, 0.005, 0.0001],
        condim=6 if thing.movable and geom.shape in ROLLING else 3,
        rgba=geom.rgba,
        solref=SOLREF,
        mass=mass,
        contype=mask[0],
        conaffinity=mask[1],
    )
    if geom.contact is not None:
        _state_contact(added, friction, geom.contact)


def _state_contact(geom: Any, friction: float, contact: Contact) -> None:
    """Set the contact parameters of a geom that a scene file states, in place of this simulation's defaults."""
    geom.friction = [friction, contact.torsional, contact.rolling]
    geom.condim, geom.priority, geom.solmix = contact.condim, contact.priority, contact.solmix
    geom.solref, geom.solimp = contact.solref, contact.solimp
    geom.margin, geom.gap = contact.margin, contact.gap


def finish(spec: Any) -> Model:
    """Compile the MuJoCo specification of a world.

    Raises:
        UserError: with MuJoCo's reason.
    """
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        hint = "check the shape and mass of what is named there"
        raise UserError(f"the world does not compile: {reason}; {hint}") from None
