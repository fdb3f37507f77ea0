"""Goals as facts, the plans that achieve them as tasks, and why each task of a plan is there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ...interpretation.fluents import EFFECTOR, Fact, Pattern, matches
from ...interpretation.goal_sides import is_on_side
from ...model.entity_name import thing_of
from ...model.world.thing import Thing
from ...plugin.task_type import TaskType
from ...scenario.scenario import ObjectSpec
from ...scenario.task_specs import TaskSpec, WhereSpec
from ..goal_parser import parse_goal
from ..goal_quantifiers import without_quantifiers
from ..operators import Grounder, Operator
from ..task_goals import Goal
from .action_schema import ActionSchema, Table

PLACED = "placed"
"""Predicate of the fact that a goal with a side adds: (PLACED, place, thing). The task that chooses the place makes this fact. Of a goal
with a manner the fact is named by its words: ("open by 120 mm", "drawer")."""

NEEDLESS = "no step asks for what it changes"


class TaskConstraint(Value):
    """Constraint of a goal on the task that achieves it, such as on which side of a thing the place must be,
    or a parameter's value.

    Args:
        where: what the place that it chooses must be like.
        parameters: that it must have.
        makes: facts, one of which that task brings about; none where it is any task that puts the thing down.
    """

    where: Mapping[str, str]
    parameters: Mapping[str, float]
    makes: frozenset[Fact]

    def suits(self, task: TaskType) -> bool:
        """Check whether a task can meet this constraint of a goal: it has the parameters, and chooses a place if one is constrained."""
        return set(self.parameters) <= {p.name for p in task.parameters} and (task.places or not self.where)


class GoalFacts(Value):
    """Goal as facts: those that must hold in the end, and patterns of facts that must not.

    Args:
        constraints: fact that something was brought about as it was asked for -> what that asks of the task.
        given: those of these facts that hold at the start.
        beside: those of them whose thing is on the side that is asked for at the start, where nobody put it there for the goal: this
            suffices at the end of a run, and is none before one, which shall put it there.
    """

    needs: frozenset[Fact]
    without: frozenset[Pattern]
    constraints: Mapping[Fact, TaskConstraint] = field(default_factory=dict)
    given: frozenset[Fact] = frozenset()
    beside: frozenset[Fact] = frozenset()

    def __str__(self) -> str:
        return "the goal"

    def barred_by(self, fact: Fact, _facts: frozenset[Fact]) -> bool:
        """Check whether a fact keeps the goal from being satisfied."""
        return any(matches(fact, p) for p in self.without)

    def met(self, facts: frozenset[Fact]) -> bool:
        """Check whether facts satisfy the goal."""
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)


class TaskPlan(Value):
    """Sequence of planning actions that achieves a goal, with the reason for each."""

    steps: tuple[Operator, ...]
    reasons: tuple[str, ...]


def parse_goals(goals: Iterable[str], grounder: Grounder, where: str = "") -> GoalFacts:
    """Parse goals such as "coffee on hook", "tin in basket near cup", "tea off hanger", "drawer open" into facts.

    Raises:
        UserError: a goal that is none of these, or names what there is not.
    """
    needs: set[Fact] = set()
    without: set[Pattern] = set()
    asked: dict[Fact, TaskConstraint] = {}
    given, beside = set[Fact](), set[Fact]()
    for goal in (parse_goal(text, grounder, where) for text in goals):
        if goal.side:
            fact = (PLACED, *goal.things[::-1])
            asked[fact] = TaskConstraint({goal.side: goal.other}, {}, goal.meaning.needs)
            there = goal.meaning.needs <= grounder.initial and is_on_side(grounder.scene.world, goal.side, goal.things[0], goal.other)
            beside |= {fact} if there else set()
        if manner := goal.meaning.manner:
            fact = (goal.text.partition(" ")[2], goal.things[0])
            asked[fact] = TaskConstraint(manner.where, manner.parameters, goal.meaning.needs)
            given |= {fact} if manner.holds else set()
        needs |= goal.meaning.needs
        without |= goal.meaning.without
    return GoalFacts(frozenset(needs | set(asked)), frozenset(without), asked, frozenset(given), frozenset(beside))


def constraint_facts(goal: GoalFacts, schema: ActionSchema, task: TaskType) -> frozenset[Fact]:
    """Return the facts that an action adds when its task meets the goal's constraints, such as a side of a place.

    They are written with the parameters of the action's schema.
    """
    found: set[Fact] = set()
    for fact, asked in goal.constraints.items():
        if asked.suits(task):
            found |= {(fact[0], held) for held in schema.in_hand if not asked.makes}
            for made in asked.makes:
                same = [f for f in schema.change.adds if f[0] == made[0]]
                found |= {(fact[0], *(f[made.index(e)] for e in fact[1:])) for f in same}
    return frozenset(found)


def taken_places(goal: GoalFacts, schema: ActionSchema, things: Mapping[str, Thing], aside: Iterable[str]) -> Iterator[Table]:
    """Generate conditions that keep a task from putting things onto a loose thing on which the goal wants
    another thing.

    There is no room for both. Each condition is a table of forbidden pairs.
    """
    loose = {n for n, t in things.items() if t.movable}
    for fact in sorted(f for f in schema.change.adds - schema.change.needs if len(f) > 2):
        wanted = {f for f in goal.needs if f[0] == fact[0]}
        held, places = ([k for k, t in enumerate(fact) if k and (t in schema.in_hand) is own] for own in (True, False))
        for h, p in product(held, places):
            taken = {f[p] for f in wanted if thing_of(f[p]) in loose}
            if rows := set(product(aside, taken)) - {(f[h], f[p]) for f in wanted}:
                yield Table(f"another's place {fact[0]} {h} {p}", (fact[h], fact[p]), frozenset(rows), denied=True)


def constrained(goal: GoalFacts, operator: Operator, task: TaskType, held: frozenset[str]) -> Operator:
    """Return a planning action whose effects also include those constraints of the goal that its task fulfils.

    Args:
        held: things that are in the hand at some time.
    """
    made = {f for f, c in goal.constraints.items() if c.suits(task) and (c.makes & operator.adds if c.makes else f[1] in held)}
    return replace(operator, adds=operator.adds | made) if made else operator


def reasons(goal: GoalFacts, facts: frozenset[Fact], steps: tuple[Operator, ...]) -> Iterator[str]:
    """Generate the reason for each step of a plan: the first fact that it makes and that a later step, or the
    goal, needs."""
    for k, step in enumerate(steps):
        after = step.apply(facts)
        made, gone = sorted(after - facts), sorted(facts - after)
        said = NEEDLESS
        for later in _following(goal, steps, k):
            useful = [say(f) for f in made if f in later.needs]
            useful += ["no longer " + say(f) for f in gone if later.barred_by(f, facts)]
            if useful:
                said = f"{useful[0]}, as {later} needs"
                break
        yield said
        facts = after


def surplus(goal: GoalFacts, facts: frozenset[Fact], steps: tuple[Operator, ...]) -> frozenset[tuple[bool, Fact]]:
    """Return the facts that steps make (True) or end (False), and that neither a later step nor the goal
    needs.

    What follows from a change that is asked for, as predicates declare it, is none of them.
    """
    found: set[tuple[bool, Fact]] = set()
    for k, step in enumerate(steps):
        after, following = step.apply(facts), _following(goal, steps, k)
        made = frozenset(f for f in after - facts if any(f in later.needs for later in following))
        ended = {f for f in facts - after if any(later.barred_by(f, facts) for later in following)}
        held = {f[-1] for f in facts | after if step.fluents[f[0]].in_hand}
        made = step.fluents.implied(made, held)
        left = step.fluents.after(facts, made, ended)
        found |= {(True, f) for f in after - facts - made} | {(False, f) for f in (facts - after) & left}
        facts = after
    return frozenset(found)


def _following(goal: GoalFacts, steps: tuple[Operator, ...], k: int) -> tuple[Operator | GoalFacts, ...]:
    return (*steps[k + 1 :], goal)


def say(fact: Fact) -> str:
    """Format a fact as rules write it."""
    return f"{fact[0]}({', '.join(fact[1:])})"


def as_tasks(plan: TaskPlan, tasks: Mapping[str, TaskType], goal: GoalFacts | None = None) -> list[TaskSpec]:
    """Return the tasks of a plan in the form of a scenario's task list, with the goal's constraints on each:
    ``where`` and parameters."""
    return [_spec(step, tasks[step.task], goal.constraints if goal else {}) for step in plan.steps]


def _spec(step: Operator, task: TaskType, constraints: Mapping[Fact, TaskConstraint]) -> TaskSpec:
    asked = [constraints[f] for f in sorted(step.adds) if f in constraints]
    where = {k: v for c in asked for k, v in c.where.items()}
    return TaskSpec(
        task=step.task, roles=_fillers(step, task), parameters={k: v for c in asked for k, v in c.parameters.items()},
        where=WhereSpec.model_validate(where) if where else None,
    )  # fmt: skip


def _fillers(step: Operator, task: TaskType) -> dict[str, str]:
    return {r: e for r, e in step.roles.items() if e != EFFECTOR and task.role(r) is not None}


def ground_goal(goal: Goal, objects: Mapping[str, ObjectSpec], grounder: Grounder) -> Iterator[Goal]:
    """Generate the goal with described objects, and quantified classes, replaced by things of the world, the best choice first."""
    words = {w for g in goal.says for w in g.split()}
    names = [n for n in objects if n in words]
    for choice in product(*(_things(objects[n], grounder) for n in names)):
        swap = dict(zip(names, choice, strict=True))
        if len(set(choice)) == len(choice):
            says = [" ".join(swap.get(w, w) for w in g.split()) for g in goal.says]
            yield from map(Goal, without_quantifiers(says, grounder))


def _things(spec: ObjectSpec, grounder: Grounder) -> list[str]:
    """Return the things that fit a described object: those of its class first, then others with the needed
    features."""
    if spec.entity:
        return [spec.entity]
    fit = [n for n in grounder.things if all(grounder.scene.has(n, f) for f in spec.features)]
    taxonomy, types = grounder.scene.taxonomy, grounder.scene.types
    fit = [n for n in fit if all(taxonomy.affords(types[n], a) for a in spec.affords)]
    own = [n for n in fit if any(taxonomy.is_a(types[n], t) for t in spec.types)]
    return own + [n for n in fit if n not in own and (spec.features or spec.affords or not spec.types)]
