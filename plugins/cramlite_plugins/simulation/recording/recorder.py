"""Recorder that turns a running simulation into a ``cramlite.model.Rollout``, the same for free-floating
hands and for robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cramlite.model import GRAVITY, EntityName, Floats, Message, Pose, Rollout, Vector3

from ..controller.controller import Applied, Controller
from ..controller.force_mode import ForceMode
from ..controller.nominal_arm import cross
from ..model.compile import Compiled
from ..model.index import Data, EffectorIndex, Model, RobotIndex, site_pose
from .contact_work import ContactWork
from .contacts import Contacts
from .sight import Sight


class _Sample(NamedTuple):
    """Record of a state as MuJoCo's arrays; names and poses are made from it after the run."""

    sites: Floats
    turns: Floats
    bodies: Floats
    quaternions: Floats
    pads: Floats
    qpos: Floats
    wrench: Floats | None
    line: int


class Recorder:
    """A recorder that samples a simulation at a constant rate.

    Call :meth:`observe` after every step; it keeps a sample whenever one is due. Between samples nothing is computed.

    Args:
        compiled: the model.
        effector: name of the mount, or "hand"; by default the hand if there is one, else the first robot.
        rate: samples a second.
        wrench: whether samples have the effector's wrench; not where ``Peaks`` are kept, whose wrenches stand for them.
    """

    def __init__(self, compiled: Compiled, effector: str | None = None, rate: float = 50.0, wrench: bool = True) -> None:
        self.compiled, self._wrench = compiled, wrench
        self.index = effector_of(compiled, effector)
        self._tools = {"effector": self.index, **{h.name: h for h in compiled.hands if h.name != self.index.name}}
        self._bodies = np.array(_recorded_bodies(compiled, self.index), dtype=int)
        self._pads = np.array([pad for tool in self._tools.values() for pad in (*tool.left, *tool.right)], dtype=int)
        self._contacts, self._work = Contacts(compiled, self.index.name), ContactWork(compiled)
        self.period = 1.0 / rate
        self.messages: list[Message] = []
        self._samples: list[_Sample] = []
        self._sight = Sight(compiled)

    def observe(self, data: Data, line: int = 0) -> None:
        """Record a sample if one is due. The state must be consistent, as it is after mj_step or mj_forward."""
        if data.time >= len(self._samples) * self.period - 1e-9:
            if self._sight.seen:
                self._sight.look(data, camera_poses(self.compiled, data), len(self._samples) * self.period)
            self._contacts.see(data)
            self._work.see(data)
            self._samples.append(self._sample(data, line))

    def message(self, time: float, text: str, line: int = 0) -> None:
        """Add a line to the program's log."""
        self.messages.append(Message(time, text, line))

    def rollout(self, outcome: str = "finished", reason: str = "") -> Rollout:
        """Return everything recorded so far as a rollout. Its times are those at which samples were due."""
        samples, index, things = self._samples, self.index, self.compiled.things
        count, qpos = len(samples), self._stacked("qpos", self.compiled.model.nq)
        bodies, column = self._tracks(), {body: k for k, body in enumerate(self._bodies.tolist())}
        grains = {name: [column[body] for body, _ in i.grains] for name, i in things.items() if i.grains}
        platform = index.platform if isinstance(index, RobotIndex) else None
        base = {str(EntityName(index.name, "base")): bodies[:, column[platform.body]]} if platform else {}
        return Rollout(
            world=self.compiled.world,
            effector=index.name,
            times=np.array([i * self.period for i in range(count)]),
            poses={name: bodies[:, column[i.body]].copy() for name, i in things.items()} | self._frames() | base,
            touches=self._contacts.touches(),
            asleep=self._contacts.asleep(),
            joints=qpos[:, list(index.joints) if isinstance(index, RobotIndex) else []],
            wrench=self._stacked("wrench", 6) if self._wrench else np.zeros((count, 6)),
            opening=index.opening(qpos.T),
            lines=np.array([s.line for s in samples], dtype=float),
            messages=tuple(self.messages),
            outcome=outcome,
            reason=reason,
            values={name: qpos[:, i.joint] for name, i in things.items() if i.joint is not None},
            grains={name: bodies[:, columns, :3] for name, columns in grains.items()},
            sizes=self._sizes(),
            seen=self._sight.seen,
            work=self._work.points(),
        )

    def _stacked(self, field: str, *shape: int) -> Floats:
        """Values (N, *shape) of one field of the recorded states, for all samples."""
        return np.array([getattr(s, field) for s in self._samples]).reshape(len(self._samples), *shape)

    def _tracks(self) -> Floats:
        """Poses (N, B, 7) of the recorded bodies."""
        count = len(self._bodies)
        return np.concatenate([self._stacked("bodies", count, 3), self._stacked("quaternions", count, 4)], axis=2)

    def _frames(self) -> dict[str, Floats]:
        """Name -> (N, 7) poses of tools, fingers and cameras."""
        found, pads = dict[str, Floats](), iter(self._stacked("pads", len(self._pads), 3).transpose(1, 0, 2))
        for name, tool in self._tools.items():
            found[name] = _rows(self._site(tool.tcp))
            for side, geoms in (("left", tool.left), ("right", tool.right)):  # a tip is the middle of its pads
                middle = sum(next(pads) for _ in geoms) / len(geoms)
                found[str(EntityName(name, side))] = np.hstack([middle, found[name][:, 3:]])
        flanges = {name: index.flange for name, index in self.compiled.robots.items()}
        for camera in self.compiled.world.cameras:
            if camera.mount is None:
                found[camera.name] = _rows([camera.pose] * len(self._samples))
            elif camera.mount in flanges:
                found[camera.name] = _rows([flange * camera.pose for flange in self._site(flanges[camera.mount])])
        return found

    def _site(self, site: int) -> list[Pose]:
        """Poses of a site in the world, one a sample."""
        sites = self.compiled.model.nsite
        matrices = np.zeros((len(self._samples), 4, 4))
        matrices[:, :3, :3] = self._stacked("turns", sites, 3, 3)[:, site]
        matrices[:, :3, 3] = self._stacked("sites", sites, 3)[:, site]
        return [Pose.from_matrix(m) for m in matrices]

    def _sizes(self) -> dict[str, Vector3]:
        if not isinstance(self.index, RobotIndex):
            return {}
        platform, (width, length) = self.index.robot.platform, self.index.robot.gripper.pad
        pads: dict[str, Vector3] = {str(EntityName("effector", side)): (width, 0.0, length) for side in ("left", "right")}
        return pads | ({str(EntityName(self.index.name, "base")): platform.size} if platform else {})

    def _sample(self, data: Data, line: int) -> _Sample:
        return _Sample(
            sites=data.site_xpos.copy(),
            turns=data.site_xmat.copy(),
            bodies=data.xpos.take(self._bodies, axis=0),
            quaternions=data.xquat.take(self._bodies, axis=0),
            pads=data.geom_xpos.take(self._pads, axis=0),
            qpos=data.qpos.copy(),
            wrench=wrench(self.compiled.model, data, self.index) if self._wrench else None,
            line=line,
        )


