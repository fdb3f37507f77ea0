"""A person's hand: where it wants to be at each instant, and the simulation that follows.

Movements are minimum-jerk (Flash and Hogan 1985: s = 10 u^3 - 15 u^4 + 6 u^5) along curved paths; on them lie a slow
drift of about a millimetre and the physiological tremor of 8 to 12 Hz, 0.1 to 0.3 mm (Elble and Koller 1990).
Everything that varies comes from one NumPy generator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from cramlite.errors import UserError
from cramlite.geometry import Floats, Pose
from cramlite.rollout import Rollout

from .compile import Compiled, unstable
from .hand import HandIndex
from .recorder import Recorder

#: Amplitudes of drift and tremor: [m] and [rad]; the lowest and highest frequency of each [Hz].
DRIFT, TREMOR = (0.0008, 0.006), (0.0002, 0.001)
SLOW, FAST = (0.15, 0.9), (8.0, 12.0)
#: The hand's targets are renewed at this rate [Hz].
CONTROL = 100.0
SHORTEST = 0.15


class Person:
    """Somebody who moves the hand of a compiled world.

    Args:
        compiled: with a hand.
        rng: where all variety comes from.
        start: of the tool frame.
        rate: samples of the recording a second.
    """

    def __init__(self, compiled: Compiled, rng: np.random.Generator, start: Pose, rate: float) -> None:
        if compiled.hand is None:
            raise ValueError("the world was compiled without a hand")
        self.compiled, self.rng, self.aim = compiled, rng, start
        self.hand: HandIndex = compiled.hand
        self.opening = self.hand.reach[1]
        self.data = compiled.data()
        self.recorder = Recorder(compiled, "hand", rate)
        self._waves = Waves(rng)
        self.pace = 1.0
        self.hand.teleport(compiled.model, self.data, start, self.opening)
        mujoco.mj_forward(compiled.model, self.data)

    def pose(self, thing: str) -> Pose:
        """Where the person sees a thing."""
        return self.compiled.pose(self.data, thing)

    def tool(self) -> Pose:
        """Where the person feels the hand."""
        return self.hand.pose(self.data)

    def move(self, path: Sequence[Pose], speed: float, *, curved: bool = False) -> None:
        """Bring the hand along poses, the present aim first.

        Args:
            path: targets of the tool frame; orientation turns from the present one to the last.
            speed: mean speed [m/s].
            curved: the poses between are passed at a distance (Bézier), not reached.
        """
        points = np.array([p.position for p in (self.aim, *path)])
        line = _bezier(points) if curved else points
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        turn = self.aim.distance(path[-1])[1]
        speed *= self.pace
        seconds = max(lengths[-1] / speed, turn / (speed * 6.0), SHORTEST)
        first, last = self.aim, path[-1]
        for u in self._fractions(seconds):
            at = [float(np.interp(u * lengths[-1], lengths, line[:, i])) for i in range(3)]
            self._follow(Pose(tuple(at), slerp(first, last, u).quaternion), self.opening)  # type: ignore[arg-type]
        self.aim = path[-1]

    def grip(self, opening: float, seconds: float) -> None:
        """Close or open the fingers."""
        first = self.opening
        for u in self._fractions(seconds):
            self._follow(self.aim, first + u * (opening - first))
        self.opening = opening

    def wait(self, seconds: float) -> None:
        """Keep still, as far as a person can."""
        for _ in self._fractions(seconds):
            self._follow(self.aim, self.opening)

    def shake(self, share: float) -> None:
        """Shake this much more, or less, than most."""
        self._waves.size[3:] *= share

    def rollout(self) -> Rollout:
        """Everything so far."""
        return self.recorder.rollout()

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def _fractions(self, seconds: float) -> Floats:
        u = np.arange(1, max(round(seconds * CONTROL), 1) + 1) / max(round(seconds * CONTROL), 1)
        return np.asarray(u**3 * (10 - 15 * u + 6 * u * u))

    def _follow(self, aim: Pose, opening: float) -> None:
        """One control period: the aim, off by drift and tremor, for the servos to reach."""
        noise = self._waves(self.data.time)
        shaken = Pose(tuple(np.add(aim.position, noise[:3])), aim.quaternion) * Pose.from_rotvec((0, 0, 0), noise[3:])  # type: ignore[arg-type]
        self.hand.set_target(self.data, shaken, opening)
        for _ in range(max(round(1 / (CONTROL * self.compiled.model.opt.timestep)), 1)):
            mujoco.mj_step(self.compiled.model, self.data)
            self.recorder.observe(self.data)
        if reason := unstable(self.data):
            raise UserError(f"the demonstration cannot be recorded: {reason}")


class Waves:
    """Drift and tremor at an instant: (6,) position [m] and rotation vector [rad], each a sum of sines."""

    def __init__(self, rng: np.random.Generator) -> None:
        shape = (3, 6)
        self.frequency = 2 * math.pi * np.concatenate([rng.uniform(*SLOW, shape), rng.uniform(*FAST, shape)])
        self.phase = rng.uniform(0, 2 * math.pi, (6, 6))
        sizes = np.array([[a[0]] * 3 + [a[1]] * 3 for a in (DRIFT, DRIFT, DRIFT, TREMOR, TREMOR, TREMOR)])
        self.size = sizes * rng.uniform(0.3, 1.0, (6, 6)) / math.sqrt(3)

    def __call__(self, time: float) -> Floats:
        return np.asarray((self.size * np.sin(self.frequency * time + self.phase)).sum(axis=0))


def slerp(a: Pose, b: Pose, u: float) -> Pose:
    """The orientation a share ``u`` of the shortest turn from ``a`` to ``b``; no position."""
    turn = Pose((0, 0, 0), a.quaternion).inverse() * Pose((0, 0, 0), b.quaternion)
    return Pose((0, 0, 0), a.quaternion) * Pose.from_rotvec((0, 0, 0), np.multiply(turn.rotvec, u).tolist())


def _bezier(points: Floats, samples: int = 40) -> Floats:
    """The Bézier curve of control points (K, 3), sampled; by de Casteljau's construction."""
    u = np.linspace(0, 1, samples)[:, None, None]
    layer = np.broadcast_to(points, (samples, *points.shape))
    while layer.shape[1] > 1:
        layer = (1 - u) * layer[:, :-1] + u * layer[:, 1:]
    return np.asarray(layer[:, 0])
