"""Indices of bodies, joints and sensors in a compiled MuJoCo model, looked up once by name."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from cramlite.model import EntityName, Floats, Linkage, Pose, Robot, Value

Model = Any  # mujoco.MjModel; MuJoCo's bindings have no complete types
Data = Any  # mujoco.MjData


class Owner(Value):
    """The thing, robot or hand that a geom belongs to, and the part of it.

    Args:
        name: the thing, or the robot's mount, or "hand".
        part: the feature of a thing ("" for its body); the link of an arm; left, right or body of an effector.
        kind: thing, grain (a ball of what the thing is filled with), arm or effector.
    """

    name: str
    part: str
    kind: Literal["thing", "grain", "arm", "effector"]

    @property
    def touch(self) -> str:
        """Return the name by which contacts (``cramlite.model.Touch``) know this part: "thing", "thing/part",
        "effector/left" or "mount/link" of an arm."""
        return str(EntityName("effector" if self.kind == "effector" else self.name, self.part))


class ThingIndex(Value):
    """Indices of a thing in the MuJoCo model.

    Its body; qpos and dof are the addresses of its free joint, None where it has none, and ``joint`` the qpos
    address of its hinge or slide; ``grains`` are the bodies and qpos addresses of what it is filled with.
    """

    body: int
    qpos: int | None
    dof: int | None
    joint: int | None = None
    grains: tuple[tuple[int, int], ...] = ()


class LinkageIndex(Value):
    """Indices of a gripper's linkage in the MuJoCo model, and the linkage's joint positions and commands over
    the opening (``cramlite.model.Linkage``).

    K samples, J joints, A actuators.

    Args:
        joints: qpos addresses of its joints.
        measured: weight of each in what the encoders of its drives read.
        readings: of the encoders (K), rising; ``openings`` (K) there, falling [m].
        positions: (J, K) of the joints.
        actuators: ids.
        controls, forces: (A, K) of the actuators.
    """

    joints: tuple[int, ...]
    measured: tuple[float, ...]
    readings: tuple[float, ...]
    openings: tuple[float, ...]
    positions: tuple[tuple[float, ...], ...]
    actuators: tuple[int, ...]
    controls: tuple[tuple[float, ...], ...]
    forces: tuple[tuple[float, ...], ...]

    def opening(self, qpos: Floats) -> Floats:
        """Return the distance between the pads (...) [m]; ``qpos`` (nq, ...) is of the whole model."""
        reading = sum(w * qpos[a] for a, w in zip(self.joints, self.measured, strict=True))
        return np.asarray(np.interp(reading, self.readings, self.openings))

    def put(self, data: Data, opening: float) -> None:
        """Set the linkage's joints and the commands of its actuators to an opening between the pads [m],
        without any physics."""
        narrow = [-o for o in self.openings]
        for a, column in zip(self.joints, self.positions, strict=True):
            data.qpos[a] = np.interp(-opening, narrow, column)
        for a, column in zip(self.actuators, self.controls, strict=True):
            data.ctrl[a] = np.interp(-opening, narrow, column)


class EffectorIndex(Value):
    """Indices of an effector (a robot's gripper or a hand) in the MuJoCo model.

    Args:
        name: of the mount, or "hand".
        tcp, ft: site ids.
        ft_force, ft_torque: addresses in sensordata.
        gripper: actuator id.
        fingers: qpos addresses of the finger joints.
        travels: the far ends of their ranges [m].
        left, right: geom ids of the pads.
        bodies: ids of the bodies that move with the sensor, the fingers included.
        reach: smallest and largest distance between the pads [m].
        linkage: what moves the pads, where it is a file's; else ``fingers`` are two slides.
    """

    name: str
    tcp: int
    ft: int
    ft_force: int
    ft_torque: int
    gripper: int
    fingers: tuple[int, ...]
    travels: tuple[float, ...]
    left: tuple[int, ...]
    right: tuple[int, ...]
    bodies: tuple[int, ...]
    reach: tuple[float, float]
    linkage: LinkageIndex | None

    def opening(self, qpos: Floats) -> Floats:
        """Return the distance between the finger pads (...) [m], from the finger joints; ``qpos`` (nq, ...) is of the whole model."""
        if self.linkage is not None:
            return self.linkage.opening(qpos)
        low, high = self.reach
        travel = sum(qpos[a] / far for a, far in zip(self.fingers, self.travels, strict=True)) / len(self.fingers)
        return np.asarray(high - travel * (high - low))

    def set_opening(self, data: Data, opening: float) -> None:
        """Set the fingers to an opening [m] without any physics; for start states and planning."""
        if self.linkage is not None:
            self.linkage.put(data, opening)
            return
        low, high = self.reach
        share = min(max((high - opening) / (high - low), 0.0), 1.0)
        for a, far in zip(self.fingers, self.travels, strict=True):
            data.qpos[a] = share * far

    def pose(self, data: Data) -> Pose:
        """Return the tool frame in the world, in a state whose kinematics are computed."""
        return site_pose(data, self.tcp)


class PlatformIndex(Value):
    """Indices of a platform in the MuJoCo model: its body, and qpos addresses and actuators of its joints x,
    y and turn."""

    body: int
    joints: tuple[int, ...]
    actuators: tuple[int, ...]

    def pose(self, data: Data) -> Pose:
        """Return the platform's frame in the world, in a state whose kinematics are computed."""
        return Pose(tuple(data.xpos[self.body]), tuple(data.xquat[self.body]))

    def put(self, data: Data, start: Pose, stand: Pose) -> None:
        """Set the platform to the pose ``stand`` without any physics; ``start`` is its pose when its joints are
        at zero."""
        data.qpos[list(self.joints)] = flat(start.inverse() * stand)


def flat(pose: Pose) -> tuple[float, float, float]:
    """Return x, y [m] and turn about z [rad] of a level pose."""
    w, _, _, z = pose.quaternion
    return pose.position[0], pose.position[1], 2.0 * math.atan2(z, w)


class RobotIndex(EffectorIndex):
    """Indices of a robot in the MuJoCo model.

    Args:
        robot: its description.
        joints, dofs: qpos and dof addresses of the arm, base to flange.
        actuators: their position servos.
        flange: site id.
        platform: what it drives on, if it does.
    """

    robot: Robot
    joints: tuple[int, ...]
    dofs: tuple[int, ...]
    actuators: tuple[int, ...]
    flange: int
    platform: PlatformIndex | None = None


def robot_index(model: Model, name: str, robot: Robot) -> RobotIndex:
    """Look up the robot that was attached with the prefix ``{name}/``."""
    joints = [model.joint(f"{name}/{j}") for j in robot.joints]
    effector = effector_fields(model, name, "gripper", robot.gripper.opening, robot.gripper.linkage)
    return RobotIndex(
        robot=robot,
        joints=tuple(int(j.qposadr[0]) for j in joints),
        dofs=tuple(int(j.dofadr[0]) for j in joints),
        actuators=tuple(model.actuator(f"{name}/{j}").id for j in robot.joints),
        flange=model.site(f"{name}/flange").id,
        platform=_platform_index(model, name, robot),
        **effector,
    )


def _platform_index(model: Model, name: str, robot: Robot) -> PlatformIndex | None:
    platform = robot.platform
    if platform is None:
        return None
    joints = tuple(int(model.joint(f"{name}/{j}").qposadr[0]) for j in platform.joints)
    return PlatformIndex(
        int(model.body(f"{name}/{platform.body}").id), joints, tuple(model.actuator(f"{name}/{j}").id for j in platform.joints)
    )


def _linkage_index(model: Model, name: str, linkage: Linkage) -> LinkageIndex:
    columns = tuple(tuple(zip(*rows, strict=True)) for rows in (linkage.positions, linkage.controls, linkage.forces))
    return LinkageIndex(
        joints=tuple(int(model.joint(f"{name}/{j}").qposadr[0]) for j in linkage.joints),
        measured=linkage.measured,
        readings=linkage.readings,
        openings=linkage.openings,
        positions=columns[0],
        actuators=tuple(int(model.actuator(f"{name}/{a}").id) for a in linkage.actuators),
        controls=columns[1],
        forces=columns[2],
    )


def effector_fields(model: Model, name: str, root: str, reach: tuple[float, float], linkage: Linkage | None = None) -> dict[str, Any]:
    """Look up the fields of EffectorIndex for the effector whose first body is ``{name}/{root}``."""
    top = model.body(f"{name}/{root}").id
    bodies = tuple(b for b in range(model.nbody) if _inside(model, b, top))
    fingers = [model.joint(j) for b in bodies if b != top for j in joints_of(model, b)]
    return {
        "name": name,
        "tcp": model.site(f"{name}/tcp").id,
        "ft": model.site(f"{name}/ft").id,
        "ft_force": int(model.sensor(f"{name}/ft_force").adr[0]),
        "ft_torque": int(model.sensor(f"{name}/ft_torque").adr[0]),
        "gripper": model.actuator(f"{name}/{linkage.actuators[0] if linkage else 'gripper'}").id,
        "fingers": tuple(int(j.qposadr[0]) for j in fingers),
        "travels": tuple(float(j.range[1]) for j in fingers),
        "left": _pads(model, f"{name}/left_pad"),
        "right": _pads(model, f"{name}/right_pad"),
        "bodies": bodies,
        "reach": reach,
        "linkage": _linkage_index(model, name, linkage) if linkage else None,
    }


def site_pose(data: Data, site: int) -> Pose:
    """Return the pose of a site in the world."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = data.site_xmat[site].reshape(3, 3), data.site_xpos[site]
    return Pose.from_matrix(matrix)


def _pads(model: Model, prefix: str) -> tuple[int, ...]:
    return tuple(g for g in range(model.ngeom) if model.geom(g).name.startswith(prefix))


def _inside(model: Model, body: int, top: int) -> bool:
    while body > top:
        body = int(model.body_parentid[body])
    return body == top


def joints_of(model: Model, body: int) -> range:
    """Return the joints of a body."""
    start = int(model.body_jntadr[body])
    return range(start, start + int(model.body_jntnum[body])) if start >= 0 else range(0)
