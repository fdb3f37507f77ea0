"""Grip limits: the commanded force and the force of the pads, against the force that a thing bears."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Gripper, Rollout, Thing, Touch, Value, World, thing_of
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from ..motions.grip_force import most_borne
from .grips import pressed_at
from .lasting import lasting
from .task_times import task_at

CHATTER = 0.1
"""Longest duration of the force peak when closing fingers meet a thing [s]: in simulation at most two samples of 20 ms."""
PRESSED = 1.2
"""Factor on a thing's force limit for the measured force of the pads: a gripper is up to 10 % stronger than commanded (``ErrorModel``),
and a thing that is led along a support presses one pad more than the other."""
COUNTS = 255
"""Number of steps of a gripper's force register: the commanded force exceeds the planned one by up to half a step."""

PADS = ("effector/left", "effector/right")


class Limit(NamedTuple):
    """Limit of the force with which each pad may press on a thing [N], and the source of the limit."""

    thing: str
    force: float
    why: str


class GripLimits(Value):
    """Check that neither the commanded nor the simulated force of a grip is more than the thing bears."""

    name: str = "grip_limits"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        for limit in grip_limits(candidate):
            told, pressed = told_to_press(rollout, limit.thing), lasting(pressed_with(rollout, limit.thing), rollout.times, CHATTER)
            slack = half_a_step(candidate.robot.gripper)
            yield self._finding(candidate, limit, told, "the gripper was told to press", limit.force, slack)
            yield self._finding(candidate, limit, pressed, "a pad pressed", PRESSED * limit.force, 0.0)

    def _finding(self, candidate: Candidate, limit: Limit, force: Floats, verb: str, most: float, slack: float) -> Finding:
        k = int(np.argmax(force))
        said = f"{verb} '{limit.thing}' with {force[k]:.1f} N at {candidate.ran.times[k]:.1f} s, limit {most:g} N ({limit.why})"
        return Finding(self.name, bool(force[k] <= most + slack), said, float(force[k]), most, "N", task_at(candidate, k))


def grip_limits(candidate: Candidate) -> Iterator[Limit]:
    """Yield the force limit of each thing that has one: the lower of that of the believed thing and that
    of the thing in the run's world."""
    for name in sorted({t.name for w in (candidate.world, candidate.ran.world) for t in w.things}):
        things = [t for w in (candidate.world, candidate.ran.world) if (t := _thing(w, name)) is not None]
        said = [borne for t in things if (borne := most_borne(t, candidate)) is not None]
        if said:
            yield Limit(name, *min(said, key=lambda x: x[0]))


def _thing(world: World, name: str) -> Thing | None:
    return next((t for t in world.things if t.name == name), None)


def told_to_press(rollout: Rollout, thing: str) -> Floats:
    """Return the commanded grip force at each sample (N,) [N], 0 where the thing is not between both pads."""
    gripped = np.array([one == thing for one in pressed_at(rollout)])
    return np.zeros(len(gripped)) if rollout.grip is None else np.where(gripped, rollout.grip, 0.0)


def pressed_with(rollout: Rollout, thing: str) -> Floats:
    """Return the force of the pad that presses a thing harder, at each sample (N,) [N]."""
    return np.array([_harder(touches, thing) for touches in rollout.awake_touches])


def _harder(touches: tuple[Touch, ...], thing: str) -> float:
    pads = dict.fromkeys(PADS, 0.0)
    for touch in touches:
        for pad, other in ((touch.a, touch.b), (touch.b, touch.a)):
            if pad in pads and thing_of(other) == thing:
                pads[pad] += touch.pressed
    return max(pads.values())


def half_a_step(gripper: Gripper) -> float:
    """Return by how much a force register rounds a planned force [N]."""
    low, high = gripper.force
    return (high - low) / COUNTS / 2 + 1e-9


@hookimpl
def validators() -> list[Validator]:
    return [GripLimits()]
