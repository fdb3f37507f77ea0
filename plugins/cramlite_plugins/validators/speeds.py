"""Validators of the speeds that a run reached, of joints and tool: the limits are those that ``cramlite preflight`` shows."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import OVERSHOOT, Reached, Value, peaks_of, reached
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl


class JointSpeeds(Value):
    """Check that the arm stayed within its joint speeds while the text ran."""

    name: str = "joint_speeds"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rows = [row for row in _reached(candidate) if row.limit == "joint_speed"]
        if not rows:
            return
        worst = max(rows, key=lambda row: row.value / row.most)
        limit = worst.most / OVERSHOOT
        reason = f"{worst.of} reached {worst.value:.2f} rad/s, limit {limit:.2f} rad/s"
        yield Finding(self.name, worst.passed, reason, worst.value, limit, worst.unit)


class ToolSpeed(Value):
    """Check that the tool moved no faster than a controller lets it, however it was told to move."""

    name: str = "tool_speed"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        for row in _reached(candidate):
            if row.limit == "tool_speed":
                reason = f"the tool reached {row.value:.2f} m/s, limit {row.most:g} m/s ({row.source})"
                origin = candidate.code.task_of(row.line) if candidate.code is not None and row.line else ""
                yield Finding(self.name, row.passed, reason, row.value, row.most, row.unit, origin)


def _reached(candidate: Candidate) -> list[Reached]:
    """Largest speeds that the run reached, each with its limit; empty if nothing moved."""
    peaks = peaks_of(candidate.rollout) if candidate.rollout is not None else None
    program = candidate.program
    return [] if peaks is None else list(reached(peaks, candidate.robot, program.force_limit, program.force_limit_source))


@hookimpl
def validators() -> list[Validator]:
    return [JointSpeeds(), ToolSpeed()]
