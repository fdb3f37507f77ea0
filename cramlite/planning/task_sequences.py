"""Task sequences as plans, best first: those that a demonstration may have shown, and those that achieve a goal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from ..base.errors import UserError

if TYPE_CHECKING:
    from pathlib import Path

    from ..interpretation.fluents import SymbolicWorld
    from ..interpretation.interpretation import Interpretation, Interpreted
    from ..interpretation.matching import Match
    from ..interpretation.ranking import TaskSequence
    from ..interpretation.rules import Rule
    from ..interpretation.timeline import Timeline
    from ..model.episode import Episode
    from ..model.plan import Plan
    from ..plugin.catalogue import Knowledge
    from ..plugin.task_type import TaskType
    from ..scenario.scenario import ObjectSpec, Scenario
    from .symbolic.goal_planner import TaskPlan
    from .symbolic.planning_problem import PlanningProblem
    from .task_goals import Goal
    from .trace import Trace

LISTED = 1000
"""Largest number of task sequences that are generated for a demonstration. Most of them are only looked at to see that a task type is
missing."""


def plans_from_interpretation(
    name: str, found: Interpretation, episode: Episode, tasks: Mapping[str, TaskType], trace: Trace,
    reading: int | str | None = None,
) -> Iterator[tuple[Plan, TaskSequence]]:
    """Generate plans of the task sequences that a demonstration may have shown, best first.

    Those with a task type that nobody offers are refused. Where every reading contradicts itself, the trace says so.

    Args:
        reading: the one that is meant: its number among the sequences, from 1, or a task that it has; None for all.

    Raises:
        UserError: there is no such reading.
    """
    from ..interpretation.timeline import Timeline
    from .goal_literals import lasting_of
    from .plan import TaskCall, plan_from_episode

    listed, rules, timeline = 0, {r.task: r for r in found.rules}, Timeline(episode, found.taxonomy)
    explained = [a for a in found.actions if not a.unexplained]
    for listed, sequence in enumerate(_meant(found, reading), 1):  # noqa: B007  read behind the loop
        unknown = [m.task for m in sequence.matches if m.task not in tasks]
        if unknown:
            names = " -> ".join(m.task.split(":")[-1] for m in sequence.matches)
            why = f"no plugin offers the task type {unknown[0]}"
            trace.add(0, "sequence", names, "refused", "engine", why, kind="sequence")
            continue
        calls = [
            TaskCall(tasks[m.task], m.roles, _shown(tasks[m.task], m, rules.get(m.task), explained[k], timeline))
            for k, m in zip(sequence.actions, sequence.matches, strict=True)
        ]
        plan = plan_from_episode(name, calls, episode, found.taxonomy)
        yield replace(plan, lasting=tuple(lasting_of(sequence.matches, plan.actions, rules, timeline))), sequence
    if not listed:
        said = f"{found.count()} readings, none of them consistent; {len(found.unexplained_actions)} actions that no task explains"
        trace.add(0, "sequence", found.episode, "refused", "engine", said, kind="sequence")


def _meant(found: Interpretation, reading: int | str | None) -> Iterator[TaskSequence]:
    """Generate the readings of the demonstration that match the scenario's 'reading', a number or a task; all
    if it states none."""
    if reading is None:
        yield from islice(found.sequences(), LISTED)
        return
    listed = list(islice(found.sequences(), LISTED))
    number = int(reading) if str(reading).isdecimal() else 0
    task = "" if number else found.taxonomy.resolve(str(reading)) or str(reading)
    meant = listed[number - 1 : number] if number else [s for s in listed if any(m.task == task for m in s.matches)]
    if listed and not meant:
        known = sorted({m.task.split(":")[-1] for s in listed for m in s.matches})
        raise UserError(
            f"There is no reading '{reading}' of '{found.episode}': there are {len(listed)}, numbered from 1 as 'cramlite interpret' "
            f"lists them, with the tasks {', '.join(known)}."
        )
    yield from meant


def _shown(task: TaskType, match: Match, rule: Rule | None, action: Interpreted, timeline: Timeline) -> dict[str, float]:
    """Return those parameters of a task that the comparisons of its rule name, with the values that were measured in
    the demonstration."""
    from ..interpretation.matching import measured
    from ..interpretation.timeline import Segment

    names = {p.name for p in task.parameters}
    if rule is None or not names:
        return {}
    segment = Segment(action.start, action.end, action.segments[0].event if action.segments else None)
    return {k: v for k, v in measured(rule, match.roles, timeline.phases(segment)).items() if k in names}


def plans_for_goal(
    name: str,
    goal: Goal | Scenario,
    scene: SymbolicWorld,
    knowledge: Knowledge,
    trace: Trace,
    progress: Callable[[str], None] = lambda _: None,
) -> Iterator[Plan]:
    """Generate task sequences with which a planner achieves a goal; the trace records why each task is needed.

    Args:
        name: of the plans.
        scene: what holds at the start.
        progress: called with a line for people while the planner works.

    Raises:
        UserError: the goal is none, names what there is not, contradicts itself, or holds already.
    """
    from .symbolic.goal_planner import as_tasks
    from .symbolic.plan_file import handed_plan
    from .symbolic.plan_stream import task_plans
    from .task_goals import plan_from_tasks

    def plans_of(problem: PlanningProblem) -> Iterator[TaskPlan]:
        return iter([handed_plan(problem, asked.handed)]) if asked.handed else task_plans(problem, progress, trace=trace)

    asked, number = _asked(goal), 0
    problems = _problems(asked, scene, knowledge, trace)
    for turn in diagonally(_Turn(choice, problem, plans_of(problem)) for choice, problem in problems):
        trace.candidate = turn.number or trace.candidate  # it learns from the failure of its own last plan
        plan = next(turn.plans, None)
        if plan is not None:
            turn.number = number = number + 1
            _trace_plan(number, plan, turn.choice, turn.problem, trace)
            specs = as_tasks(plan, knowledge.tasks, turn.problem.wanted)
            yield replace(plan_from_tasks(name, specs, knowledge.tasks, scene.world), goal=turn.choice.says)
            continue
        turn.over = True
        if not turn.number:
            _trace_unreachable(turn.choice, turn.problem, trace, progress)


class _Turn:
    """Choice of things for a goal, with the plans for it.

    Args:
        choice: the goal about these things.
        problem: of planning it.
        plans: made one by one.
    """

    def __init__(self, choice: Goal, problem: PlanningProblem, plans: Iterator[TaskPlan]) -> None:
        self.choice, self.problem, self.plans = choice, problem, plans
        self.number, self.over = 0, False
        """Number of the last plan for this choice of things, 0 before the first, and whether there are no more plans."""


def diagonally(choices: Iterable[_Turn]) -> Iterator[_Turn]:
    """Generate the choices of things in rounds, each round with one new choice at the end, until all choices are over.

    So better choices come more often, and none is left out until all before it are over.
    """
    further, begun = iter(choices), list[_Turn]()
    while True:
        new = next(further, None)
        begun = [*(t for t in begun if not t.over), *([new] if new is not None else [])]
        if not begun:
            return
        yield from begun


def examine_goal(goal: Goal | Scenario, scene: SymbolicWorld, knowledge: Knowledge) -> None:
    """Check whether a goal can be planned for, without planning.

    Args:
        scene: what holds at the start.

    Raises:
        UserError: the goal is none, names what there is not, contradicts itself, or holds already.
    """
    next(_problems(_asked(goal), scene, knowledge), None)


def _problems(
    asked: _Asked, scene: SymbolicWorld, knowledge: Knowledge, trace: Trace | None = None
) -> Iterator[tuple[Goal, PlanningProblem]]:
    """Generate a planning problem for each choice of things for the objects that a goal only describes, such as "any
    cup".

    It raises the same errors as ``examine_goal``.
    """
    from .goal_parser import contradiction
    from .operators import Grounder
    from .spoken_goals import spoken
    from .symbolic.goal_planner import ground_goal
    from .symbolic.planning_problem import problem_of

    refused, possible, grounder = "", False, Grounder(scene, knowledge.predicates)
    goal = spoken(asked.goal, scene, knowledge, asked.where, trace)
    for choice in ground_goal(goal, asked.objects, grounder):
        problem = problem_of(choice, grounder, knowledge, asked.where)
        if why := contradiction(choice.says, grounder, asked.at(choice)):
            refused = refused or why
            continue
        possible = True
        if problem.wanted.met(problem.facts):
            raise UserError(f"{asked.where}the goal '{choice}' holds already in this world, so there is nothing to do.")
        yield choice, problem
    if refused and not possible:
        raise UserError(refused)


class _Asked(NamedTuple):
    """Goal with what the scenario states for it: its objects, the file lines of its parts, and a plan file."""

    goal: Goal
    objects: Mapping[str, ObjectSpec] = MappingProxyType({})
    where: str = ""
    places: Sequence[str] = ()
    handed: Path | None = None

    def at(self, choice: Goal) -> Sequence[str]:
        """Return "file:line" of the scenario for each part of a grounded goal; parts made of one sentence
        share a line."""
        return self.places if len(self.places) == len(choice.says) else list(self.places[:1]) * len(choice.says)


def _asked(goal: Goal | Scenario) -> _Asked:
    from ..scenario.scenario import Scenario
    from .task_goals import Goal

    if not isinstance(goal, Scenario):
        return _Asked(goal)
    spec = goal.spec
    places = [goal.where("goal", k) for k in range(len(spec.goal or ()))]
    handed = goal.resolve_path(spec.plan) if spec.plan else None
    return _Asked(Goal(spec.goal or ()), spec.objects, f"{goal.where('goal')}: ", places, handed)


def _trace_unreachable(choice: Goal, problem: PlanningProblem, trace: Trace, progress: Callable[[str], None]) -> None:
    """Record why no tasks achieve a goal, and which of its parts could be achieved alone."""
    from .symbolic.unreachable import why_unreachable

    trace.add(0, "goal", str(choice), "refused", "engine", why_unreachable(problem), kind="goal")
    if len(choice.says) > 1:
        _trace_alone(problem, trace, progress)


def _trace_alone(problem: PlanningProblem, trace: Trace, progress: Callable[[str], None]) -> None:
    """Record for each part of a goal why it is not achieved, or which tasks would achieve it if the goal had
    no other parts."""
    from .goal_parts import PART
    from .symbolic.plan_stream import task_plans
    from .symbolic.unreachable import why_unreachable

    for says, wanted in problem.parts():
        part = problem.alone(says, wanted)
        if wanted.met(problem.facts):
            trace.add(0, PART, says, "asked", "engine", "holds at the start", kind="goal", numbers={"first": 0, "last": 0})
            continue
        plan = next(task_plans(part, progress, 1), None)
        names = " -> ".join(s.task.split(":")[-1] for s in plan.steps) if plan is not None else ""
        why = f"{names} would achieve this part of the goal alone, but not with the others" if plan is not None else why_unreachable(part)
        trace.add(0, PART, says, "refused", "engine", why, kind="goal")


def _trace_plan(number: int, plan: TaskPlan, choice: Goal, problem: PlanningProblem, trace: Trace) -> None:
    from .goal_parts import trace_parts

    trace.candidate = number
    for step, reason in zip(plan.steps, plan.reasons, strict=True):
        trace.add(0, "goal", str(step), "chosen", "engine", f"for '{choice}': {reason}", kind="goal")
    trace_parts(problem, plan, trace)
