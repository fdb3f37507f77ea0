"""A simulated person's hands: targets at each instant, and the simulation that follows them.

Movements are minimum-jerk (Flash and Hogan 1985: s = 10 u^3 - 15 u^4 + 6 u^5) along curved paths; on them lie a slow
drift of about a millimetre and the physiological tremor of 8 to 12 Hz, 0.1 to 0.3 mm (Elble and Koller 1990).
Everything that varies comes from one NumPy generator.

Scripts move the hand that acts. Of a person with two hands the other one keeps still, or does what it was told to do
meanwhile (``other``); ``change_hands`` makes it the one that acts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
from msgspec import Struct, field

from cramlite.model import Floats, Pose, Rollout
from cramlite.plugin import UserError, checkpoint

from ..simulation.model.compile import Compiled, divergence, unstable
from ..simulation.model.hand_model import HandIndex
from ..simulation.model.index import Data
from ..simulation.recording.recorder import Recorder

#: Amplitudes of drift and tremor: [m] and [rad]; the lowest and highest frequency of each [Hz].
DRIFT, TREMOR = (0.0008, 0.006), (0.0002, 0.001)
SLOW, FAST = (0.15, 0.9), (8.0, 12.0)
#: The hand's targets are renewed at this rate [Hz].
CONTROL = 100.0
SHORTEST = 0.15


class Limb(Struct):
    """One hand of the simulated person: its present target, and a queue of targets for the next control
    periods.

    Args:
        index: in the model.
        aim: target of the tool frame.
        opening: target of the fingers [m].
        waves: its drift and tremor.
        queue: further targets, one for each control period.
    """

    index: HandIndex
    aim: Pose
    opening: float
    waves: Waves
    queue: deque[tuple[Pose, float]] = field(default_factory=deque)

    def move(self, path: Sequence[Pose], speed: float, *, curved: bool = False) -> None:
        """Queue a movement along poses of the tool frame in the world, with a mean speed [m/s]."""
        self.queue.extend((aim, self._last[1]) for aim in way(self._last[0], path, speed, curved=curved))

    def grip(self, opening: float, seconds: float) -> None:
        """Queue a movement of the fingers to an opening [m] within a time [s]."""
        aim, first = self._last
        self.queue.extend((aim, first + u * (opening - first)) for u in _fractions(seconds))

    def wait(self, seconds: float) -> None:
        """Queue a time of keeping still [s]."""
        self.queue.extend([self._last] * len(_fractions(seconds)))

    def follow(self, data: Data) -> None:
        """Command the servos for a control period: the target plus drift and tremor."""
        if self.queue:
            self.aim, self.opening = self.queue.popleft()
        noise = self.waves(data.time).tolist()
        place = np.add(self.aim.position, noise[:3])
        shaken = Pose(tuple(place), self.aim.quaternion) * Pose.from_rotvec((0, 0, 0), noise[3:])
        self.index.set_target(data, shaken, self.opening)

    @property
    def _last(self) -> tuple[Pose, float]:
        return self.queue[-1] if self.queue else (self.aim, self.opening)


class Person:
    """Simulated person who moves the hands of a compiled world.

    Args:
        compiled: with one or two hands.
        rng: where all variety comes from.
        starts: of the tool frames.
        rate: samples of the recording a second.
    """

    def __init__(self, compiled: Compiled, rng: np.random.Generator, starts: Sequence[Pose], rate: float) -> None:
        if compiled.hand is None:
            raise ValueError("the world was compiled without a hand")
        self.compiled, self.rng = compiled, rng
        self.data, self._imagined = compiled.data(), compiled.data()
        self.recorder = Recorder(compiled, compiled.hand.name, rate)
        limbs = [Limb(h, s, h.reach[1], Waves(rng)) for h, s in zip(compiled.hands, starts, strict=True)]
        self.limb, self.other = limbs[0], limbs[1] if len(limbs) > 1 else None
        self.pace = 1.0
        for limb in limbs:
            limb.index.teleport(compiled.model, self.data, limb.aim, limb.opening)
        mujoco.mj_forward(compiled.model, self.data)

    @property
    def aim(self) -> Pose:
        """Return the target pose of the tool frame of the hand that acts, in the world."""
        return self.limb.aim

    @property
    def opening(self) -> float:
        """Return the target opening of the hand that acts [m]."""
        return self.limb.opening

    def change_hands(self) -> None:
        """Make the other hand the one that acts.

        Raises:
            ValueError: there is none.
        """
        if self.other is None:
            raise ValueError("a person with one hand cannot change hands")
        self.limb, self.other = self.other, self.limb

    def pose(self, thing: str) -> Pose:
        """Return the pose of a thing in the world, as the person sees it."""
        return self.compiled.pose(self.data, thing)

    def tool(self) -> Pose:
        """Return the tool frame of the hand that acts, in the world."""
        return self.limb.index.pose(self.data)

    def touches(self, thing: str) -> bool:
        """Check whether anything of the hand that acts is in contact with a thing."""
        return bool(self._touching(thing))

    def holds(self, thing: str) -> bool:
        """Check whether both fingers of the hand that acts are in contact with a thing."""
        return {"left", "right"} <= self._touching(thing)

    def fits(self, tool: Pose, opening: float) -> bool:
        """Check that the hand, with its fingers at an opening [m], would touch nothing at a pose of its tool frame."""
        index, model = self.limb.index, self.compiled.model
        self._imagined.qpos[:] = self.data.qpos
        try:
            index.teleport(model, self._imagined, tool, opening)
        except UserError:  # turned too far from rest
            return False
        mujoco.mj_fwdPosition(model, self._imagined)
        return not self._touching("", self._imagined)

    def _touching(self, thing: str, data: Data | None = None) -> set[str]:
        """Parts of the acting hand that are in contact with a thing; with anything, if none is named."""
        found = set()
        data = data or self.data
        for pair in data.contact.geom[: data.ncon].tolist():
            for mine, theirs in (pair, pair[::-1]):
                own, other = self.compiled.owners[mine], self.compiled.owners[theirs]
                if own.kind == "effector" and own.name == self.limb.index.name and thing in ("", other.name):
                    found.add(own.part)
        return found

    def move(self, path: Sequence[Pose], speed: float, *, curved: bool = False) -> None:
        """Move the hand from its present target pose through other poses to the last of them.

        Args:
            path: targets of the tool frame; orientation turns from the present one to the last.
            speed: mean speed [m/s].
            curved: the poses between are passed at a distance (Bézier), not reached.
        """
        for aim in way(self.aim, path, speed * self.pace, curved=curved):
            self._follow(aim, self.opening)
        self.limb.aim = path[-1]

    def follow(self, path: Sequence[Pose], seconds: float) -> None:
        """Move the hand from its present target through poses within a time [s], with the same time for each
        leg."""
        poses = [self.aim, *path]
        for u in _fractions(seconds):
            k = min(int(u * len(path)), len(path) - 1)
            share = u * len(path) - k
            place = np.add(poses[k].position, share * np.subtract(poses[k + 1].position, poses[k].position))
            self._follow(Pose(tuple(place), slerp(poses[k], poses[k + 1], share).quaternion), self.opening)

    def grip(self, opening: float, seconds: float) -> None:
        """Move the fingers to an opening [m] within a time [s]."""
        first = self.opening
        for u in _fractions(seconds):
            self._follow(self.aim, first + u * (opening - first))
        self.limb.opening = opening

    def wait(self, seconds: float) -> None:
        """Keep still for a time [s], except for drift and tremor."""
        for _ in _fractions(seconds):
            self._follow(self.aim, self.opening)

    def wait_for_other(self) -> None:
        """Keep still until the other hand has executed its queue."""
        while self.other is not None and self.other.queue:
            self._follow(self.aim, self.opening)

    def shake(self, share: float) -> None:
        """Multiply the tremor of both hands by a factor."""
        for limb in (self.limb, *([self.other] if self.other else [])):
            limb.waves.size[3:] *= share

    def rollout(self) -> Rollout:
        """Return the recording up to now as a rollout."""
        return self.recorder.rollout()

    def between(self, low: float, high: float) -> float:
        """Draw a number between two limits, uniformly."""
        return float(self.rng.uniform(low, high))

    def _follow(self, aim: Pose, opening: float) -> None:
        """Advance the simulation by one control period, in which both hands follow their targets."""
        checkpoint()
        self.limb.aim, self.limb.opening = aim, opening
        for limb in (self.limb, *([self.other] if self.other else [])):
            limb.follow(self.data)
        for _ in range(max(round(1 / (CONTROL * self.compiled.model.opt.timestep)), 1)):
            mujoco.mj_step(self.compiled.model, self.data)
            self.recorder.observe(self.data)
        if reason := unstable(divergence(self.data)):
            raise UserError(f"the demonstration cannot be recorded: {reason}")


def way(aim: Pose, path: Sequence[Pose], speed: float, *, curved: bool = False) -> Iterator[Pose]:
    """Sample a minimum-jerk movement from pose ``aim`` along a path of poses, one pose for each control
    period; see ``Person.move``."""
    points = np.array([p.position for p in (aim, *path)])
    line = _bezier(points) if curved else points
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    turn = aim.distance(path[-1])[1]
    for u in _fractions(max(lengths[-1] / speed, turn / (speed * 6.0), SHORTEST)):
        at = [float(np.interp(u * lengths[-1], lengths, line[:, i])) for i in range(3)]
        yield Pose(tuple(at), slerp(aim, path[-1], u).quaternion)  # type: ignore[arg-type]


def _fractions(seconds: float) -> Floats:
    """Shares of the way that a minimum-jerk movement has gone, one for each control period."""
    u = np.arange(1, max(round(seconds * CONTROL), 1) + 1) / max(round(seconds * CONTROL), 1)
    return np.asarray(u**3 * (10 - 15 * u + 6 * u * u))


class Waves:
    """Drift and tremor of a hand over time: (6,) position [m] and rotation vector [rad], each entry a sum of sines."""

    def __init__(self, rng: np.random.Generator) -> None:
        shape = (3, 6)
        self.frequency = 2 * math.pi * np.concatenate([rng.uniform(*SLOW, shape), rng.uniform(*FAST, shape)])
        self.phase = rng.uniform(0, 2 * math.pi, (6, 6))
        sizes = np.array([[a[0]] * 3 + [a[1]] * 3 for a in (DRIFT, DRIFT, DRIFT, TREMOR, TREMOR, TREMOR)])
        self.size = sizes * rng.uniform(0.3, 1.0, (6, 6)) / math.sqrt(3)

    def __call__(self, time: float) -> Floats:
        return np.asarray((self.size * np.sin(self.frequency * time + self.phase)).sum(axis=0))


def slerp(a: Pose, b: Pose, u: float) -> Pose:
    """Return the orientation that is a share ``u`` of the shortest turn from ``a`` to ``b``; the position is zero."""
    turn = Pose((0, 0, 0), a.quaternion).inverse() * Pose((0, 0, 0), b.quaternion)
    return Pose((0, 0, 0), a.quaternion) * Pose.from_rotvec((0, 0, 0), np.multiply(turn.rotvec, u).tolist())


def _bezier(points: Floats, samples: int = 40) -> Floats:
    """The Bézier curve of control points (K, 3), sampled; by de Casteljau's construction."""
    u = np.linspace(0, 1, samples)[:, None, None]
    layer = np.broadcast_to(points, (samples, *points.shape))
    while layer.shape[1] > 1:
        layer = (1 - u) * layer[:, :-1] + u * layer[:, 1:]
    return np.asarray(layer[:, 0])
