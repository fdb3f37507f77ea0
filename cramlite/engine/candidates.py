"""Candidate task sequences, and complete programs for each with its verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from msgspec import field
from msgspec.structs import replace

from ..base.pulse import Stop, working
from ..base.value import Value
from ..model.designator_name import task_of
from ..planning.heartbeat import Heartbeat
from ..planning.refutation import refutation
from ..planning.search.answers import Answers
from ..planning.search.budget import Budget
from ..planning.search.search import WORK_SPENT, Effort, Search, WholeWork
from .late_poses import parametric
from .proof.executor_group import group_of
from .proof.program_time import about
from .proof.proof import assemble, conflict_of, prove
from .proof.twin_proof import doubt
from .search_in_setting import search_in
from .solution import Solution

if TYPE_CHECKING:
    from ..interpretation.matching import Match
    from ..interpretation.ranking import TaskSequence
    from ..model.plan import Plan
    from ..model.run.verdict import Verdict
    from ..planning.search.state import State
    from ..planning.trace import Trace
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from .proof.executor_group import ExecutorGroup
    from .reading import Reading
    from .setting import Setting

Progress = Callable[[str], None]


class CandidateSequence(Value, eq=False):
    """Candidate task sequence for a goal, as ``Engine.candidates`` gives it.

    Args:
        number: its rank, from 1.
        plan: the sequence, generalised.
        sequence: what the demonstration was read as; None where there is none.
        reading, setting, knowledge, budget: of the goal: what it says, where, who knows what, and how much work.
        trace, progress, stop: as ``Engine.resolve`` has them.
        answers: of plugins, from all sequences of the goal.
        effort: that was spent on this sequence; a wider round of it begins with what the one before was left with.
        group: the engine's processes that run programs in twins; None for others, made when they are needed.
    """

    number: int
    plan: Plan
    sequence: TaskSequence | None
    reading: Reading
    setting: Setting
    knowledge: Knowledge
    budget: Budget
    trace: Trace
    progress: Progress
    stop: Stop
    answers: Answers = field(default_factory=Answers)
    effort: Effort = field(default_factory=Effort)
    group: ExecutorGroup | None = None

    def attempts(self, group: ExecutorGroup | None = None) -> Iterator[Solution]:
        """Generate the complete programs of this task sequence, lazily: proven and refused ones, each with
        its verdict.

        Args:
            group: runs them in twins; None for the engine's own processes.
        """
        beat = Heartbeat(self.trace, self.progress, self.stop, len(self.plan.actions))
        yield from beat.over(self._attempts(group))

    def _attempts(self, group: ExecutorGroup | None) -> Iterator[Solution]:
        self.trace.candidate = self.number
        wider = f", with {self.effort.breadth} times as many alternatives as in the first round" if self.effort.breadth > 1 else ""
        if wider:
            self.trace.widened(str(self.plan), self.effort.breadth)
        self.progress(f"candidate {self.number}: {self.plan}{wider}")
        search = search_in(
            self.setting, self.knowledge, self.budget, self.trace, self.progress, self.answers, self.effort
        )
        made = attempts(search, self.plan, self.setting, self.knowledge, group or self.group or group_of(self.knowledge))
        for candidate, verdict in made:
            yield Solution(
                self.number, candidate, verdict, self.trace, self.setting, self.reading.interpretation, self.reading.episode,
                knowledge=self.knowledge,
            )

    def wider(self) -> CandidateSequence | None:
        """Return this task sequence, to be searched again with more alternatives of each designator; None if
        no alternative was left out, or the budget is spent."""
        spent, most = self.effort, self.budget
        left = spent.proofs < most.proofs and spent.expanded < most.expansions and not spent.whole.spent
        return replace(self, effort=spent.widened()) if spent.capped and left else None

    @property
    def doubted(self) -> list[tuple[int, Match]]:
        """Demonstrated actions whose interpretation as a task was objected to in every program of this sequence, each with that task."""
        said = self.sequence
        return [(said.actions[k - 1], said.matches[k - 1]) for k in sorted(self.effort.objected or ())] if said else []

    @property
    def spent(self) -> dict[str, Any]:
        """Search work spent on this task sequence so far, from which ``resume`` can go on.

        It has counts, limits, and the tasks to which validators objected.
        """
        effort = self.effort
        counted = {"breadth": effort.breadth, "expanded": effort.expanded, "proofs": effort.proofs, "capped": int(effort.capped)}
        return counted | {"objected": sorted(effort.objected or ())}

    def resume(self, spent: Mapping[str, Any] | None) -> bool:
        """Restore the search work that an interrupted run recorded; return False if it was recorded at a smaller
        limit of alternatives per designator than the present limit."""
        if spent is None or spent["breadth"] < self.effort.breadth:
            return False
        self.effort.expanded, self.effort.proofs = spent["expanded"], spent["proofs"]
        self.effort.capped = bool(spent["capped"]) or spent["breadth"] > self.effort.breadth
        self.effort.objected = frozenset(spent.get("objected", ()))
        return True


def doubted_last(
    plans: Iterable[tuple[Plan, TaskSequence | None]], tried: Sequence[CandidateSequence], trace: Trace
) -> Iterator[tuple[Plan, TaskSequence | None]]:
    """Yield task sequences; one with a reading to which validators objected in an earlier sequence comes
    last.

    That is a demonstrated action read as a task to which validators objected in all programs of that sequence.

    Args:
        tried: is asked before each.
    """
    later: list[tuple[Plan, TaskSequence | None]] = []
    for plan, sequence in plans:
        doubted = [reading for one in tried for reading in one.doubted]
        readings = zip(sequence.actions, sequence.matches, strict=True) if sequence else ()
        again = next((match for action, match in readings if (action, match) in doubted), None)
        if again is None:
            yield plan, sequence
            continue
        later.append((plan, sequence))
        said = f"tried last: validators objected to {again.task} in every program of an earlier task sequence"
        trace.add(0, "sequence", str(plan), "nogood", "engine", said, kind="sequence")
    yield from later


def attempts(
    search: Search, plan: Plan, setting: Setting, knowledge: Knowledge, group: ExecutorGroup
) -> Iterator[tuple[Candidate, Verdict]]:
    """Generate the complete programs of a plan, lazily: proven and refused ones, each with its verdict.

    Args:
        group: runs them in twins; a stop or an error ends its processes.
    """
    try:
        yield from _attempts(search, plan, setting, knowledge, group)
    except GeneratorExit:
        raise
    except BaseException:
        group.stop()
        raise


def _attempts(
    search: Search, plan: Plan, setting: Setting, knowledge: Knowledge, group: ExecutorGroup
) -> Iterator[tuple[Candidate, Verdict]]:
    budget, trace, progress = search.budget, search.trace, search.progress
    states, conflict, unproven, proven = search.solve(setting.start(plan)), None, set[object](), False
    while search.effort.proofs < budget.proofs and not search.effort.whole.spent:
        try:
            with trace.watch("planning"):
                state = states.send(conflict)
        except StopIteration:
            if search.refuted is not None and not proven:
                trace.refuted(str(plan), refutation(search.refuted))
            return
        candidate = _candidate(plan, state, setting, knowledge)
        search.effort.prove()
        candidate, verdict = _judged(candidate, search, setting, knowledge, group)
        trace.add(
            0, "proof", str(plan), "proven" if verdict.passed else "failed", setting.backend.name, verdict.reason,
            kind="proof", numbers=verdict.measured, remedy=verdict.remedy,
        )  # fmt: skip
        if not verdict.passed:
            progress(f"program {search.effort.proofs} refused: {_told(verdict)}")
        yield candidate, verdict
        conflict = None if verdict.passed else conflict_of(verdict, state)
        unproven |= conflict or set()
        search.effort.judged(conflict or frozenset())
        proven |= verdict.passed
    if not proven:
        trace.refuted(str(plan), refutation(unproven))
    if search.effort.whole.spent:
        trace.spent("work", budget.work, WORK_SPENT)
        return
    reason = f"proofs = {budget.proofs}: so many programs were made, the budget of one task sequence"
    trace.spent("proofs", budget.proofs, reason)


def _judged(
    candidate: Candidate, search: Search, setting: Setting, knowledge: Knowledge, group: ExecutorGroup
) -> tuple[Candidate, Verdict]:
    """Prove a program: run it in the believed world and, if it passes there, in twins; return it with its verdict.

    The time of each goes to the trace.
    """
    trace, name = search.trace, f"program {search.effort.proofs}"
    if trace.first_program is None:
        trace.first_program = trace.seconds["planning"]
    if setting.doubts.twins:
        group.start(setting.doubts.twins)  # they load their plugins while the nominal run is under way
    length, began = about(candidate.program, setting.robot), time.monotonic()
    search.progress(f"{name}: {len(candidate.program.steps)} steps run for about {length:.0f} s")
    with trace.watch("proof"), working(f"{name} runs", length):
        candidate, verdict = prove(candidate, knowledge, setting.backend, setting.seed)
    if not setting.doubts.twins or not verdict.passed:
        return candidate, verdict
    before = group.seconds
    with trace.watch("twins"):
        doubted = doubt(candidate, verdict, setting, knowledge, group, search.progress, time.monotonic() - began)
    trace.watch.add("twins", group.seconds - before)
    _trace_twins(trace, doubted)
    return candidate, doubted


def _told(verdict: Verdict) -> str:
    """Return the reason of the first objection, with its task, and the number of the others."""
    first, *others = verdict.objections
    where = f" in {task}" if (task := task_of(first.origin)) and task not in first.reason else ""
    more = f" (and {len(others)} more)" if others else ""
    return f"{first.reason}{where}{more} [{first.validator}]"


def _trace_twins(trace: Trace, verdict: Verdict) -> None:
    """Add a trace entry for each run in a twin: why it failed, or the largest error that it survived."""
    for twin in verdict.twins.twins if verdict.twins else ():
        said = twin.text if not twin.succeeded else f"succeeded ({twin.largest()})"
        trace.add(0, f"twin {twin.number}", "", "survived" if twin.succeeded else "failed", "engine", said, kind="twin")


def _candidate(plan: Plan, state: State, setting: Setting, knowledge: Knowledge) -> Candidate:
    """Assemble a program from a search state in which all designators are grounded.

    The plugins' hook ``on_step`` is called for each of its steps.
    """
    candidate = assemble(plan, state, setting, knowledge)
    candidate = parametric(candidate, setting.late)
    for step in candidate.program.steps:
        knowledge.registry.notify("on_step", candidate.program.name, step=step, candidate=candidate)
    return candidate


def to_try(
    plans: Iterable[tuple[Plan, TaskSequence | None]], most: int, trace: Trace, whole: WholeWork
) -> Iterator[tuple[int, Plan, TaskSequence | None]]:
    """Yield plans, numbered from 1, until the budget of task sequences or of work is spent; the trace records the former."""
    given, number = iter(plans), 0
    while not whole.spent and (found := next(given, None)) is not None:
        number += 1
        if number > most:
            trace.spent("sequences", most, f"{most} task sequences were tried, the rest left out")
            return
        trace.candidate = number
        yield number, *found
