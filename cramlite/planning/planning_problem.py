"""Symbolic planning problems: what holds, what should hold, and the tasks that change it; as PDDL, and plans checked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.value import Value
from ..interpretation.fluents import EFFECTOR, Fact, SymbolicWorld, matches, said
from ..model.entity_name import thing_of
from .action_schema import ActionSchema, action_schemas
from .goal_planner import (
    PLACED,
    GoalFacts,
    TaskPlan,
    as_tasks,
    ground_goal,
    parse_goals,
    reasons,
    side_facts,
    with_sides,
)
from .operators import Grounder, Operator
from .pddl import PddlText, PlanStep, write_pddl

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge
    from ..scenario.task_specs import TaskSpec
    from .task_goals import Goal


class PlanningProblem(Value, eq=False):
    """A symbolic planning problem (ADL: Pednault 1989).

    Args:
        says: the goal in words.
        facts: what holds at first, e.g. ``("on", "coffee", "hook")``.
        wanted: what must hold in the end, and what may not.
        grounder: of the whole world.
        knowledge: of the engine, which has the task types.
    """

    says: tuple[str, ...]
    facts: frozenset[Fact]
    wanted: GoalFacts
    grounder: Grounder
    knowledge: Knowledge

    def things(self) -> Iterator[frozenset[str]]:
        """Generate the things that plans may use, fewest first: what the goal names with all that this stands on or carries, and
        all."""
        names = {e for f in (*self.wanted.needs, *self.wanted.without) for e in f[1:] if e is not None}
        names |= {w for spot in self.wanted.sides.values() for w in spot.where.values()}
        known = {thing_of(e) for e in names} & self.grounder.things.keys()
        while True:
            moved = {n for n in known if self.grounder.things[n].movable}
            about = [{thing_of(e) for e in f[1:]} for f in self.facts]
            more = known | {n for found in about if found & moved for n in found & self.grounder.things.keys()}
            if more == known:
                break
            known = more
        yield frozenset(known)
        if known != self.grounder.things.keys():
            yield frozenset(self.grounder.things)

    def pddl(
        self, things: frozenset[str], earlier: Sequence[Sequence[PlanStep]] = (), refused: Sequence[PlanStep] = ()
    ) -> PddlText:
        """Return the problem in PDDL.

        Args:
            things: that plans may use.
            earlier: plans of which none may be carried out whole again.
            refused: steps that no plan may have.
        """
        grounder, here = self.grounder.among(things), {EFFECTOR, *things}
        schemas = [
            replace(s, change=replace(s.change, adds=s.change.adds | side_facts(self.wanted, s)))
            if self.knowledge.tasks[s.task].places
            else s
            for s in action_schemas(grounder, self.knowledge.goal_rules, self.knowledge.tasks)
        ]
        facts = [f for f in self.facts if here.issuperset(map(thing_of, f[1:]))]
        entities = [*grounder.scene.entities, *grounder.contents]
        chosen = _relevant(self.wanted, schemas)
        return write_pddl(
            " and ".join(self.says), chosen, grounder.fluents, entities, facts, self.wanted.needs, self.wanted.without,
            earlier=earlier, refused=refused,
        )  # fmt: skip

    def operator(self, step: PlanStep) -> Operator | None:
        """Return the operator of a step in the whole world; None where it is none."""
        task = self.knowledge.tasks[step.schema.task]
        fixed = {v: t for v, t in step.schema.terms.items() if t == EFFECTOR}
        found = self.grounder.operator(step.schema.rule, task, {**fixed, **step.binding})
        return with_sides(self.wanted, found, self.knowledge.tasks) if found is not None else None

    def failing(self, steps: Sequence[Operator]) -> str:
        """Return why operators are no plan; "" where they are one."""
        facts = self.facts
        for number, step in enumerate(steps, 1):
            if unmet := step.unmet(facts):
                return f"'{step}', its step {number}, needs {unmet}, which does not hold there"
            facts = step.apply(facts)
        missing = [said(f) for f in sorted(self.wanted.needs - facts)]
        missing += ["not " + said(f) for p in self.wanted.without for f in sorted(facts) if matches(f, p)]
        return f"it ends without {missing[0]}, which the goal asks for" if missing else ""

    def shortened(self, steps: Sequence[Operator]) -> tuple[Operator, ...]:
        """Return a plan without the steps that it can do without (greedy action elimination: Nakhost and Mueller 2010)."""
        kept, k = list(steps), 0
        while k < len(kept):
            without = [*kept[:k], *kept[k + 1 :]]
            for length in (1, 2, 3):
                without = [*kept[:k], *kept[k + length :]]
                if not self.failing(without):
                    kept = without
                    break
            else:
                k += 1
        return tuple(kept)

    def plan(self, steps: Sequence[Operator]) -> TaskPlan:
        """Return operators as a plan, each with why it is there."""
        return TaskPlan(tuple(steps), tuple(reasons(self.wanted, self.facts, tuple(steps))))

    def tasks(self, steps: Sequence[Operator]) -> list[TaskSpec]:
        """Return the tasks of a plan as a scenario lists them, for ``Engine.resolve``."""
        return as_tasks(TaskPlan(tuple(steps), ()), self.knowledge.tasks, self.wanted)


def planning_problem(goal: Goal, scene: SymbolicWorld, knowledge: Knowledge) -> PlanningProblem:
    """Return the planning problem of a goal about things of a world.

    Args:
        scene: what is known before anything is done, e.g. ``Setting.symbolic``.
        knowledge: of the engine.

    Raises:
        UserError: the goal cannot be read, or names what there is not.
    """
    grounder = Grounder(scene, knowledge.predicates)
    (meaning,) = ground_goal(goal, {}, grounder)
    return problem_of(meaning, grounder, knowledge)


def problem_of(goal: Goal, grounder: Grounder, knowledge: Knowledge, where: str = "") -> PlanningProblem:
    """Return the planning problem of a goal in a world that is grounded; ``where`` stands before each message."""
    return PlanningProblem(goal.says, grounder.initial(), parse_goals(goal.says, grounder, where), grounder, knowledge)


def why_unreachable(problem: PlanningProblem) -> str:
    """Return why no sequence was found: a fact that no task brings about, or that no sequence leads there."""
    schemas = action_schemas(problem.grounder, problem.knowledge.goal_rules, problem.knowledge.tasks)
    made = [(s, f) for s in schemas for f in s.change.adds]
    missing = [f for f in sorted(problem.wanted.needs - problem.facts) if not any(_may_make(s, a, f) for s, a in made)]
    if missing and missing[0][0] != PLACED:
        return f"no task's rule makes {said(missing[0])} so with these things"
    return "no sequence of tasks leads from what holds to it, whatever the things"


def _may_make(schema: ActionSchema, added: Fact, fact: Fact) -> bool:
    """Whether a schema's effect can be a fact, by what may fill its parameters."""
    tables = {t.terms: t.rows for t in schema.tables if len(t.terms) == 1 and not t.denied}
    return added[0] == fact[0] and all(
        t == e or (t.startswith("?") and (e,) in tables.get((t,), {(e,)})) for t, e in zip(added[1:], fact[1:], strict=True)
    )


def _relevant(goal: GoalFacts, schemas: Sequence[ActionSchema]) -> list[ActionSchema]:
    """Schemas that change something which the goal, or a relevant schema, asks about."""
    asked = {p[0] for p in (*goal.needs, *goal.without)}
    while True:
        found = [s for s in schemas if asked & _changed(s)]
        more = asked | {n for s in found for n in _asked(s)}
        if more == asked:
            return found
        asked = more


def _changed(schema: ActionSchema) -> set[str]:
    change = schema.change
    return {str(p[0]) for p in (*change.adds, *change.removes, *(u.given for u in schema.after))}


def _asked(schema: ActionSchema) -> set[str]:
    change, pairs = schema.change, [f for pair in schema.change.never for f in pair]
    return {str(p[0]) for p in (*change.needs, *change.without, *pairs, *(u.given for u in schema.before))}
