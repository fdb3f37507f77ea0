"""Goals as facts, the plans that achieve them as tasks, and why each task of a plan is there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from msgspec import field
from msgspec.structs import replace

from ..base.value import Value
from ..interpretation.fluents import EFFECTOR, Fact, Pattern, matches
from ..plugin.task_type import TaskType
from ..scenario.scenario import ObjectSpec
from ..scenario.task_specs import TaskSpec, WhereSpec
from .action_schema import ActionSchema
from .goal_phrases import parse_goal
from .goal_quantifiers import without_quantifiers
from .operators import Grounder, Operator
from .task_goals import Goal

PLACED = "placed"
"""Fact of a goal with a side: (PLACED, place, thing), made by the task that chooses the spot."""

NEEDLESS = "no step asks for what it changes"


class Spot(Value):
    """Placement that a goal asks for beside another thing.

    Args:
        where: of the task that chooses it.
        makes: facts, one of which that task brings about.
    """

    where: Mapping[str, str]
    makes: frozenset[Fact]


class GoalFacts(Value):
    """Goal facts: what must hold in the end, and what may not.

    Args:
        sides: fact that a thing was placed -> the spot.
    """

    needs: frozenset[Fact]
    without: frozenset[Pattern]
    sides: Mapping[Fact, Spot] = field(default_factory=dict)

    def __str__(self) -> str:
        return "the goal"

    def barred_by(self, fact: Fact, _facts: frozenset[Fact]) -> bool:
        """Check whether a fact keeps the goal from being satisfied."""
        return any(matches(fact, p) for p in self.without)

    def met(self, facts: frozenset[Fact]) -> bool:
        """Check whether facts satisfy the goal."""
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)


class TaskPlan(Value):
    """Sequence of operators that achieves a goal, each with why it is there."""

    steps: tuple[Operator, ...]
    reasons: tuple[str, ...]


def parse_goals(goals: Iterable[str], grounder: Grounder, where: str = "") -> GoalFacts:
    """Parse goals such as "coffee on hook", "tin in basket near cup", "tea off hanger", "drawer open" into facts.

    Raises:
        UserError: a goal that is none of these, or names what there is not.
    """
    needs: set[Fact] = set()
    without: set[Pattern] = set()
    sides: dict[Fact, Spot] = {}
    for goal in (parse_goal(text, grounder, where) for text in goals):
        if goal.side:
            sides[(PLACED, *goal.things[::-1])] = Spot({goal.side: goal.other}, goal.meaning.needs)
        needs |= goal.meaning.needs
        without |= goal.meaning.without
    return GoalFacts(frozenset(needs | set(sides)), frozenset(without), sides)


def side_facts(goal: GoalFacts, schema: ActionSchema) -> frozenset[Fact]:
    """Return the facts, with terms, that a thing was placed beside another, for a task that chooses the spot."""
    found: set[Fact] = set()
    for placed, spot in goal.sides.items():
        for made in spot.makes:
            same = [f for f in schema.change.adds if f[0] == made[0]]
            found |= {(PLACED, *(f[made.index(e)] for e in placed[1:])) for f in same}
    return frozenset(found)


def with_sides(goal: GoalFacts, operator: Operator, tasks: Mapping[str, TaskType]) -> Operator:
    """Return an operator, with the fact that a thing was placed beside another where its task chooses the spot."""
    placed = {fact for fact, spot in goal.sides.items() if spot.makes & operator.adds}
    return replace(operator, adds=operator.adds | placed) if tasks[operator.task].places else operator


def reasons(goal: GoalFacts, facts: frozenset[Fact], steps: tuple[Operator, ...]) -> Iterator[str]:
    """Generate why each step is there: the first thing that it makes so and that a later one, or the goal, asks for."""
    for k, step in enumerate(steps):
        after = step.apply(facts)
        made, gone = sorted(after - facts), sorted(facts - after)
        said = NEEDLESS
        following: tuple[Operator | GoalFacts, ...] = (*steps[k + 1 :], goal)
        for later in following:
            useful = [say(f) for f in made if f in later.needs]
            useful += ["no longer " + say(f) for f in gone if later.barred_by(f, facts)]
            if useful:
                said = f"{useful[0]}, as {later} needs"
                break
        yield said
        facts = after


def say(fact: Fact) -> str:
    """Format a fact as rules write it."""
    return f"{fact[0]}({', '.join(fact[1:])})"


def as_tasks(plan: TaskPlan, tasks: Mapping[str, TaskType], goal: GoalFacts | None = None) -> list[TaskSpec]:
    """Return the tasks of a plan as a scenario lists them, with ``where`` for placements beside other things."""
    sides = goal.sides if goal else {}
    chosen = [
        next((WhereSpec.model_validate(sides[f].where) for f in sorted(s.adds) if f in sides), None) for s in plan.steps
    ]
    return [
        TaskSpec(task=s.task, roles=_fillers(s, tasks[s.task]), where=where)
        for s, where in zip(plan.steps, chosen, strict=True)
    ]


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
    """Things that an object may mean: those of its class first, then those that have what is asked for."""
    if spec.entity:
        return [spec.entity]
    fit = [n for n in grounder.things if all(grounder.scene.has(n, f) for f in spec.features)]
    taxonomy, types = grounder.scene.taxonomy, grounder.scene.types
    fit = [n for n in fit if all(taxonomy.affords(types[n], a) for a in spec.affords)]
    own = [n for n in fit if any(taxonomy.is_a(types[n], t) for t in spec.types)]
    return own + [n for n in fit if n not in own and (spec.features or spec.affords or not spec.types)]
