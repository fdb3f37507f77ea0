"""Compilation of a world to a MuJoCo model.

Names: a thing's body has the thing's name, its geoms ``{thing}/{part or "body"}/{i}``; a robot's names start
with ``{mount}/``, those of hands with ``hand/`` and ``other_hand/``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Disturbance, Pose, Robot, RobotMount, Thing, Value, World

from .build import Carried, add_thing, attach, check, finish, is_pad, mask_robots, set_options
from .centres import real_things
from .far_apart import far_apart
from .friction import add_pairs
from .grains import GRAIN, add_grains, layout
from .hand_model import HANDS, REST, HandIndex, hand_index, hand_mjcf
from .index import Data, Model, Owner, RobotIndex, ThingIndex, robot_index

# MuJoCo would append every warning to MUJOCO_LOG.TXT in the user's folder; they are counted in MjData.warning, where
# ``unstable`` looks.
mujoco.set_mju_user_warning(lambda _message: None)
ASSETS = 200_000_000
"""Capacity for meshes and textures of files that MuJoCo keeps for the next compilation [bytes], 524 MB by default; a scene of LIBERO has
170 MB."""
mujoco.mj_setCacheCapacity(mujoco.mj_getCache(), ASSETS)
APART = 0.3
"""Distance between hands that wait [m]."""
BAD = tuple(int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{kind}")) for kind in ("QPOS", "QVEL", "QACC"))


def divergence(data: Data) -> Any:
    """Return MuJoCo's own counts of huge positions, speeds and accelerations, which it goes on counting; all are
    0 while the simulation has not diverged."""
    return data.warning.number[BAD[0] : BAD[-1] + 1]


def unstable(counts: Any) -> str:
    """Explain in words why the simulation has diverged, from its counts (``divergence``); "" while it has not."""
    if any(counts.tolist()):
        return "the simulation is unstable: a position, speed or acceleration became huge; check masses, sizes and the timestep"
    return ""


class Compiled(Value):
    """Compiled MuJoCo model of a world, with the indices in it of robots and things.

    Args:
        world: what it was made of.
        model: the MjModel.
        robots: by mount name.
        things: by thing name.
        owners: what each geom belongs to, by geom id.
        hand, other_hand: the free-floating hands, if there are any.
    """

    world: World
    model: Model
    robots: Mapping[str, RobotIndex]
    things: Mapping[str, ThingIndex]
    owners: tuple[Owner, ...]
    hand: HandIndex | None = None
    other_hand: HandIndex | None = None

    @property
    def hands(self) -> tuple[HandIndex, ...]:
        """Return the free-floating hands of this model: none, one or two."""
        return tuple(h for h in (self.hand, self.other_hand) if h is not None)

    def data(self) -> Data:
        """Make a simulation state: robots and things where the world has them at the start."""
        data = mujoco.MjData(self.model)
        self.initial(data)
        return data

    def places(self) -> Data:
        """Make a state with the start positions of everything, without computing anything from them, such as
        poses of links."""
        data = mujoco.MjData(self.model)
        self._start(data)
        return data

    def initial(self, data: Data) -> None:
        """Reset a state: robots as the world has them at the start (at home, open), things at their poses, servos holding."""
        mujoco.mj_resetData(self.model, data)
        self._start(data)
        mujoco.mj_forward(self.model, data)

    def _start(self, data: Data) -> None:
        """Write the start positions of robots, hands, things and grains into a reset state."""
        for mount in self.world.robots:
            index = self.robots[mount.name]
            data.qpos[list(index.joints)] = data.ctrl[list(index.actuators)] = mount.joints or index.robot.home
            if mount.opening is not None or index.linkage is not None:
                index.set_opening(data, index.robot.start(mount)[1])
        for k, hand in enumerate(self.hands):
            home = Pose((0.0, k * APART, 0.0)) * hand.home
            hand.teleport(self.model, data, home)
            hand.set_target(data, home, hand.reach[1])
        for thing in self.world.things:
            self.place(data, thing.name, thing.pose)
            for (_, address), centre in zip(self.things[thing.name].grains, layout(thing), strict=False):
                data.qpos[address : address + 7] = (*centre, 1.0, 0.0, 0.0, 0.0)

    def place(self, data: Data, thing: str, pose: Pose) -> None:
        """Put a movable thing at a pose in the world, at rest.

        A thing on a joint is put as near to the pose as the joint lets it. Other things stay.
        """
        index, own = self.things[thing], self.world.thing(thing)
        if index.joint is not None and own.joint is not None:
            by = own.joint.between(self._displaced(data, own.joint.parent) * own.pose, pose)
            data.qpos[index.joint] = own.joint.value + by
            if own.joint.pitch:  # the joint along a thread comes next to its hinge
                data.qpos[index.joint + 1] = own.joint.pitch * by / math.tau
        if index.qpos is not None and index.dof is not None:
            data.qpos[index.qpos : index.qpos + 7] = (*pose.position, *pose.quaternion)
            data.qvel[index.dof : index.dof + 6] = 0.0

    def _displaced(self, data: Data, carrier: str) -> Pose:
        """Displacement of the thing ``carrier``, in the world frame, from its pose in the world's description
        to that in a simulation state."""
        index = self.things.get(carrier)
        if index is None or index.joint is None or (joint := self.world.thing(carrier).joint) is None:
            return Pose()
        own = self.world.thing(carrier).pose
        return self._displaced(data, joint.parent) * joint.moved(own, float(data.qpos[index.joint]) - joint.value) * own.inverse()

    def pose(self, data: Data, thing: str) -> Pose:
        """Return the pose of a thing in the world, in a state whose kinematics are computed."""
        body = self.things[thing].body
        return Pose(tuple(data.xpos[body]), tuple(data.xquat[body]))

    def collisions(self, data: Data) -> set[tuple[str, str]]:
        """Return the pairs of bodies in contact, by their names in contacts (``Owner.touch``), each pair sorted.

        ``mj_collision`` must have run.
        """
        found = set()
        for i in range(data.ncon):
            a, b = (self.owners[g].touch for g in data.contact.geom[i])
            found.add((min(a, b), max(a, b)))
        return found


def compile_world(
    world: World,
    robots: Mapping[str, Robot],
    *,
    hand: bool | Pose | tuple[Pose, ...] = False,
    planning: bool = False,
    carried: Mapping[str, Carried] | None = None,
) -> Compiled:
    """Compile a world.

    A planning model is for ``qpos; mj_kinematics; mj_collision; ncon``: capsules of things become cylinders with
    spheres (the trap of docs/explanation/simulation.md), the fingers stay where ``set_opening`` put them, movable
    things stay re-poseable through ``Compiled.place``, and ``carried`` things move with a tool (compiling anew
    takes some milliseconds).

    Args:
        robots: descriptions by type name, for the mounts of the world.
        hand: add the free-floating hand of a demonstration; a pose gives its orientation at rest, two those of both hands.
        planning: see above.
        carried: thing name -> where it is in which hand; planning only.

    Raises:
        UserError: the world does not compile; names the thing and the reason.
    """
    check(world, robots)
    hands = dict(zip(HANDS, _rests(hand), strict=False))
    model = finish(_described(world, robots, hands, carried or {}, planning=planning))
    found = {name: hand_index(model, rest, name) for name, rest in hands.items()}
    return Compiled(
        world=world,
        model=model,
        robots={m.name: robot_index(model, m.name, robots[m.type]) for m in world.robots},
        things={t.name: _thing_index(model, t.name) for t in world.things},
        owners=tuple(_owner(model, world, g) for g in range(model.ngeom)),
        hand=found.get(HANDS[0]),
        other_hand=found.get(HANDS[1]),
    )


def _described(
    world: World, robots: Mapping[str, Robot], hands: Mapping[str, Pose], carried: Mapping[str, Carried], *, planning: bool
) -> mujoco.MjSpec:
    """MuJoCo specification of a world with its robots and things, and the hands of a demonstration."""
    spec = mujoco.MjSpec()
    set_options(spec, world.physics)
    for mount in world.robots:
        attach(spec, robots[mount.type].mjcf(), mount)
    for name, rest in hands.items():
        attach(spec, hand_mjcf(rest), RobotMount(name, name))
    mask_robots(spec, world.physics.pad_friction)
    made: dict[str, Thing] = {}
    for thing in world.things if planning else real_things(world):
        add_thing(spec, thing, planning, carried.get(thing.name), made.get(thing.joint.parent) if thing.joint else None)
        made[thing.name] = thing
        if not planning:
            add_grains(spec, thing)
    if not planning:
        filled = () if hands else [t.name for t in world.things if t.filling is not None]
        add_pairs(spec, _stated(world), far_apart(world, robots), filled)
    return spec


def _stated(world: World) -> frozenset[str]:
    """Names of the geoms whose own contact parameters a scene file states."""
    geoms = ((t.name, k, g) for t in world.things for k, g in enumerate(t.geoms))
    return frozenset(f"{thing}/{g.part or 'body'}/{k}" for thing, k, g in geoms if g.contact is not None)


def _rests(hand: bool | Pose | tuple[Pose, ...]) -> tuple[Pose, ...]:
    """Rest orientations of the free-floating hands of a compiled world: those that ``hand`` lists; the usual
    one if it is True."""
    if isinstance(hand, Pose):
        return (hand,)
    return hand if isinstance(hand, tuple) else (REST,) if hand else ()


def _thing_index(model: Model, name: str) -> ThingIndex:
    body, grains = model.body(name), _grains(model, name)
    if int(body.jntnum[0]) == 0:
        return ThingIndex(int(body.id), None, None, None, grains)
    joint = int(body.jntadr[0])
    address = int(model.jnt_qposadr[joint])
    if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
        return ThingIndex(int(body.id), None, None, address, grains)
    return ThingIndex(int(body.id), address, int(model.jnt_dofadr[joint]), None, grains)


def _grains(model: Model, thing: str) -> tuple[tuple[int, int], ...]:
    joints = (model.joint(j) for j in range(model.njnt))
    return tuple((int(j.bodyid[0]), int(j.qposadr[0])) for j in joints if j.name.startswith(f"{thing}/{GRAIN}/"))


def _owner(model: Model, world: World, geom: int) -> Owner:
    name, *parts = model.geom(geom).name.split("/")
    if parts and parts[0] == GRAIN:
        return Owner(name, GRAIN, "grain")
    if any(t.name == name for t in world.things):
        return Owner(name, "" if parts[0] == "body" else parts[0], "thing")
    if is_pad(parts[0]):
        return Owner(name, parts[0].split("_")[0], "effector")
    root = "palm" if name in HANDS else "gripper"
    if parts[0] in (root, "left_finger", "right_finger"):
        return Owner(name, "body", "effector")
    return Owner(name, parts[0], "arm")


def misbuild(compiled: Compiled, mount: str, off: Disturbance) -> None:
    """Build a robot with errors that its controller does not know: displaced links and tool, and a mass on the
    flange."""
    model, index = compiled.model, compiled.robots[mount]
    bodies = [int(model.jnt_bodyid[model.joint(f"{mount}/{name}").id]) for name in index.robot.joints]
    for body, way in zip(bodies, off.links, strict=False):
        model.body_pos[body] += way
    behind = np.flatnonzero(model.body_parentid == bodies[-1])
    model.body_pos[behind] += off.tool
    if off.flange_mass and len(behind):
        model.body_mass[behind[0]] += off.flange_mass
        mujoco.mj_setConst(model, compiled.data())
