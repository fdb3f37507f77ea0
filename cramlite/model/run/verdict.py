"""Verdicts: findings of the validators about a program or its rollout."""

from __future__ import annotations

import math
import re
from typing import Literal

from ...base.value import Value, replace
from ..remedy import Remedy
from .twin_verdict import TwinVerdict

Cost = Literal["facts", "ik", "path", "rollout"]
"""Stage at which a validator is asked, cheapest first; "rollout" is after the program's text ran."""
COSTS: tuple[Cost, ...] = ("facts", "ik", "path", "rollout")
ADVICE = "advises only: "
"""Prefix of the reason of an advisory objection, which does not refuse the program."""


class Finding(Value):
    """Result of one validator's check.

    Args:
        validator: its name.
        passed: True where it has nothing against the program, or where its objection only advises; False where it objects.
        reason: a clause with numbers and units, whether passed or not.
        value, limit, unit: the measured number and what it was held against, where there is one.
        origin: the task or step that it is about.
        places: whether another place might have changed it; False where it follows from tasks, parameters and objects alone.
        things: whether it is about where things are, or how they lie in the hand: places that the arm was only led to, such as the
            height of a lift, are then varied after all others.
        blocking: of an objection: names of the things that were in the way, so that a task which changes one of them may help;
            () where it does not depend on other things, None where that is not known.
        advice: an objection of a validator that only advises (``JudgingLimits.advisory``).
        stopped: an objection that says what stopped the run: that other conditions do not hold then may follow from it.
        literal: of the goal, in words, that it is about; "" where it is about none.
        remedy: of an objection: what is missing and what to try; None where that is not known.
    """

    validator: str
    passed: bool
    reason: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    origin: str = ""
    places: bool = True
    things: bool = False
    blocking: tuple[str, ...] | None = None
    advice: bool = False
    stopped: bool = False
    literal: str = ""
    remedy: Remedy | None = None

    @property
    def task_number(self) -> float:
        """Number of the task that the finding is about, in the plan; inf where it names none."""
        numbered = re.match(r"\d+", self.origin)
        return int(numbered[0]) if numbered else math.inf

    def as_advice(self) -> Finding:
        """Return an objection as advice, which is reported, but does not refuse the program."""
        return self if self.passed else replace(self, passed=True, advice=True, reason=f"{ADVICE}{self.reason}")


class Verdict(Value):
    """Findings of all validators about one candidate.

    Args:
        findings: in the order in which validators were asked.
        left_out: names of shipped validators that were not asked, because their plugins are blocked.
        twins: how the program fared in twins; None where it ran in none. A finding says whether that was enough.
    """

    findings: tuple[Finding, ...]
    left_out: tuple[str, ...] = ()
    twins: TwinVerdict | None = None

    @property
    def passed(self) -> bool:
        """Whether something was checked and no validator objects; without any finding the program has not
        passed."""
        return bool(self.findings) and all(f.passed for f in self.findings)

    @property
    def objections(self) -> tuple[Finding, ...]:
        """Findings that did not pass: those that stopped the run first, then by the number of their task, then in the order of the
        validators, since what went wrong first may have caused the rest."""
        return tuple(sorted((f for f in self.findings if not f.passed), key=lambda f: (not f.stopped, f.task_number)))

    @property
    def advice(self) -> tuple[Finding, ...]:
        """Objections of advisory validators, which do not refuse the program."""
        return tuple(f for f in self.findings if f.advice)

    @property
    def reason(self) -> str:
        """Reasons of all validators' objections to the program, in one line."""
        return "; ".join(f"{f.validator}: {f.reason}" for f in self.objections) or "passed"

    @property
    def remedy(self) -> Remedy | None:
        """Remedy of the first objection, which may have caused the others; None where no remedy is known."""
        return self.objections[0].remedy if self.objections else None

    @property
    def measured(self) -> dict[str, float]:
        """Measured values and limits of the objections, by name, which ends with the unit: {"slip_m": 0.03, "slip_limit_m": 0.012}."""
        found: dict[str, float] = {}
        for f in self.objections:
            unit = re.sub(r"\W+", "_", f.unit)
            named = ((f.validator, f.value), (f"{f.validator}_limit", f.limit))
            found |= {"_".join(filter(None, (name, unit))): v for name, v in named if v is not None}
        return found

    @property
    def not_judged(self) -> str:
        """Words that name the validators that were not asked, because their plugins are blocked; "" if there are
        none."""
        return f"not judged, since blocked: {', '.join(self.left_out)}" if self.left_out else ""
