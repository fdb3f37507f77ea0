"""Validators of the physics of a run: completion, collisions, peak forces, slip of the grasp."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import Value
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from .collision import Collision
from .grips import grips, slip
from .swings import declared
from .task_times import inner_tasks, task_at

SLIP = 0.012  # a held thing may settle this far between the pads [m]: half the pad width of a 2F-85
STOPPED = 1.15  # a program that stops at its task's force limit has gone beyond it by then: 28.3 N at 25 N, measured


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


class ForcePeak(Value):
    """Check that the force the program feels, without the weight that it carries, stayed under the limit of each task."""

    name: str = "force_peak"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.rollout
        assert rollout is not None
        running = rollout.lines > 0
        if not running.any():
            return
        running = running | np.roll(running, 1)  # a sample has the peak of the cycles before it, the program's last ones too
        force, tasks = np.where(running, rollout.contact_force(), 0.0), inner_tasks(candidate)
        limits = {task: _limit(candidate, task) for task in set(tasks)}
        k = int(np.argmax([f / limits[task][0] for f, task in zip(force, tasks, strict=True)]))
        limit, whose = limits[tasks[k]]
        reason = f"peak {force[k]:.1f} N at {rollout.times[k]:.1f} s, limit {limit:g} N {whose}"
        yield Finding(self.name, bool(force[k] <= limit), reason, float(force[k]), limit, "N", tasks[k])


class CommandedForce(Value):
    """No task told the arm to press or pull harder than the task's own limit, whether or not anything stood against it."""

    name: str = "commanded_force"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout, program = candidate.rollout, candidate.program
        assert rollout is not None
        if rollout.commanded is None or not rollout.commanded.any():
            return
        tasks, own = inner_tasks(candidate), {name: a.force for name, a in candidate.allowances.items()}
        limits = [own.get(task) or program.force_limit for task in tasks]
        k = int(np.argmax(rollout.commanded / np.array(limits)))
        force, limit = float(rollout.commanded[k]), limits[k]
        whose = f"of {tasks[k]}" if own.get(tasks[k]) else program.force_limit_source
        reason = f"told the arm to apply {force:.1f} N at {rollout.times[k]:.1f} s, limit {limit:g} N {whose}"
        yield Finding(self.name, force <= limit, reason, force, limit, "N", tasks[k])


def _limit(candidate: Candidate, task: str) -> tuple[float, str]:
    """The force limit of a task [N], and whose it is. A program that stops at its task's limit has gone beyond it by then."""
    program = candidate.program
    own = candidate.allowances[task].force if task in candidate.allowances else None
    if own is None or own * STOPPED >= program.force_limit:
        return program.force_limit, program.force_limit_source
    return own * STOPPED, f"of {task} ({own:g} N, and {STOPPED - 1:.0%} while it stops)"


class GraspSlip(Value):
    """Check that what was grasped did not move in the hand until it was let go, but for the turns that the program declares."""

    name: str = "grasp_slip"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.rollout
        assert rollout is not None
        turns = declared(candidate)
        for grip in grips(rollout):
            moved = slip(rollout, grip, turns)
            k = grip.first + int(np.argmax(moved >= min(SLIP, moved.max())))  # what came loose then ends in the task that loosened it
            reason = f"'{grip.thing}' moved {1000 * moved.max():.1f} mm in the hand, limit {1000 * SLIP:.0f} mm"
            yield Finding(
                self.name, bool(moved.max() <= SLIP), reason, float(moved.max()), SLIP, "m", task_at(candidate, k), things=True
            )


@hookimpl
def validators() -> Iterable[Validator]:
    return [Execution(), Collision(), ForcePeak(), CommandedForce(), GraspSlip()]
