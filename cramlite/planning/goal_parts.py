"""Answers for each part of a goal: whether it is achieved, by which tasks, or why not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from itertools import accumulate
from typing import TYPE_CHECKING, Literal

from msgspec.structs import replace

from ..base.value import Value
from .diagnosis import nearest_miss, task_of
from .operators import Operator
from .trace import Entry, Trace

if TYPE_CHECKING:
    from ..interpretation.fluents import Fact
    from .symbolic.goal_planner import GoalFacts, TaskPlan
    from .symbolic.planning_problem import PlanningProblem

PART = "goal part"
"""Designator of the trace entries about a part of a goal."""

OTHER = "other_task_"
"""Prefix for the names of numbers in a trace entry that list tasks which serve other parts of the goal. These tasks are between the first
and the last task that serve the entry's own part."""

Answer = Literal["holds", "achieved", "reached", "missed", "untried"]
RANKS: Sequence[Answer] = ("holds", "achieved", "reached", "missed", "untried")
WORDS: Mapping[Answer, str] = {
    "holds": "holds at the start", "achieved": "is achieved", "reached": "was within reach", "missed": "is not achieved",
    "untried": "was not tried",
}  # fmt: skip


class GoalAnswer(Value):
    """Answer for one part of a goal: whether it holds or is achieved, by which tasks, or why not.

    Args:
        says: the part in words.
        answer: "holds" at the start, "achieved" by tasks of the proven program; and where nothing was proven: "reached" (its
            tasks were made a program, what failed came later), "missed" (one of its tasks failed) or "untried".
        tasks: the first and the last task that bring it about, from 1; None where there are none.
        reason: in words, why not, or what else there is to say.
    """

    says: str
    answer: Answer
    tasks: tuple[int, int] | None = None
    reason: str = ""

    def without_reason(self) -> GoalAnswer:
        """Return this answer with "see above" as its reason, since an earlier answer has the same reason."""
        return replace(self, reason="see above")

    def __str__(self) -> str:
        first, last = self.tasks or (0, 0)
        by = f" by task {last}" if first == last else f" by tasks {first} to {last}"
        text = WORDS[self.answer] + (by if self.tasks else "")
        return f"'{self.says}' {text}{f': {self.reason}' if self.reason else ''}"


def trace_parts(problem: PlanningProblem, plan: TaskPlan, trace: Trace) -> None:
    """Record in a trace which tasks of a plan bring about which part of its goal."""
    for says, wanted in problem.parts():
        tasks = serving(wanted, problem.facts, plan.steps)
        first, last = (tasks[0], tasks[-1]) if tasks else (0, 0)
        said = f"holds after task {last}, tasks {first} to {last} bring it about" if last else "holds at the start"
        others = {f"{OTHER}{k}": k for k in range(first, last) if k not in tasks}
        trace.add(0, PART, says, "asked", "engine", said, kind="goal", numbers={"first": first, "last": last, **others})


def serving(goal: GoalFacts, facts: frozenset[Fact], steps: Sequence[Operator]) -> tuple[int, ...]:
    """Return the numbers, from 1, of the steps that a goal needs, up to the step after which it holds for
    good; () if it holds at the start."""
    states = list(accumulate(steps, lambda state, step: step.apply(state), initial=facts))
    last = next((k for k in range(len(steps), 0, -1) if not goal.met(states[k - 1])), 0)
    found: list[int] = []
    later: list[GoalFacts | Operator] = [goal]
    for k in range(last, 0, -1):
        made, gone = states[k] - states[k - 1] - facts, (states[k - 1] - states[k]) & facts  # not what only is as it was again
        if k == last or any(made & one.needs or any(one.barred_by(f, states[k - 1]) for f in gone) for one in later):
            found, later = [k, *found], [*later, steps[k - 1]]
    return tuple(found)


