"""Payload that the controller is told, against the load on the arm's flange: the gripper, and a held thing
with its believed mass."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Rollout, Thing, Touch, Value, seen_from, thing_of
from cramlite.plugin import HAND, Candidate, Cost, Finding, Validator, hookimpl

from ..motions.grip_force import load
from .grips import Grip, grips
from .lasting import lasting
from .task_times import task_at

TELLING = 1.0
"""Longest time between a grip or release and the setting of the payload on the controller [s]: gripper and program take 0.1 to 0.4 s."""
SHARE, LEAST = 0.1, 0.1
"""Largest error of the payload that is set on the controller, as a share of it, or in [kg], whichever is more: half the doubt about
masses (``ErrorModel``); a third of the 3 N by which a guarded motion knows a contact."""
ALONG = 0.03
"""Largest shift of contents, or of things on another, in the frame of their carrier [m]."""


class Hanging(NamedTuple):
    """Least and largest mass that may hang on the flange at each sample (N,) [kg], and in words what hangs there."""

    least: Floats
    most: Floats
    what: list[str]


class Payload(Value):
    """Check that the controller is given the mass of the arm's load, in time."""

    name: str = "payload"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        if rollout.payload is None:
            return
        if not rollout.payload.any():
            yield self._never(candidate)
            return
        hanging = hanging_on(candidate)
        share = lasting(_share(rollout.payload, hanging), rollout.times, TELLING)
        k = int(np.argmax(share))
        limit, passed = float(_slack(hanging.most[k])), bool(share[k] <= 1.0)
        off, when = float(share[k] * limit), f"at {rollout.times[k]:.1f} s, and still {TELLING:g} s later"
        wrong = f"the arm was told that {rollout.payload[k]:.2f} kg hang on it {when}, instead of {hanging.what[k]}"
        reason = f"{'the arm was told what hangs on it' if passed else wrong}: off by {off:.2f} kg, limit {limit:.2f} kg"
        yield Finding(self.name, passed, reason, off, limit, "kg", task_at(candidate, k), places=False)

    def _never(self, candidate: Candidate) -> Finding:
        """Finding on a program text that sets no payload: it passes, unless the typed program that it was
        written from sets one."""
        said, wanted = "the program sets no payload", candidate.program.mass
        if wanted > 0:
            return Finding(self.name, False, f"{said}; the program that was proven begins with {wanted:.2f} kg", places=False)
        return Finding(self.name, True, f"{said}; the controller uses the payload of its own settings")


def _slack(mass: Floats | float) -> Floats:
    """Tolerance of the payload mass that the controller is told [kg]."""
    return np.maximum(LEAST, SHARE * np.asarray(mass))


def _share(told: Floats, hanging: Hanging) -> Floats:
    """Error of the payload mass that the controller is told, divided by the permitted error; 0 until a
    mass is told."""
    off = np.maximum(np.maximum(hanging.least - told, told - hanging.most), 0.0) / _slack(hanging.most)
    off[: int(np.argmax(told > 0))] = 0.0
    return np.asarray(off)


def hanging_on(candidate: Candidate) -> Hanging:
    """Return the least and the largest mass that may hang on the flange at each sample.

    While the payload stands on something, the least load is that of the gripper alone. The least load counts
    vessels as empty, the largest one as full.
    """
    rollout, mass = candidate.ran, candidate.robot.gripper.mass
    count, awake = len(rollout.times), rollout.awake_touches
    least, most, what = np.full(count, mass), np.full(count, mass), [f"the gripper's {mass:.2f} kg"] * count
    for grip in (g for g in grips(rollout) if rollout.world.thing(g.thing).joint is None):  # a joint carries what it moves
        carried = [_believed(candidate, name) for name in (grip.thing, *_along(rollout, grip))]
        empty, full = (sum(weigh(t) for t in carried) for weigh in (_empty, load))
        said = f"{mass + full:.2f} kg of the gripper and {', '.join(repr(t.name) for t in carried)}"
        for k in range(grip.first, grip.last + 1):
            stands = _stands(awake[k], {t.name for t in carried})
            least[k], most[k], what[k] = mass + (0.0 if stands else empty), mass + full, said
    return Hanging(least, most, what)


def _believed(candidate: Candidate, name: str) -> Thing:
    """Return a thing as the robot believes it to be; as it really is if it is not in the belief."""
    return next(t for w in (candidate.world, candidate.ran.world) for t in w.things if t.name == name)


def _empty(thing: Thing) -> float:
    """The mass of a thing, without contents [kg]."""
    return thing.mass or 0.0


def _along(rollout: Rollout, grip: Grip) -> Iterator[str]:
    """Things that the payload takes along: at the middle of the grip they touch the payload, or another thing
    that it takes along.

    They also stay at rest in the hand's frame.
    """
    loose = {t.name for t in rollout.world.things if not t.furniture} - {grip.thing}
    pairs = [frozenset({thing_of(t.a), thing_of(t.b)}) for t in rollout.touches[(grip.first + grip.last) // 2]]
    found, new = set[str](), {grip.thing}
    while new:
        near = {one for pair in pairs if pair & new for one in pair & loose} - found
        new = {one for one in near if _shift(rollout, grip, one) < ALONG}
        found |= new
    yield from sorted(found)


def _shift(rollout: Rollout, grip: Grip, name: str) -> float:
    """Motion of a thing in the frame of the payload, from its grip to its release [m]."""
    rows = [grip.first, grip.last]
    held, other = rollout.poses[grip.thing][rows], rollout.poses[name][rows]
    local = seen_from(held, other[:, :3])
    return float(np.linalg.norm(local[1] - local[0]))


def _stands(touches: Iterable[Touch], carried: set[str]) -> bool:
    """Whether something other than the hand touches the payload."""
    pairs = ({HAND if thing_of(one) == "effector" else thing_of(one) for one in (t.a, t.b)} for t in touches)
    return any(pair & carried and pair - carried - {HAND} for pair in pairs)


@hookimpl
def validators() -> list[Validator]:
    return [Payload()]
