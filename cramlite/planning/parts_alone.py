"""Parts of a goal by themselves: where no task sequence achieves all of it, which of them could be achieved alone, and which not."""

from __future__ import annotations

from collections.abc import Callable

from .goal_parts import PART
from .plan_stream import task_plans
from .planning_problem import PlanningProblem, why_unreachable
from .trace import Trace


def trace_alone(problem: PlanningProblem, trace: Trace, progress: Callable[[str], None], stop: Callable[[], bool]) -> None:
    """Add to a trace why each part of a goal is not achieved.

    Args:
        problem: of the whole goal, for which there is no task sequence.
    """
    for says, wanted in problem.parts():
        if stop():
            return
        part = problem.alone(says, wanted)
        if wanted.met(problem.facts):
            trace.add(0, PART, says, "asked", "engine", "holds at the start", kind="goal", numbers={"first": 0, "last": 0})
            continue
        plan = next(task_plans(part, progress, stop, 1), None)
        names = " -> ".join(s.task.split(":")[-1] for s in plan.steps) if plan is not None else ""
        why = f"alone {names} would do, but not with the other parts" if plan is not None else why_unreachable(part)
        trace.add(0, PART, says, "refused", "engine", why, kind="goal")
