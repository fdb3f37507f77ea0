"""Validators of the physics of a run: completion, collisions, peak forces, slip of the grasp."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import Remedy, Value, force_while_running
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from .collision import Collision
from .contact_force import force_limits, task_forces
from .empty_hand import closed_on_nothing
from .grips import grips, slip
from .swings import declared
from .task_times import inner_tasks, task_at

HARDER = (
    "hold it harder ('parameters: {force_n: NEWTONS}' of the task that grasps it), or give pads or thing more friction "
    "('physics: {pad_friction}', 'with: {friction}')"
)
SLIP = 0.012  # a held thing may settle this far between the pads [m]: half the pad width of a 2F-85


class Execution(Value):
    """Check that the text ran to its end."""

    name: str = "execution"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        running = np.flatnonzero(rollout.lines)
        last = int(running[-1]) if len(running) else 0
        if rollout.outcome == "finished":
            yield Finding(
                self.name, True, f"the program ran to its end in {rollout.times[last]:.1f} s", float(rollout.times[last]), None, "s"
            )
        else:
            line = int(rollout.lines[last])
            reason = f"{rollout.outcome} at line {line}, {rollout.times[last]:.1f} s: {rollout.reason}"
            empty = closed_on_nothing(candidate, last)
            said = f"{reason}; {empty}" if empty else reason
            yield Finding(self.name, False, said, origin=task_at(candidate, last), stopped=True)


class ForcePeak(Value):
    """Check that the force that the program feels, without the weight of its payload, stayed under the
    limit of each task."""

    name: str = "force_peak"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        if not (rollout.lines > 0).any():
            return
        force, limits = force_while_running(rollout), force_limits(candidate)
        k = int(np.argmax(force / limits.most))
        limit = float(limits.most[k])
        reason = f"peak {force[k]:.1f} N at {rollout.times[k]:.1f} s, limit {limit:.4g} N {limits.source[k]}"
        yield Finding(self.name, bool(force[k] <= limit), reason, float(force[k]), limit, "N", limits.tasks[k])


class CommandedForce(Value):
    """Check that no task commanded the arm to press or pull harder than the task's own limit, whether or
    not anything stood against it."""

    name: str = "commanded_force"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout, program = candidate.ran, candidate.program
        if rollout.commanded is None or not rollout.commanded.any():
            return
        tasks, own = inner_tasks(candidate), task_forces(candidate)
        k = int(np.argmax(rollout.commanded / np.array([min(own[task].most, program.force_limit) for task in tasks])))
        force, allowed = float(rollout.commanded[k]), own[tasks[k]]
        limit, whose = min((allowed.most, allowed.source), (program.force_limit, program.force_limit_source))
        reason = f"told the arm to apply {force:.1f} N at {rollout.times[k]:.1f} s, limit {limit:g} N {whose}"
        yield Finding(self.name, force <= limit, reason, force, limit, "N", tasks[k])


class GraspSlip(Value):
    """Check that the payload did not move in the hand until its release, but for the turns that the program
    declares."""

    name: str = "grasp_slip"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        turns = declared(candidate)
        for grip in grips(rollout):
            moved = slip(rollout, grip, turns)
            k = grip.first + int(np.argmax(moved >= min(SLIP, moved.max())))  # what came loose then ends in the task that loosened it
            reason = f"'{grip.thing}' moved {1000 * moved.max():.1f} mm in the hand, limit {1000 * SLIP:.0f} mm"
            holds = bool(moved.max() <= SLIP)
            remedy = None if holds else Remedy(f"slip {grip.thing}", f"{reason}: {HARDER}", float(moved.max()))
            yield Finding(
                self.name, holds, reason, float(moved.max()), SLIP, "m", task_at(candidate, k), things=True, remedy=remedy
            )


@hookimpl
def validators() -> Iterable[Validator]:
    return [Execution(), Collision(), ForcePeak(), CommandedForce(), GraspSlip()]
