"""Solutions: programs whose text was proven in the belief, and the outcome of their execution."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.geometry import Pose
from ..planning.trace import Trace
from ..plugin.exporting import require_installed, write_new
from .recorded_run import PICTURE, pictures_of, record_of, sample_at

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..model.episode import Episode
    from ..model.plan import Plan
    from ..model.run.rollout import Rollout
    from ..model.run.verdict import Finding, Verdict
    from ..model.world.world import World
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from .execution import Execution
    from .setting import Setting

WRITER = "cramlite.report"
"""Module whose ``write_one_page`` writes a report; in a layer above the engine, and imported only when a page is asked for."""


class Solution(Value):
    """Solution: a program whose text was run and judged in the believed world and in its twins,
    with its plan, verdict and trace.

    Args:
        number: which candidate task sequence it came from, from 1.
        candidate: plan, program, code, bindings and rollout.
        verdict: what the validators found; ``verdict.twins`` is how it fared in twins.
        trace: every decision of the search so far.
        setting: where it was proven.
        interpretation, episode: what the plan came from; None when it did not come from a demonstration.
        execution: in the world as it really is; None as long as it was not executed (``Engine.execute``).
        knowledge: what plugins know; it draws pictures. None for a solution that was put together by hand.
    """

    number: int
    candidate: Candidate
    verdict: Verdict
    trace: Trace
    setting: Setting
    interpretation: Interpretation | None = None
    episode: Episode | None = None
    execution: Execution | None = None
    knowledge: Knowledge | None = None

    @property
    def plan(self) -> Plan:
        """Plan that the program carries out."""
        return self.candidate.plan

    @property
    def program(self) -> Any:
        """Typed program."""
        return self.candidate.program

    @property
    def seconds(self) -> dict[str, float]:
        """CPU time of the whole search by stage [s]: "planning", "proof" (nominal run) and "twins"; see
        ``Trace.seconds``."""
        return self.trace.seconds

    @property
    def code(self) -> str:
        """Program text that was proven."""
        return self.candidate.written.text

    @property
    def succeeded(self) -> bool:
        """Whether the program was proven in the belief and, if it was executed in the real world, succeeded
        there."""
        return self.verdict.passed and (self.execution is None or self.execution.verdict.passed)

    @property
    def advice(self) -> tuple[Finding, ...]:
        """Objections of advisory validators, raised in the proof or in the first execution; they do not refuse the program."""
        return (*self.verdict.advice, *(self.execution.verdict.advice if self.execution else ()))

    @property
    def headline(self) -> str:
        """Outcome in a few words, for people: "Solved", or "Solved, with advice" after an objection that only
        advises."""
        if not self.succeeded:
            return "Proven in what is believed, but the first execution failed" if self.verdict.passed else "Refused"
        said = "Solved at the first execution" if self.execution else "Solved"
        return f"{said}, with advice" if self.advice else said

    def picture(self, at: float = 1.0, size: tuple[int, int] = PICTURE) -> Any:
        """Render the proven run at a share of its time: (height, width, 3) uint8.

        Args:
            at: 0 is the start, 1 the end.
            size: (width, height) [pixel].

        Raises:
            UserError: ``at`` is no such share, or nothing ran.
        """
        rollout, knowledge = self._drawn()
        try:
            return pictures_of(rollout, knowledge, size)(sample_at(rollout, at))
        except ValueError as error:
            raise UserError(f"{error}.") from error

    def animation(self, path: Path | str) -> Path:
        """Write the proven run as a moving picture, which must not exist yet; return its path.

        Args:
            path: its suffix, ".gif" or ".mp4", says the format.

        Raises:
            UserError: no format has that suffix, it needs what is not installed, or the file exists or cannot be written.
        """
        (rollout, knowledge), target = self._drawn(), Path(path)
        known = {e.suffix: e for e in knowledge.exporters.values() if e.suffix}
        if target.suffix not in known:
            raise UserError(f"'{target}' is of no known format; {nearest(target.suffix, known)}.")
        exporter = known[target.suffix]
        require_installed(exporter)
        write_new(exporter, record_of(rollout, knowledge, self.setting.name, self.program, self.candidate.code), target)
        return target

    def report(self, path: Path | str) -> Path:
        """Write the report, one HTML page that needs no other file; return its path.

        Raises:
            UserError: it cannot be written, or nobody can write it.
        """
        if self.knowledge is None:
            raise UserError(f"No engine gave the solution of '{self.plan}', so no plugin can write its report: use Engine.resolve.")
        page = Path(path)
        import_module(WRITER).write_one_page(self, self.knowledge, page)
        return page

    def _drawn(self) -> tuple[Rollout, Knowledge]:
        """Return the recorded run of a solution, and the plugin declarations with which it is drawn.

        Raises:
            UserError: there is no run, or nobody to draw it.
        """
        if self.knowledge is None or self.candidate.rollout is None:
            raise UserError(f"The solution of '{self.plan}' cannot be drawn: its program did not run here.")
        return self.candidate.rollout, self.knowledge

    def setting_after(self) -> Setting:
        """Return the setting after this solution's run: things where they came to rest, the robot at its start again.

        What is believed is left as the proof predicts it, the real world as the execution left it.

        Raises:
            UserError: something is still in the hand; only what was let go has a place of its own. Or there is a real world,
                and the program was not executed in it.
        """
        rollout, belief, before = self.candidate.rollout, self.candidate.belief, self.setting
        if belief.held is not None or rollout is None:
            what = f"'{belief.held.thing}' is still in the hand" if belief.held else "the program did not run here"
            raise UserError(f"No goal can be resolved after '{self.plan}': {what}; let the plan end with an empty hand.")
        relations, real = tuple(sorted(belief.relations)), before.real
        if real is not None:
            executed = self.execution.candidate.rollout if self.execution else None
            if executed is None:
                raise UserError(f"The real world after '{self.plan}' is unknown: run it with 'Engine.execute' first.")
            real = _left(real, executed)
        return replace(before, world=_left(before.world, rollout), relations=relations, real=real)


def _left(world: World, rollout: Rollout) -> World:
    """Return a world as a run left it: things where they came to rest."""
    movable = {t.name for t in world.things if not t.furniture}
    ends = {n: Pose.from_row(r[-1]) for n, r in rollout.poses.items() if n in movable}
    return world.moved(ends)