def _recorded_bodies(compiled: Compiled, index: EffectorIndex) -> list[int]:
    """Ids of the bodies with recorded poses: things, their grains, and a platform."""
    platform = index.platform if isinstance(index, RobotIndex) else None
    found = [body for i in compiled.things.values() for body in (i.body, *(grain for grain, _ in i.grains))]
    return [*found, platform.body] if platform else found


def _rows(poses: Sequence[Pose]) -> Floats:
    """Convert poses to an array (N, 7) as in a rollout: position and quaternion in each row."""
    return np.array([(*p.position, *p.quaternion) for p in poses]).reshape(-1, 7)


def effector_of(compiled: Compiled, name: str | None = None) -> EffectorIndex:
    """Return the hand or robot of that name; without a name the hand if there is one, else the first robot.

    Raises:
        KeyError: there is none.
    """
    choices: dict[str, EffectorIndex] = {**{h.name: h for h in compiled.hands}, **compiled.robots}
    if name is None and choices:
        return next(iter(choices.values()))
    if name not in choices:
        raise KeyError(f"no effector '{name}' in the model; there are: {', '.join(choices) or 'none'}")
    return choices[name]


def camera_poses(compiled: Compiled, data: Data) -> dict[str, Pose]:
    """Return the optical frames of the world's cameras, in the world."""
    flanges = {name: index.flange for name, index in compiled.robots.items()}
    return {
        c.name: c.pose if c.mount is None else site_pose(data, flanges[c.mount]) * c.pose
        for c in compiled.world.cameras
        if c.mount is None or c.mount in flanges
    }


