"""Validators of the physics of a run: completion, collisions, peak forces, slip of the grasp."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import Rollout, Value, thing_of
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

SLIP = 0.012  # a held thing may settle this far between the pads [m]: half the pad width of a 2F-85
BRUSH = 2.0  # contact force below this is a brush, not a collision [N]: the guarded threshold of the controller


def task_at(candidate: Candidate, sample: int) -> str:
    """Return the task whose code ran at a sample."""
    assert candidate.rollout is not None and candidate.code is not None
    return candidate.code.task_of(int(candidate.rollout.lines[sample]))


class Execution(Value):
    """Check that the text ran to its end."""

    name: str = "execution"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.rollout
        assert rollout is not None
        running = np.flatnonzero(rollout.lines)
        last = int(running[-1]) if len(running) else 0
        if rollout.outcome == "finished":
            yield Finding(
                self.name, True, f"ran to its end in {rollout.times[last]:.1f} s", float(rollout.times[last]), None, "s"
            )
        else:
            line = int(rollout.lines[last])
            reason = f"{rollout.outcome} at line {line}, {rollout.times[last]:.1f} s: {rollout.reason}"
            yield Finding(self.name, False, reason, origin=task_at(candidate, last))


class Collision(Value):
    """Check that the arm touched nothing, and the hand and what it held only what its task is about."""

    name: str = "collision"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        worst = max(_bumps(candidate), default=None)
        if worst is None:
            yield Finding(self.name, True, "nothing was touched that no task is about", 0.0, BRUSH, "N")
        else:
            force, sample, a, b = worst
            task = task_at(candidate, sample)
            assert candidate.rollout is not None
            reason = f"'{a}' hit '{b}' with {force:.0f} N at {candidate.rollout.times[sample]:.1f} s"
            yield Finding(self.name, False, reason, force, BRUSH, "N", task)


def _bumps(candidate: Candidate) -> Iterator[tuple[float, int, str, str]]:
    """(force, sample, one, other) of touches that no role explains."""
    rollout = candidate.rollout
    assert rollout is not None
    allowed = {a.name: {o.thing for o in a.roles.values()} for a in candidate.actions}
    meant: set[str] = set().union(*allowed.values()) if allowed else set()
    for k, touches in enumerate(rollout.touches):
        for touch in touches:
            if touch.force > BRUSH and not _explained(touch.a, touch.b, meant, candidate.program.robot):
                yield touch.force, k, touch.a, touch.b


def _explained(a: str, b: str, meant: set[str], robot: str) -> bool:
    one, other = thing_of(a), thing_of(b)
    if robot in (one, other):
        return False
    if "effector" in (one, other):
        return (other if one == "effector" else one) in meant | {"effector"}
    return one in meant or other in meant or not {one, other} & meant


class ForcePeak(Value):
    """Check that the force the program feels, without the weight that it carries, stayed under its limit."""

    name: str = "force_peak"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout, program = candidate.rollout, candidate.program
        assert rollout is not None
        running = rollout.lines > 0
        if not running.any():
            return
        force = np.where(running, rollout.contact_force(), 0.0)
        k = int(np.argmax(force))
        limit = program.force_limit
        reason = f"peak {force[k]:.1f} N at {rollout.times[k]:.1f} s, limit {limit:g} N {program.force_limit_source}"
        yield Finding(self.name, bool(force[k] <= limit), reason, float(force[k]), limit, "N", task_at(candidate, k))


class GraspSlip(Value):
    """Check that what was grasped did not move in the hand until it was let go."""

    name: str = "grasp_slip"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.rollout
        assert rollout is not None
        for thing, first, last in grasps(rollout):
            moved = slip(rollout, thing, first, last)
            k = first + int(np.argmax(moved))
            reason = f"'{thing}' moved {1000 * moved.max():.1f} mm in the hand, limit {1000 * SLIP:.0f} mm"
            yield Finding(
                self.name, bool(moved.max() <= SLIP), reason, float(moved.max()), SLIP, "m", task_at(candidate, k)
            )


def grasps(rollout: Rollout) -> Iterator[tuple[str, int, int]]:
    """Yield (thing, first sample, last sample) of every stretch of at least 0.2 s in which both pads press one thing."""
    held = [_pressed(touches) for touches in rollout.touches]
    start = 0
    for k in range(1, len(held) + 1):
        if k == len(held) or held[k] != held[start]:
            if held[start] and rollout.times[k - 1] - rollout.times[start] >= 0.2:
                yield held[start], start, k - 1
            start = k


def _pressed(touches: Iterable[object]) -> str:
    sides: dict[str, set[str]] = {"effector/left": set(), "effector/right": set()}
    for touch in touches:
        a, b = touch.a, touch.b  # type: ignore[attr-defined]
        for pad, other in ((a, b), (b, a)):
            if pad in sides:
                sides[pad].add(thing_of(other))
    both = (sides["effector/left"] & sides["effector/right"]) - {"effector"}
    return min(both, default="")


def slip(rollout: Rollout, thing: str, first: int, last: int) -> np.ndarray:
    """Return how far a thing moved in the effector's frame since ``first``, at each sample up to ``last`` [m].

    The first and last tenth of a second are left out: fingers that close or open push a thing.
    """
    from scipy.spatial.transform import Rotation

    step = float(np.median(np.diff(rollout.times)))
    margin = min(int(0.1 / step), (last - first) // 3)
    rows = slice(first + margin, last - margin + 1)
    hand, object_ = rollout.poses["effector"][rows], rollout.poses[thing][rows]
    local = Rotation.from_quat(hand[:, 3:], scalar_first=True).inv().apply(object_[:, :3] - hand[:, :3])
    return np.asarray(np.linalg.norm(local - local[0], axis=1))


@hookimpl
def validators() -> Iterable[Validator]:
    return [Execution(), Collision(), ForcePeak(), GraspSlip()]
