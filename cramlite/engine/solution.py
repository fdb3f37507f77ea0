"""A solution: a program whose text ran and was judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..base.value import Value
from ..planning.trace import Trace

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..model.episode import Episode
    from ..model.plan import Plan
    from ..model.verdict import Verdict
    from ..plugin.protocols import Candidate
    from .setting import Setting



class Solution(Value):
    """A program whose text ran and was judged, with everything that led to it.

    Args:
        number: which candidate task sequence it came from, from 1.
        candidate: plan, program, code, bindings and rollout.
        verdict: what the validators found.
        trace: every decision of the search so far.
        setting: where it was proven.
        interpretation, episode: what the plan came from; None when it did not come from a demonstration.
    """

    number: int
    candidate: Candidate
    verdict: Verdict
    trace: Trace
    setting: Setting
    interpretation: Interpretation | None = None
    episode: Episode | None = None

    @property
    def plan(self) -> Plan:
        return self.candidate.plan

    @property
    def program(self) -> Any:
        return self.candidate.program

    @property
    def code(self) -> str:
        """The text that was proven."""
        assert self.candidate.code is not None
        return self.candidate.code.text
