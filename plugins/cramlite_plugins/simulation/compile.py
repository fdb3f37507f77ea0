"""A world becomes a MuJoCo model.

Names: a thing's body has the thing's name, its geoms ``{thing}/{part or "body"}/{i}``; a robot's names start
with ``{mount}/``, the hand's with ``hand/``.

Contact: robots 1/7, products 2/7, furniture 4/3 (contype/conaffinity), as measured in
docs/explanation/simulation.md, except that a robot meets itself too.
In a planning model everything but robots and what they carry is furniture, so that ``data.ncon == 0`` means
exactly: no robot touches anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco

from cramlite.errors import UserError, nearest
from cramlite.geometry import Pose
from cramlite.robots import Robot
from cramlite.world import Geom, Physics, RobotMount, Thing, World

from .hand import REST, HandIndex, hand_index, hand_mjcf
from .index import Data, Model, Owner, RobotIndex, ThingIndex, robot_index

ROBOT, PRODUCT, FURNITURE = (1, 7), (2, 7), (4, 3)
SHAPES = {
    "box": (mujoco.mjtGeom.mjGEOM_BOX, 3),
    "cylinder": (mujoco.mjtGeom.mjGEOM_CYLINDER, 2),
    "capsule": (mujoco.mjtGeom.mjGEOM_CAPSULE, 2),
    "sphere": (mujoco.mjtGeom.mjGEOM_SPHERE, 1),
}
CONES = {"elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC, "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL}


@dataclass(frozen=True)
class Carried:
    """A thing that a planning model fixes to a robot's tool.

    Args:
        robot: name of the mount.
        pose: of the thing in the tool (tcp) frame.
    """

    robot: str
    pose: Pose


@dataclass(frozen=True)
class Compiled:
    """A model with its addresses.

    Args:
        world: what it was made of.
        model: the MjModel.
        robots: by mount name.
        things: by thing name.
        owners: what each geom belongs to, by geom id.
        hand: the free-floating hand, if there is one.
    """

    world: World
    model: Model
    robots: Mapping[str, RobotIndex]
    things: Mapping[str, ThingIndex]
    owners: tuple[Owner, ...]
    hand: HandIndex | None = None

    def data(self) -> Data:
        """A new state: robots at home with open grippers, things at their poses."""
        data = mujoco.MjData(self.model)
        self.initial(data)
        return data

    def initial(self, data: Data) -> None:
        """Reset a state: robots at home with open grippers, things at their poses, servos holding."""
        mujoco.mj_resetData(self.model, data)
        for index in self.robots.values():
            data.qpos[list(index.joints)] = index.robot.home
            data.ctrl[list(index.actuators)] = index.robot.home
        if self.hand is not None:
            self.hand.teleport(self.model, data, self.hand.home)
            self.hand.set_target(data, self.hand.home, self.hand.reach[1])
        for thing in self.world.things:
            self.place(data, thing.name, thing.pose)
        mujoco.mj_forward(self.model, data)

    def place(self, data: Data, thing: str, pose: Pose) -> None:
        """Put a movable thing somewhere, at rest. Things without a free joint (fixed or carried) stay."""
        index = self.things[thing]
        if index.qpos is not None and index.dof is not None:
            data.qpos[index.qpos : index.qpos + 7] = (*pose.position, *pose.quaternion)
            data.qvel[index.dof : index.dof + 6] = 0.0

    def pose(self, data: Data, thing: str) -> Pose:
        """The pose of a thing in the world; needs kinematics."""
        body = self.things[thing].body
        return Pose(tuple(data.xpos[body]), tuple(data.xquat[body]))

    def collisions(self, data: Data) -> set[tuple[str, str]]:
        """The pairs in contact, each sorted, by the names of ``Owner.touch``; needs ``mj_collision``."""
        found = set()
        for i in range(data.ncon):
            a, b = (self.owners[g].touch for g in data.contact.geom[i])
            found.add((min(a, b), max(a, b)))
        return found


def compile_world(
    world: World,
    robots: Mapping[str, Robot],
    *,
    hand: bool | Pose = False,
    planning: bool = False,
    carried: Mapping[str, Carried] | None = None,
    clearance: float = 0.0,
) -> Compiled:
    """Compile a world.

    A planning model is for ``qpos; mj_kinematics; mj_collision; ncon``: capsules of things become cylinders with
    spheres (the trap of docs/explanation/simulation.md), the fingers stay where ``set_opening`` put them, movable
    things stay re-poseable through ``Compiled.place``, and ``carried`` things move with a tool (compiling anew
    takes some milliseconds).

    Args:
        robots: descriptions by type name, for the mounts of the world.
        hand: add the free-floating hand of a demonstration; a pose gives its orientation at rest.
        planning: see above.
        carried: thing name -> where it is in which hand; planning only.
        clearance: distance [m] below which the planning model reports a contact of a robot.

    Raises:
        UserError: the world does not compile; names the thing and the reason.
    """
    _check(world, robots)
    spec = mujoco.MjSpec()
    _options(spec, world.physics)
    for mount in world.robots:
        _attach(spec, robots[mount.type].mjcf(), mount)
    rest = hand if isinstance(hand, Pose) else REST
    if hand:
        _attach(spec, hand_mjcf(rest), RobotMount("hand", "hand"))
    _mask_robots(spec, world.physics.pad_friction, clearance if planning else 0.0)
    for thing in world.things:
        _add_thing(spec, thing, planning, (carried or {}).get(thing.name), clearance)
    model = _compile(spec)
    return Compiled(
        world=world,
        model=model,
        robots={m.name: robot_index(model, m.name, robots[m.type]) for m in world.robots},
        things={t.name: _thing_index(model, t.name) for t in world.things},
        owners=tuple(_owner(model, world, g) for g in range(model.ngeom)),
        hand=hand_index(model, rest) if hand else None,
    )


def _check(world: World, robots: Mapping[str, Robot]) -> None:
    names: set[str] = set()
    for name in [*(t.name for t in world.things), *(m.name for m in world.robots)]:
        if not name or "/" in name or name in names or name in ("world", "effector", "hand"):
            why = "is used twice" if name in names else "is empty, reserved, or has a '/'"
            raise UserError(f"world: the name '{name}' {why}; every thing and robot needs a name of its own")
        names.add(name)
    for mount in world.robots:
        if mount.type not in robots:
            raise UserError(f"robot '{mount.name}': there is no robot type '{mount.type}'; {nearest(mount.type, robots)}")
    for thing in world.things:
        _check_thing(thing)


def _check_thing(thing: Thing) -> None:
    if not thing.geoms:
        raise UserError(f"thing '{thing.name}' has no geoms; give it at least one box, cylinder, capsule or sphere")
    if thing.mass is not None and not 1e-4 <= thing.mass < 1e4:
        raise UserError(f"thing '{thing.name}': mass {thing.mass} kg; it must lie between 0.0001 and 10000 kg")
    for i, geom in enumerate(thing.geoms):
        where = f"thing '{thing.name}', geom {i}"
        if geom.shape not in SHAPES:
            raise UserError(f"{where}: there is no shape '{geom.shape}'; {nearest(geom.shape, SHAPES)}")
        count = SHAPES[geom.shape][1]
        if len(geom.size) != count or not all(0 < s < 100 for s in geom.size):
            raise UserError(f"{where}: a {geom.shape} needs {count} positive size(s) in metres, not {geom.size}")
        friction = thing.friction if geom.friction is None else geom.friction
        if not 0 <= friction < 100:
            raise UserError(f"{where}: friction {friction}; it must not be negative")


def _options(spec: Any, physics: Physics) -> None:
    """Set on the parent: attaching a child only warns about options that differ."""
    spec.compiler.autolimits = True
    spec.compiler.degree = False
    spec.option.timestep = physics.timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = CONES[physics.cone]
    spec.option.impratio = physics.impratio
    spec.option.noslip_iterations = physics.noslip_iterations


def _attach(spec: Any, mjcf: str, mount: RobotMount) -> None:
    child = mujoco.MjSpec.from_string(mjcf)
    frame = spec.worldbody.add_frame(pos=list(mount.base.position), quat=list(mount.base.quaternion))
    spec.attach(child, prefix=f"{mount.name}/", frame=frame)


def _mask_robots(spec: Any, pad_friction: float, clearance: float) -> None:
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = ROBOT
        geom.margin = clearance
        if _is_pad(geom.name):
            geom.friction = [pad_friction, 0.005, 0.0001]


def _is_pad(name: str) -> bool:
    return name.split("/")[-1].startswith(("left_pad", "right_pad"))


def _add_thing(spec: Any, thing: Thing, planning: bool, carried: Carried | None, clearance: float) -> None:
    mask = FURNITURE if planning or not thing.movable else PRODUCT
    if planning and carried is not None:
        mask, margin = ROBOT, clearance
        body = _carry(spec, thing, carried)
    else:
        margin = 0.0
        body = spec.worldbody.add_body(name=thing.name, pos=thing.pose.position, quat=thing.pose.quaternion)
        if thing.movable:
            body.add_freejoint(name=thing.name)
    geoms = [part for i, g in enumerate(thing.geoms) for part in _solid(i, g, planning)]
    volume = sum(_volume(g) for _, g in geoms)
    for key, geom in geoms:
        _add_geom(body, thing, key, geom, (thing.mass or 1.0) * _volume(geom) / volume, mask, margin)


def _carry(spec: Any, thing: Thing, carried: Carried) -> Any:
    """Put the thing on the gripper's body; it may touch the gripper, which holds it."""
    gripper, tcp = spec.body(f"{carried.robot}/gripper"), spec.site(f"{carried.robot}/tcp")
    if gripper is None:
        raise UserError(f"thing '{thing.name}' is carried by '{carried.robot}', which is no robot of this world")
    pose = Pose(tuple(tcp.pos), tuple(tcp.quat)) * carried.pose
    for b in [gripper, *gripper.find_all("body")]:
        spec.add_exclude(bodyname1=thing.name, bodyname2=b.name)
    return gripper.add_body(name=thing.name, pos=pose.position, quat=pose.quaternion)


