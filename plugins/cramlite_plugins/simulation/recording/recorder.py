"""A recorder of simulations as ``cramlite.model.Rollout``, one for hands and robots."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from cramlite.model import EntityName, Floats, Message, Pose, Rollout, Touch, Vector3

from ..controller.controller import Controller
from ..controller.nominal_arm import cross
from ..model.compile import Compiled
from ..model.index import Data, EffectorIndex, Model, Owner, RobotIndex, site_pose
from .sight import Sight

GRAVITY = 9.81  # MuJoCo's default, which worlds do not change
WEAKEST = 1e-3  # a contact below this normal force [N] is a gap within the contact margin, not a touch


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
        self._bodies = [i.body for i in compiled.things.values()]
        self._pairs = Pairs(compiled, self.index.name)
        self.period = 1.0 / rate
        self.messages: list[Message] = []
        self._samples: list[dict[str, Any]] = []
        self._sight = Sight(compiled)

    def observe(self, data: Data, line: int = 0) -> None:
        """Record a sample if one is due. The state must be consistent, as it is after mj_step or mj_forward."""
        if data.time >= len(self._samples) * self.period - 1e-9:
            self._sight.look(data, camera_poses(self.compiled, data), len(self._samples) * self.period)
            self._samples.append(self._sample(data, line))

    def message(self, time: float, text: str, line: int = 0) -> None:
        """Add a line to the program's log."""
        self.messages.append(Message(time, text, line))

    def rollout(self, outcome: str = "finished", reason: str = "") -> Rollout:
        """Return everything so far as a rollout. Times are those of the samples' due dates."""
        samples = self._samples
        names = samples[0]["poses"] if samples else ()
        joints = samples[0]["values"] if samples else ()
        return Rollout(
            world=self.compiled.world,
            effector=self.index.name,
            times=np.array([i * self.period for i in range(len(samples))]),
            poses=self._things() | {n: np.array([s["poses"][n] for s in samples]) for n in names},
            touches=tuple(s["touches"] for s in samples),
            joints=np.array([s["joints"] for s in samples]).reshape(len(samples), -1),
            wrench=np.array([s["wrench"] for s in samples]).reshape(-1, 6) if self._wrench else np.zeros((len(samples), 6)),
            opening=np.array([s["opening"] for s in samples]),
            lines=np.array([s["line"] for s in samples], dtype=float),
            messages=tuple(self.messages),
            outcome=outcome,
            reason=reason,
            values={n: np.array([s["values"][n] for s in samples]) for n in joints},
            grains={n: np.array([s["grains"][n] for s in samples]) for n in (samples[0]["grains"] if samples else ())},
            sizes=self._sizes(),
            seen=self._sight.seen,
        )

    def _things(self) -> dict[str, Floats]:
        """Thing -> (N, 7) its poses."""
        if not self._samples or not self._bodies:
            return {}
        rows = np.concatenate([np.array([s["things"][k] for s in self._samples]) for k in (0, 1)], axis=2)
        return {name: rows[:, k].copy() for k, name in enumerate(self.compiled.things)}

    def _sizes(self) -> dict[str, Vector3]:
        platform = self.index.robot.platform if isinstance(self.index, RobotIndex) else None
        return {str(EntityName(self.index.name, "base")): platform.size} if platform else {}

    def _sample(self, data: Data, line: int) -> dict[str, Any]:
        model, index = self.compiled.model, self.index
        effector = index.pose(data)
        frames = {"effector": effector, **finger_poses(data, index, at=effector)}
        frames |= camera_poses(self.compiled, data)
        for hand in self.compiled.hands:
            if hand.name != index.name:
                frames |= {hand.name: hand.pose(data), **finger_poses(data, hand, hand.name)}
        if isinstance(index, RobotIndex) and index.platform is not None:
            frames[str(EntityName(index.name, "base"))] = index.platform.pose(data)
        joints = data.qpos[list(index.joints)].copy() if isinstance(index, RobotIndex) else ()
        return {
            "things": (data.xpos[self._bodies], data.xquat[self._bodies]),
            "poses": {n: (*p.position, *p.quaternion) for n, p in frames.items()},
            "touches": touches(self.compiled, data, index.name, self._pairs),
            "joints": joints,
            "wrench": wrench(model, data, index) if self._wrench else (),
            "opening": index.opening(model, data),
            "line": line,
            "values": {t: float(data.qpos[i.joint]) for t, i in self.compiled.things.items() if i.joint is not None},
            "grains": {t: data.xpos[[b for b, _ in i.grains]] for t, i in self.compiled.things.items() if i.grains},
        }


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


def finger_poses(data: Data, index: EffectorIndex, name: str = "effector", at: Pose | None = None) -> dict[str, Pose]:
    """Return the poses of both finger tips in the world: the middle of the pads, with the tool frame's orientation.

    Args:
        at: the tool frame, where it is known already.
    """
    turn = (at or index.pose(data)).quaternion
    places, sides = data.geom_xpos, (("left", index.left), ("right", index.right))
    middle = {str(EntityName(name, side)): places[list(pads)].sum(axis=0) / len(pads) for side, pads in sides}
    return {finger: Pose(tuple(place), turn) for finger, place in middle.items()}


