"""Static safety check: limits that hold for all programs, checked before a text is written."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import Value
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

ANYWHERE = ("forces", "payload")
"""Safety rules whose numbers follow from a task's parameters and objects, and not from the place where the task is carried out."""


class ProgramSafety(Value):
    """Check the limits, workspace, forces, payload, time-outs and end of every step of a program, by
    ``cramlite.model.violations``."""

    name: str = "program_safety"
    cost: Cost = "facts"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        from cramlite.model import PROGRAM_RULES, STEP_RULES, violations

        found = list(violations(candidate.program, candidate.robot))
        for o in found:
            yield Finding(self.name, False, f"{o.rule}: {o.reason}", origin=o.origin, places=o.rule not in ANYWHERE)
        if not found:
            rules = len({*PROGRAM_RULES, *STEP_RULES})
            yield Finding(self.name, True, f"{len(candidate.program.steps)} steps keep {rules} safety rules")


@hookimpl
def validators() -> list[Validator]:
    return [ProgramSafety()]
