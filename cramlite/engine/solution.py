"""Solutions: programs whose text ran and was judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.geometry import Pose
from ..planning.trace import Trace

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..model.episode import Episode
    from ..model.plan import Plan
    from ..model.verdict import Verdict
    from ..plugin.protocols import Candidate
    from .setting import Setting



class Solution(Value):
    """Solution: a program whose text ran and was judged, with everything that led to it.

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
        """Plan that the program carries out."""
        return self.candidate.plan

    @property
    def program(self) -> Any:
        """Typed program."""
        return self.candidate.program

    @property
    def code(self) -> str:
        """Program text that was proven."""
        assert self.candidate.code is not None
        return self.candidate.code.text

    def setting_after(self) -> Setting:
        """Return the setting as this solution's run left it: things where they came to rest, the robot at its start again.

        Raises:
            UserError: something is still in the hand; only what was let go has a place of its own.
        """
        rollout, belief, before = self.candidate.rollout, self.candidate.belief, self.setting
        if belief.held is not None or rollout is None:
            what = f"'{belief.held.thing}' is still in the hand" if belief.held else "the program did not run here"
            raise UserError(f"Nothing can go on from where '{self.plan}' ends: {what}; let it end with the thing put down.")
        movable = {t.name for t in before.world.things if t.movable and t.joint is None}
        ends = {n: Pose(tuple(r[-1][:3]), tuple(r[-1][3:])) for n, r in rollout.poses.items() if n in movable}
        real = before.real.moved(ends) if before.real else None
        relations = tuple(sorted(belief.relations))
        return replace(before, world=before.world.moved(ends), relations=relations, real=real)