def camera_poses(compiled: Compiled, data: Data) -> dict[str, Pose]:
    """Return the optical frames of the world's cameras, in the world."""
    flanges = {name: index.flange for name, index in compiled.robots.items()}
    return {
        c.name: c.pose if c.mount is None else site_pose(data, flanges[c.mount]) * c.pose
        for c in compiled.world.cameras
        if c.mount is None or c.mount in flanges
    }


class Pairs:
    """Names of pairs of geoms in contact, each looked up once: a contact lasts for many samples.

    Args:
        effector: whose fingers are "effector/left" and "effector/right".
    """

    def __init__(self, compiled: Compiled, effector: str) -> None:
        self._owners, self._effector = compiled.owners, effector
        self._known: dict[tuple[int, int], tuple[tuple[str, str], bool] | None] = {}

    def of(self, first: int, second: int) -> tuple[tuple[str, str], bool] | None:
        """Return the names as a ``Touch`` has them, and whether they are the other way round; None for contacts that are left out."""
        if (first, second) not in self._known:
            self._known[first, second] = self._named(self._owners[first], self._owners[second])
        return self._known[first, second]

    def _named(self, one: Owner, two: Owner) -> tuple[tuple[str, str], bool] | None:
        if one.name == two.name or "grain" in (one.kind, two.kind):
            return None
        first, second = _name(one, self._effector), _name(two, self._effector)
        flip = (one.kind == "thing", first) > (two.kind == "thing", second)
        return ((second, first) if flip else (first, second)), flip


def touches(compiled: Compiled, data: Data, effector: str, pairs: Pairs | None = None) -> tuple[Touch, ...]:
    """List the contacts of a state, summed over the points of each pair.

    Contacts within an arm or an effector, and those of grains, are left out. In each pair ``a`` is the effector or robot if one takes part,
    else the first by name. Fingers of any other effector than the named one are "mount/left" and so on.

    Args:
        pairs: names that are known already.
    """
    pairs = pairs or Pairs(compiled, effector)
    sums: dict[tuple[str, str], list[float]] = {}
    force, contact = np.zeros(6), data.contact
    frames, normal = contact.frame, force[:3]
    for i, (first, second) in enumerate(contact.geom.tolist()):
        named = pairs.of(first, second)
        if named is None:
            continue
        mujoco.mj_contactForce(compiled.model, data, i, force)
        pushed = float(force[0])
        if pushed < WEAKEST:
            continue
        # the frame's rows are the contact axes; the force is the one of the first geom on the second
        pair, flip = named
        lift = float(frames[i, 2::3] @ normal)
        total = sums.setdefault(pair, [0.0, 0.0])
        total[0] += pushed
        total[1] += -lift if flip else lift
    return tuple(Touch(a, b, f, u) for (a, b), (f, u) in sorted(sums.items()))


def _name(owner: Owner, effector: str) -> str:
    own = owner.kind != "effector" or owner.name == effector
    return owner.touch if own else str(EntityName(owner.name, owner.part))


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
    """A collector of peak forces of a wrist sensor between two samples of the recorder: a single cycle's force would make
    peaks a matter of chance.

    Args:
        period: of the samples [s].
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.wrenches: list[Floats] = []
        self.forces: list[float] = []
        self.commanded: list[float] = []
        self._wrench, self._force, self._wanted, self._strongest = np.zeros(6), 0.0, 0.0, 0.0

    def see(self, time: float, arm: Controller) -> None:
        """Record a control cycle: the tool's wrench (``Rollout.wrench``) and the felt force (``Rollout.force``)."""
        applied = arm.applied_force()
        strong = math.sqrt(applied @ applied)  # numpy's norm takes three times as long for three numbers
        force = arm.force() if arm.sensor.tared else math.hypot(*applied)
        if strong > self._strongest:
            self._wrench, self._strongest = arm.applied(), strong
        self._force = max(self._force, force)
        mode = arm.force_mode
        wanted = 0.0 if mode is None else float(np.linalg.norm((mode.selection * mode.wrench)[:3]))
        self._wanted = max(self._wanted, wanted)
        if time >= len(self.wrenches) * self.period - 1e-9:
            self.wrenches.append(self._wrench)
            self.forces.append(self._force)
            self.commanded.append(self._wanted)
            self._wrench, self._force, self._wanted, self._strongest = arm.applied(), force, wanted, strong

    def arrays(self) -> dict[str, Floats]:
        """Return the fields of a rollout: wrench (N, 6) [N, Nm], force (N,) [N]."""
        fields = {"wrench": self.wrenches, "force": self.forces, "commanded": self.commanded}
        return {name: np.array(values) for name, values in fields.items()}