def wrench(model: Model, data: Data, index: EffectorIndex) -> Floats:
    """Compute the effector's wrench on its environment, at the sensor, in world axes [N, Nm], shape (6,).

    MuJoCo's sensor gives the force of the wrist on the effector, s = m a - m g - F_environment. The effector's weight
    m g is added; its inertia m a stays in (3 to 9 N in fast free motion).
    """
    turn = data.site_xmat[index.ft].reshape(3, 3)
    force = turn @ data.sensordata[index.ft_force : index.ft_force + 3]
    torque = turn @ data.sensordata[index.ft_torque : index.ft_torque + 3]
    bodies = list(index.bodies)
    mass = model.body_mass[bodies]
    weight = np.array([0.0, 0.0, -GRAVITY * mass.sum()])
    arm = mass @ data.xipos[bodies] / mass.sum() - data.site_xpos[index.ft]
    return np.concatenate([force + weight, torque + cross(arm, weight)])


class Peaks:
    """Collector of the wrist sensor's largest forces between two samples of the recorder: with the force at
    the sample alone, peaks would be recorded by chance.

    Args:
        period: of the samples [s].
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.wrenches: list[Floats] = []
        self.forces: list[float] = []
        self.commanded: list[float] = []
        self.payload: list[float] = []
        self.grip: list[float] = []
        self._peak: Applied | None = None
        self._strongest = self._force = self._wanted = 0.0

    def see(self, time: float, arm: Controller) -> None:
        """Record a control cycle: the tool's wrench (``Rollout.wrench``) and the felt force (``Rollout.force``)."""
        applied = arm.applied()
        strong = applied.strength
        force = arm.force() if arm.sensor.tared else strong
        if self._peak is None or strong > self._strongest:
            self._peak, self._strongest = applied, strong
        wanted = _wanted(arm.force_mode)
        self._force, self._wanted = max(self._force, force), max(self._wanted, wanted)
        if time >= len(self.wrenches) * self.period - 1e-9:
            self.wrenches.append(self._peak.wrench)
            self.forces.append(self._force)
            self.commanded.append(self._wanted)
            self.payload.append(arm.sensor.mass)
            self.grip.append(arm.gripper.pressing)
            self._peak, self._strongest, self._force, self._wanted = applied, strong, force, wanted

    def arrays(self) -> dict[str, Floats]:
        """Return the fields of a rollout: wrench (N, 6) [N, Nm], force, commanded and grip (N,) [N], payload (N,) [kg]."""
        fields = {
            "wrench": self.wrenches, "force": self.forces, "commanded": self.commanded, "payload": self.payload, "grip": self.grip,
        }  # fmt: skip
        return {name: np.array(values) for name, values in fields.items()}


def _wanted(mode: ForceMode | None) -> float:
    """Return the magnitude of the force that force mode tells an arm to apply [N]; 0 outside force mode."""
    return 0.0 if mode is None else float(np.linalg.norm((mode.selection * mode.wrench)[:3]))
