"""A verdict: what the validators found in a program or in its rollout."""

from __future__ import annotations

import re
from typing import Literal

from ..base.value import Value

Cost = Literal["facts", "ik", "path", "rollout"]
COSTS: tuple[Cost, ...] = ("facts", "ik", "path", "rollout")


class Finding(Value):
    """What one validator says.

    Args:
        validator: its name.
        passed: True where it has nothing against the program, False where it objects.
        reason: a clause with numbers and units, whether passed or not.
        value, limit, unit: the measured number and what it was held against, where there is one.
        origin: the task or step that it is about.
        places: whether another place might have changed it; False where it follows from tasks, parameters and objects alone.
    """

    validator: str
    passed: bool
    reason: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    origin: str = ""
    places: bool = True


class Verdict(Value):
    """All findings about one candidate.

    Args:
        left_out: names of shipped validators that were not asked, because their plugins are blocked.
    """

    findings: tuple[Finding, ...]
    left_out: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True when something was checked and nobody objects: no finding is no success."""
        return bool(self.findings) and all(f.passed for f in self.findings)

    @property
    def objections(self) -> tuple[Finding, ...]:
        return tuple(f for f in self.findings if not f.passed)

    @property
    def reason(self) -> str:
        """The objections in one line."""
        return "; ".join(f"{f.validator}: {f.reason}" for f in self.objections) or "passed"

    @property
    def measured(self) -> dict[str, float]:
        """What was measured where somebody objects, and the limits: {"slip_m": 0.03, "slip_limit_m": 0.012}."""
        found: dict[str, float] = {}
        for f in self.objections:
            unit = re.sub(r"\W+", "_", f.unit)
            named = ((f.validator, f.value), (f"{f.validator}_limit", f.limit))
            found |= {"_".join(filter(None, (name, unit))): v for name, v in named if v is not None}
        return found

    @property
    def not_judged(self) -> str:
        """What was left out, as a clause; empty if nothing was."""
        return f"not judged, since blocked: {', '.join(self.left_out)}" if self.left_out else ""