def _solid(index: int, geom: Geom, planning: bool) -> list[tuple[str, Geom]]:
    """The geom; in a planning model a capsule as a cylinder and two spheres."""
    if geom.shape != "capsule" or not planning:
        return [(str(index), geom)]
    radius, half = geom.size
    ends = [
        (f"{index}{c}", replace(geom, shape="sphere", size=(radius,), pose=geom.pose * Pose((0, 0, z))))
        for c, z in (("a", half), ("b", -half))
    ]
    return [(str(index), replace(geom, shape="cylinder")), *ends]


def _volume(geom: Geom) -> float:
    """In units of which only the ratio matters, but right for each shape."""
    pi, size = 3.141592653589793, geom.size
    if geom.shape == "box":
        return 8 * size[0] * size[1] * size[2]
    ball = 4 / 3 * pi * size[0] ** 3
    if geom.shape == "sphere":
        return ball
    return 2 * pi * size[0] ** 2 * size[1] + (ball if geom.shape == "capsule" else 0.0)


def _add_geom(
    body: Any, thing: Thing, key: str, geom: Geom, mass: float, mask: tuple[int, int], margin: float
) -> None:
    friction = thing.friction if geom.friction is None else geom.friction
    body.add_geom(
        name=f"{thing.name}/{geom.part or 'body'}/{key}",
        type=SHAPES[geom.shape][0],
        size=[*geom.size, 0.0, 0.0][:3],
        pos=geom.pose.position,
        quat=geom.pose.quaternion,
        friction=[friction, 0.005, 0.0001],
        rgba=geom.rgba,
        mass=mass,
        contype=mask[0],
        conaffinity=mask[1],
        margin=margin,
    )


def _compile(spec: Any) -> Model:
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise UserError(f"the world does not compile: {reason}; check the shape and mass of what is named there") from None


def _thing_index(model: Model, name: str) -> ThingIndex:
    body = model.body(name)
    if int(body.jntnum[0]) == 0:
        return ThingIndex(int(body.id), None, None)
    joint = int(body.jntadr[0])
    return ThingIndex(int(body.id), int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint]))


def _owner(model: Model, world: World, geom: int) -> Owner:
    name, *parts = model.geom(geom).name.split("/")
    if any(t.name == name for t in world.things):
        return Owner(name, "" if parts[0] == "body" else parts[0], "thing")
    if _is_pad(parts[0]):
        return Owner(name, parts[0].split("_")[0], "effector")
    root = "palm" if name == "hand" else "gripper"
    if parts[0] in (root, "left_finger", "right_finger"):
        return Owner(name, "body", "effector")
    return Owner(name, parts[0], "arm")