def goal_answers(trace: Trace, proven: int = 0) -> tuple[GoalAnswer, ...]:
    """Return an answer for each part of a goal: in the order of the parts, or, if nothing was proven, nearest
    misses first.

    Args:
        trace: of the search; empty answers where it was not for a goal.
        proven: number of the candidate task sequence that was proven; 0 for none.
    """
    about = [e for e in trace.entries if e.kind == "goal"]
    parts = [e for e in about if e.designator == PART] or [e for e in about if e.outcome == "refused"]
    if proven:
        return tuple(_proven(e) for e in parts if e.candidate == proven and e.outcome == "asked")
    found = list(_unproven(parts, trace.entries))
    best = {e.text: min((a for a in found if a.says == e.text), key=_rank) for e in parts}
    return tuple(sorted(best.values(), key=_nearest))


def _rank(answer: GoalAnswer) -> int:
    return RANKS.index(answer.answer)


def _nearest(answer: GoalAnswer) -> tuple[bool, int]:
    """Return the sort key of an answer about a part of the goal: missed parts come first, and of these the one with the latest task."""
    return answer.answer != "missed", -answer.tasks[1] if answer.tasks and answer.answer == "missed" else 0


def _tasks(entry: Entry) -> tuple[int, int] | None:
    return (int(entry.numbers["first"]), int(entry.numbers["last"])) if entry.numbers.get("last") else None


def _proven(entry: Entry) -> GoalAnswer:
    tasks = _tasks(entry)
    return GoalAnswer(entry.text, "achieved" if tasks else "holds", tasks)


def _unproven(parts: Iterable[Entry], entries: Sequence[Entry]) -> Iterator[GoalAnswer]:
    """Yield what became of each part of the goal in each candidate that was tried, none of which was proven."""
    known = {e.number: e for e in entries}
    of = {c: [e for e in entries if e.candidate == c and e.kind != "goal"] for c in {e.candidate for e in parts}}
    misses = {c: nearest_miss(there) for c, there in of.items()}
    for part in parts:
        miss, tasks = misses[part.candidate], _tasks(part)
        if part.outcome == "refused":
            yield GoalAnswer(part.text, "missed", None, part.reason)
        elif tasks is None:
            yield GoalAnswer(part.text, "holds")
        elif miss is None:
            yield GoalAnswer(part.text, "untried", tasks)
        else:
            others = {int(k) for name, k in part.numbers.items() if name.startswith(OTHER)}
            yield _by(part.text, tasks, others, miss, known)


def _by(says: str, tasks: tuple[int, int], others: Set[int], miss: Entry, known: dict[int, Entry]) -> GoalAnswer:
    """Return what became of one part of the goal when a candidate failed: missed, reached or untried.

    It was missed if the nearest miss lies in the tasks of this part, and reached if a later task failed.
    """
    said = f"{miss.designator}: {miss.reason}"
    if miss.kind == "proof":
        own = [c for c in miss.reason.split("; ") if f"'{says}' is not reached" in c]
        elsewhere = not own and "is not reached" in miss.reason
        return GoalAnswer(says, "reached" if elsewhere else "missed", tasks, "; ".join(own) or ("" if elsewhere else said))
    at = _at(miss, known)
    if any(tasks[0] <= task <= tasks[1] and task not in others for task in at):
        return GoalAnswer(says, "missed", tasks, said)
    if at and min(at) > tasks[1] and task_of(miss, known):
        return GoalAnswer(says, "reached", tasks, f"a later task failed, task {at[0]}")
    return GoalAnswer(says, "untried", tasks)


def _at(miss: Entry, known: Mapping[int, Entry]) -> tuple[int, ...]:
    """Return the numbers of the plan's tasks that a refusal is about: the task in which it occurred, else the
    first and last that need an object."""
    if task := task_of(miss, known):
        return (task,)
    asked = known.get(miss.parent, miss).numbers
    return tuple(int(asked[name]) for name in ("first_task", "last_task") if name in asked)
