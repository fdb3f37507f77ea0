"""Symbolic planning problems: initial facts, goal facts and task rules; written as PDDL, and plans for them
checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, product
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.value import Value
from ...interpretation.conditions import atoms
from ...interpretation.fluents import EFFECTOR, Fact, SymbolicWorld, matching, pattern_text
from ...model.entity_name import thing_of
from ...model.world.thing_boxes import turns_in_place
from ..operators import Grounder, Operator, conditions_of, held_in
from ..refutation import WHOLE, Refutation
from .action_schema import ActionSchema, Table, action_schemas
from .blocking import Blocking, blocking_of
from .goal_planner import (
    GoalFacts,
    TaskPlan,
    as_tasks,
    constrained,
    constraint_facts,
    ground_goal,
    parse_goals,
    reasons,
    surplus,
    taken_places,
)
from .handling import Done, task_text
from .pddl import PddlText, PlanStep, write_pddl
from .schema_effects import may_push, pushed_terms, relevant_schemas

if TYPE_CHECKING:
    from ...plugin.catalogue import Knowledge
    from ...scenario.task_specs import TaskSpec
    from ..task_goals import Goal


ASIDE = 5
"""Cost factor of a task that pushes an obstacle without holding it, since the result of a push is less certain."""


class Scope(Value):
    """Limits of the plans of one call of the planner: which things they may use, and how they may move them.

    Args:
        things: by name.
        on_fixed: whether things are put only where the goal asks for them, or on what cannot be moved.
        carried: whether they are only put there by a hand that holds them, and not pushed.
        left_shut: whether nothing is opened because it was in the way of opening or shutting something else.
        others_moved: whether of what was in the way of a task what it is not about is moved, and not only that comes from elsewhere.
        added: whether tasks of plugins that are neither shipped nor preferred are among theirs.
    """

    things: frozenset[str]
    on_fixed: bool = False
    carried: bool = False
    left_shut: bool = False
    others_moved: bool = False
    added: bool = True


class PlanningProblem(Value, eq=False):
    """Symbolic planning problem (ADL: Pednault 1989).

    Args:
        says: the goal in words.
        facts: what holds at first, e.g. ``("on", "coffee", "hook")``.
        wanted: what must hold in the end, and what may not.
        grounder: of the whole world.
        knowledge: of the engine, which has the task types.
        blocked: tasks that geometry or physics refused while some things were as they then were.
    """

    says: tuple[str, ...]
    facts: frozenset[Fact]
    wanted: GoalFacts
    grounder: Grounder
    knowledge: Knowledge
    blocked: tuple[Blocking, ...] = ()

    @property
    def reached(self) -> bool:
        """Whether the goal holds at first, as at the end of a run that was to reach it."""
        return self.wanted.met(self.facts | self.wanted.beside)

    def scopes(self) -> Iterator[Scope]:
        """Generate scopes: the things, and the ways of moving them, that a plan may use. The narrowest scope
        comes first.

        First only things of the goal and obstacles, with their supports and payloads, are put where the goal
        says or on furniture. The next scopes also push them there, put them on anything, and use all things.
        At first a closed drawer that is an obstacle stays closed, since an open one takes more room; and
        obstacles are moved themselves, since a moved payload would meet them again.
        """
        names = {e for f in (*self.wanted.needs, *self.wanted.without) for e in f[1:] if e is not None}
        names |= {w for asked in self.wanted.constraints.values() for w in asked.where.values()}
        names |= {t.thing for b in self.blocked for t in b.tracks}
        names |= {self.grounder.scene.in_hand}  # what is held has to go somewhere
        known, every = {thing_of(e) for e in names} & self.grounder.things.keys(), frozenset(self.grounder.things)
        about = [{thing_of(e) for e in f[1:]} for f in self._asked_about(self.facts)]
        while True:
            moved = {n for n in known if self.grounder.things[n].movable}
            more = known | {n for found in about if found & moved for n in found & every}
            if more == known:
                break
            known = more
        least = Scope(frozenset(known), on_fixed=True, carried=True)
        others = (True, False) if any(b.while_others_stay() != b for b in self.blocked) else (False,)
        shut = (True, False) if any(b.shut for b in self.blocked) else (False,)
        yield from (replace(least, left_shut=s, others_moved=o) for o, s in product(others, shut))
        yield Scope(frozenset(known), on_fixed=True)
        yield Scope(frozenset(known))
        if known != every:
            yield Scope(every)

    def within(self, scope: Scope) -> PlanningProblem:
        """Return this problem with stricter blockings: only changes that ``scope`` permits make a refused task possible."""
        blocked = tuple(b.while_others_stay() for b in self.blocked) if scope.others_moved else self.blocked
        return replace(self, blocked=tuple(b.left_shut() for b in blocked) if scope.left_shut else blocked)

    def _asked_about(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """Return those of some facts whose predicates occur in the conditions of rules."""
        asked = {a.predicate.name for r in self.knowledge.goal_rules for _, c in conditions_of(r) for a in atoms(c)}
        return frozenset(f for f in facts if f[0] in asked)

    def pddl(
        self, scope: Scope | None = None, earlier: Sequence[Sequence[PlanStep]] = (), refused: Sequence[PlanStep] = ()
    ) -> PddlText:
        """Return the problem in PDDL.

        Args:
            scope: what plans may use; by default all things.
            earlier: plans of which none may be carried out whole again.
            refused: steps that no plan may have.
        """
        scope = scope or Scope(frozenset(self.grounder.things))
        grounder, here = self.grounder.among(scope.things), {EFFECTOR, *scope.things}
        tasks = self.knowledge.tasks
        schemas = [h for s in action_schemas(grounder, self.knowledge.goal_rules, tasks) for h in self._here(s, scope)]
        schemas = [s for s in schemas if s.in_hand or not (scope.carried and tasks[s.task].places)]
        schemas = [s for s in schemas if scope.added or s.task not in self.knowledge.added_tasks]
        facts = [f for f in self.facts if here.issuperset(map(thing_of, f[1:]))]
        entities = [*grounder.scene.entities, *grounder.contents]
        relevant = relevant_schemas(self.wanted, schemas, grounder.fluents, bool(self.blocked))
        return write_pddl(
            " and ".join(self.says), relevant, grounder.fluents, entities, facts,
            self.wanted.needs, self.wanted.without, earlier=earlier, refused=refused, blocked=self.blocked,
        )  # fmt: skip

    def _here(self, schema: ActionSchema, scope: Scope) -> Iterator[ActionSchema]:
        """Generate an action schema for only the things that a plan's scope allows; the goal's constraints
        become its effects.

        With obstacles also a schema without these effects: two things that change places need a third place.
        """
        change, task = schema.change, self.knowledge.tasks[schema.task]
        asked = constraint_facts(self.wanted, schema, task)
        cost = ASIDE * schema.cost if not asked and may_push(schema, self._in_the_way, self.grounder.fluents) else schema.cost
        taken = taken_places(self.wanted, schema, self.grounder.things, self._put_aside) if scope.on_fixed else ()
        tables = (*(self._allowed(schema, t, scope) for t in schema.tables), *taken)
        yield replace(schema, change=replace(change, adds=change.adds | asked), cost=cost, tables=tables)
        alone = [f for f in sorted(asked) if len(f) == 2 and f[1] in schema.in_hand] if self.blocked else []
        if alone and task.places:
            rows = frozenset((f[1],) for f in self.wanted.constraints if f[0] in {a[0] for a in alone})
            there = Table("asked to be at a place", (alone[0][1],), rows)
            apart = replace(change, removes=change.removes | asked)
            yield replace(schema, change=apart, cost=cost, tables=(*tables, there), elsewhere=True)

    @property
    def _in_the_way(self) -> frozenset[str]:
        """Things that are in the way of a task, according to the known blockings."""
        return frozenset(t.thing for b in self.blocked for t in b.tracks)

    @property
    def _put_aside(self) -> frozenset[str]:
        """Movable things that may have to be put aside: those that blockings name, and those that lie on
        other movable things."""
        fluents, things = self.grounder.fluents, self.grounder.things
        carried = (fluents.carries(f) for f in self.facts if fluents[f[0]].carrier is not None)
        on_loose = {upper for lower, upper in carried if lower in things and things[lower].movable}
        return frozenset(n for n in (self._in_the_way | on_loose) & things.keys() if things[n].movable)

    def _allowed(self, schema: ActionSchema, table: Table, scope: Scope) -> Table:
        """Return a table of things for a role, without movable supports if the scope allows only fixed ones, except
        where the goal asks to put something on them.

        A thing that the task merely acts on, such as the drawer that it opens, is no place.
        """
        new = [f for f in schema.change.adds - schema.change.needs if len(f) > 2]
        made = [(f[0], k) for f in new for k, t in enumerate(f) if (t,) == table.terms]
        if not scope.on_fixed or not made or table.terms[0] in schema.in_hand | pushed_terms(schema, self.grounder.fluents):
            return table
        wanted = {(f[0], k, e) for f in self.wanted.needs for k, e in enumerate(f)}
        fixed = {n for n, t in self.grounder.things.items() if not t.movable}
        rows = frozenset(r for r in table.rows if thing_of(r[0]) in fixed or any((*m, r[0]) in wanted for m in made))
        return replace(table, rows=rows)

    def parts(self) -> Iterator[tuple[str, GoalFacts]]:
        """Generate the parts of the goal, each as its sentence and as facts."""
        yield from ((says, parse_goals((says,), self.grounder)) for says in self.says)

    def alone(self, says: str, wanted: GoalFacts) -> PlanningProblem:
        """Return the problem of one part of the goal."""
        return replace(self, says=(says,), wanted=wanted)

    def operator(self, step: PlanStep) -> Operator | None:
        """Return the grounded planning action for a step of a plan; None if it is impossible with the things
        of the world."""
        task = self.knowledge.tasks[step.schema.task]
        fixed = {v: t for v, t in step.schema.terms.items() if t == EFFECTOR}
        found = self.grounder.operator(step.schema.rule, task, {**fixed, **step.binding})
        held = held_in(conditions_of(step.schema.rule), step.binding)
        whole = constrained(self.wanted, found, task, held) if found is not None else None
        if whole is None or found is None or not step.schema.elsewhere:
            return whole
        return replace(found, elsewhere=True, removes=found.removes | (whole.adds - found.adds))

    def failing(self, steps: Sequence[Operator]) -> str:
        """Explain why a sequence of grounded planning actions is no plan; "" if it is one."""
        return self._failing(steps, self._concerned(steps))

    def _concerned(self, steps: Iterable[Operator]) -> frozenset[Fact]:
        """Return the initial facts that steps or the goal can ask for, bring about or end: the others stay as they are."""
        patterns = [p for s in steps for p in (*s.needs, *s.without, *s.adds, *s.removes, *chain.from_iterable(s.never))]
        names = {p[0] for p in (*patterns, *self.wanted.needs, *self.wanted.without)}
        return self.grounder.fluents.about(self.facts, names)

    def _failing(self, steps: Sequence[Operator], facts: frozenset[Fact], before: Sequence[Operator] = ()) -> str:
        for number, step in enumerate(steps, 1):
            if unmet := step.unmet(facts):
                return f"'{step}', step {number} of the plan, needs {unmet}, which does not hold there"
            if bar := next((b for b in self.blocked if b.bars([*before, *steps[: number - 1]], step)), None):
                return f"'{step}', step {number} of the plan, was refused: {bar}"
            facts = step.apply(facts)
        missing = [pattern_text(f) for f in sorted(self.wanted.needs - facts)]
        if not missing and matching(facts, self.wanted.without):
            missing += ["not " + pattern_text(f) for p in self.wanted.without for f in sorted(matching(facts, [p]))]
        return f"the plan ends without {missing[0]}, which the goal asks for" if missing else ""

    def shortened(self, steps: Sequence[Operator]) -> tuple[Operator, ...]:
        """Return a plan without needless steps, removed singly or up to three in a row.

        This is greedy action elimination (Nakhost and Mueller 2010): what is left has the same order.
        """
        kept, left, facts = list[Operator](), list(steps), self._concerned(steps)
        while left:
            cut = (left[n:] for n in (1, 2, 3) if n <= len(left) and not self._missed(left[:n], left[n:], facts))
            shorter = next((rest for rest in cut if not self._failing(rest, facts, kept)), None)
            if shorter is None:
                facts = left[0].apply(facts)
                kept.append(left.pop(0))
            else:
                left = shorter
        return tuple(kept)

    def shut_first(self, steps: tuple[Operator, ...]) -> tuple[Operator, ...]:
        """Return the plan reordered so that it closes drawers and doors before it opens others, where the reordered plan still works.

        What is open takes room: before a cabinet the handle of an open drawer keeps the hand from closing the one below.
        """
        for k, step in enumerate(steps):
            if not self.knowledge.tasks[step.task].lays_open:
                continue
            opened = {f[0] for f in step.adds}
            shuts = [j for j in range(k + 1, len(steps)) if opened & {f[0] for f in steps[j].needs - steps[j].apply(steps[j].needs)}]
            swapped = ((*steps[:k], *steps[k + 1 : j + 1], step, *steps[j + 1 :]) for j in reversed(shuts))
            better = next((s for s in swapped if not self.failing(s)), None)
            if better is not None:
                return self.shut_first(better)
        return steps

    def _missed(self, without: Iterable[Operator], rest: Iterable[Operator], facts: frozenset[Fact]) -> bool:
        """Check whether a later step, or the goal, needs an effect of the removed steps, without applying all later steps."""
        lacking = {f for step in without for f in step.adds} - facts
        for step in rest:
            if lacking & step.needs:
                return True
            lacking -= step.adds
        return bool(lacking & self.wanted.needs)

    def plan(self, steps: Sequence[Operator]) -> TaskPlan:
        """Return grounded planning actions (``Operator``) as a plan, with the reason for each."""
        found = tuple(reasons(self.wanted, self._concerned(steps), tuple(steps)))
        return TaskPlan(tuple(steps), tuple(self._out_of_the_way(steps, k) or reason for k, reason in enumerate(found)))

    def surplus(self, steps: Sequence[Operator]) -> frozenset[tuple[bool, Fact]]:
        """Return the effects of a plan that neither its later steps nor the goal need."""
        return surplus(self.wanted, self.facts, tuple(steps))

    def _out_of_the_way(self, steps: Sequence[Operator], k: int) -> str:
        """Name the blocked task that a step makes possible, as a reason for the step; "" without one."""
        for later in range(k + 1, len(steps)):
            for b in self.blocked:
                if not b.bars(steps[:later], steps[later]) and b.bars([*steps[:k], *steps[k + 1 : later]], steps[later]):
                    return f"{task_text(b.task)} was refused without it"
        return ""

    def blocking(self, steps: Sequence[Operator], found: Refutation) -> Blocking | None:
        """Return the blocking that a failed task sequence proves: a task that is refused while certain things stay as they are.

        None if no task was refused, or this blocking is known.
        """
        facts = [self.facts]
        for step in steps:
            facts.append(step.apply(facts[-1]))
        loose = (n for n, t in self.grounder.things.items() if t.movable or t.joint is not None)
        same_room = frozenset(n for n, t in self.grounder.things.items() if turns_in_place(t))
        new = blocking_of(found, steps, [self._asked_about(f) for f in facts], frozenset(loose), same_room)
        if new is not None and found.tasks:
            new = replace(new, shut=self._shut(new, facts[found.tasks[-1] - 1]))
        return new if new not in self.blocked else None

    def _shut(self, blocking: Blocking, facts: frozenset[Fact]) -> frozenset[str]:
        """Return the closed drawers and doors that blocked the opening or closing of another drawer or door."""
        own = {thing_of(e) for _, e in blocking.task[1]}
        joints = {n for n, t in self.grounder.things.items() if t.joint is not None}
        tasks = self.knowledge.tasks
        schemas = action_schemas(self.grounder, self.knowledge.goal_rules, tasks)
        opened = {f[0] for s in schemas if tasks[s.task].lays_open for f in s.change.adds}
        wide = {thing_of(f[1]) for f in facts if f[0] in opened}
        return frozenset(t.thing for t in blocking.tracks if own & joints and t.thing in joints - own - wide)

    def blockings(self, steps: Sequence[Operator], found: Refutation) -> tuple[Blocking, ...]:
        """Return the new blockings that the failure of a task sequence proves: the refused task fails while
        things stay as they are.

        Of a task that was refused in one part of it alone, such as putting down, that part, too: it would be refused as a task of its own.
        """
        new = self.blocking(steps, found)
        part = self._part(found) if new is not None and not steps[found.tasks[-1] - 1].elsewhere else None
        return tuple(b for b in (new, part and new and replace(new, task=part)) if b is not None and b not in self.blocked)

    def _part(self, found: Refutation) -> Done | None:
        """Return the refused task, or the refused part of a task, with the things in its roles; None if no
        plan can contain it."""
        task, fillers = found.part or WHOLE
        rule = next((r for r in self.knowledge.goal_rules if r.task == task), None)
        roles = {} if rule is None else {r: dict(fillers).get(r, EFFECTOR) for r in rule.roles}
        known = all((r, e) in roles.items() for r, e in fillers)
        return (task, tuple(sorted(roles.items()))) if roles and known else None

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
    return problem_of(next(ground_goal(goal, {}, grounder)), grounder, knowledge)


def problem_of(goal: Goal, grounder: Grounder, knowledge: Knowledge, where: str = "") -> PlanningProblem:
    """Return the planning problem of a goal among the things of a world; error messages begin with ``where``."""
    wanted = parse_goals(goal.says, grounder, where)
    return PlanningProblem(goal.says, grounder.initial | wanted.given, wanted, grounder, knowledge)
