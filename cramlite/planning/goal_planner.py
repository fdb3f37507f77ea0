"""Goal planner: task sequences that achieve goals such as "coffee in basket", found over ground operators.

Breadth first over the facts that rules speak of (``operators``), so that the shortest sequences come first. This only
chooses tasks and fillers; grasps, places, paths and the proof are the search's, and a sequence that it refuses is
followed by the next.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from msgspec import field
from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..interpretation.fluents import EFFECTOR, Fact, GoalCondition, GoalPhrase, Pattern, matches
from ..plugin.task_type import TaskType
from ..scenario.scenario import ObjectSpec
from ..scenario.task_specs import TaskSpec, WhereSpec
from .operators import Grounder, Operator
from .task_goals import Goal

LONGEST = 10
"""Tasks of a sequence: goals of this kind take three to six."""

TRIED = 20000
"""States that are looked at: with ten things and pegs a four-task sequence takes some hundred."""

SIDES = {name.replace("_", " "): name for name in WhereSpec.sides()}
"""Where in the place a spot is chosen, beside another thing: words of a goal -> key of a task's ``where``."""

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

    def met(self, facts: frozenset[Fact]) -> bool:
        """Check whether facts satisfy the goal."""
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)


class TaskPlan(Value):
    """Sequence of operators that achieves a goal, each with why it is there."""

    steps: tuple[Operator, ...]
    reasons: tuple[str, ...]


class ParsedGoal(Value):
    """Parsed goal.

    Args:
        phrase: whose form it has.
        things: that it is about, in the order of the form.
        side, other: key of ``where`` and the thing beside which the spot is; "" for none.
    """

    phrase: GoalPhrase
    things: tuple[str, ...]
    side: str = ""
    other: str = ""


def parse_goals(goals: Iterable[str], grounder: Grounder, where: str = "") -> GoalFacts:
    """Parse goals such as "coffee on hook", "tin in basket near cup", "tea off hanger", "drawer open" into facts.

    Raises:
        UserError: a goal that is none of these, or names what there is not.
    """
    needs: set[Fact] = set()
    without: set[Pattern] = set()
    sides: dict[Fact, Spot] = {}
    for text in goals:
        said = _read(text, grounder.fluents.phrases, where)
        what = f"{where}the goal '{text}'"
        meaning = _meaning(said, grounder, what)
        if said.side:
            _check_side(said, meaning, what)
            sides[(PLACED, *said.things[::-1])] = Spot({said.side: said.other}, meaning.needs)
        needs |= meaning.needs
        without |= meaning.without
    return GoalFacts(frozenset(needs | set(sides)), frozenset(without), sides)


def _read(text: str, phrases: Iterable[GoalPhrase], where: str) -> ParsedGoal:
    """What a goal says, by the forms that predicates declare."""
    for phrase in phrases:
        found = re.fullmatch(_pattern(phrase), " ".join(text.split()))
        if found is not None:
            words, count = [g or "" for g in found.groups()], len(_places(phrase))
            side, other = words[count:] or ("", "")
            return ParsedGoal(phrase, tuple(words[:count]), SIDES.get(side, ""), other)
    forms = [f"'{p.form}'" for p in sorted(phrases, key=lambda p: -len(_places(p)))]
    said = f"say {', '.join(forms[:-1])} or {forms[-1]}" if forms[1:] else "no plugin declares a phrase for goals"
    sides = ", ".join(f"'{s}'" for s in SIDES)
    raise UserError(f"{where}'{text}' is no goal; {said}; a place may end in {sides} THING.")


def _places(phrase: GoalPhrase) -> list[str]:
    return [w for w in phrase.form.split() if w.isupper()]


def _pattern(phrase: GoalPhrase) -> str:
    """The form as an expression whose groups are its things, and, where it names a place, a side and the thing there."""
    first, *words = (r"(\w+)" if w.isupper() else re.escape(w) for w in phrase.form.split())
    verbs = f"(?:(?:{'|'.join(map(re.escape, phrase.verbs))}) )?" if phrase.verbs else ""
    beside = rf"(?: ({'|'.join(SIDES)}) (\w+))?" if len(_places(phrase)) > 1 else ""
    return f"{first} {verbs}{' '.join(words)}{beside}"


def _meaning(said: ParsedGoal, grounder: Grounder, what: str) -> GoalCondition:
    """What the phrase makes of things that there are."""
    for name in filter(None, (*said.things, said.other)):
        if name not in grounder.things:
            raise UserError(f"{what} names '{name}'; {nearest(name, grounder.things)}.")
    try:
        return said.phrase.meaning(grounder.scene, *said.things)
    except UserError as error:
        raise UserError(f"{what}: {error}") from error


def _check_side(said: ParsedGoal, meaning: GoalCondition, what: str) -> None:
    side = next(words for words, key in SIDES.items() if key == said.side)
    if not meaning.spot:
        raise UserError(f"{what}: '{side}' chooses a spot on a surface or in a container, and there is none here.")
    if said.other in said.things:
        own = " and ".join(f"'{t}'" for t in said.things)
        raise UserError(f"{what}: what it is '{side}' must be another thing than {own}.")


def with_sides(goal: GoalFacts, operators: Iterable[Operator], tasks: Mapping[str, TaskType]) -> tuple[Operator, ...]:
    """Return the operators, with the fact that a thing was placed beside another where their tasks choose the spot."""
    return tuple(replace(o, adds=o.adds | _placed(o, goal)) if tasks[o.task].places else o for o in operators)


def _placed(operator: Operator, goal: GoalFacts) -> set[Fact]:
    return {fact for fact, spot in goal.sides.items() if spot.makes & operator.adds}


def task_plans(
    goal: GoalFacts, facts: frozenset[Fact], operators: Iterable[Operator], most: int = 6
) -> Iterator[TaskPlan]:
    """Search task sequences that achieve a goal, breadth first and lazily, the shortest first.

    Args:
        most: of them. States are not visited twice in one sequence, and at most twice in all, so that sequences differ.
    """
    chosen = _relevant(goal, tuple(operators))
    queue: deque[tuple[frozenset[Fact], tuple[Operator, ...]]] = deque([(facts, ())])
    seen: dict[frozenset[Fact], int] = {facts: 1}
    looked, given = 0, list[tuple[Operator, ...]]()
    while queue and looked < TRIED and len(given) < most:
        state, steps = queue.popleft()
        looked += 1
        if steps and goal.met(state):
            reasons = tuple(_reasons(goal, facts, steps))
            if NEEDLESS not in reasons and not any(_within(earlier, steps) for earlier in given):
                given.append(steps)
                yield TaskPlan(steps, reasons)
            continue
        for operator in chosen if len(steps) < LONGEST else ():
            if operator.applies(state):
                after = operator.apply(state)
                if after != state and seen.get(after, 0) < 2:
                    seen[after] = seen.get(after, 0) + 1
                    queue.append((after, (*steps, operator)))


def _within(short: tuple[Operator, ...], long: tuple[Operator, ...]) -> bool:
    """Whether a sequence is another one with detours."""
    rest = iter(long)
    return all(any(step is other for other in rest) for step in short)


def _relevant(goal: GoalFacts, operators: tuple[Operator, ...]) -> tuple[Operator, ...]:
    """Operators that change something which the goal, or a relevant operator, asks about."""
    asked = {p[0] for p in (*goal.needs, *goal.without)}
    while True:
        found = [o for o in operators if asked & {p[0] for p in (*o.adds, *o.removes)}]
        more = asked | {p[0] for o in found for p in (*o.needs, *o.without)}
        if more == asked:
            return tuple(found)
        asked = more


def _reasons(goal: GoalFacts, facts: frozenset[Fact], steps: tuple[Operator, ...]) -> Iterator[str]:
    """Why each step is there: the first thing that it makes so and that a later one, or the goal, asks for."""
    for k, step in enumerate(steps):
        after = step.apply(facts)
        made, gone = sorted(after - facts), sorted(facts - after)
        later = [(str(s), s.needs, s.without) for s in steps[k + 1 :]] + [("the goal", goal.needs, goal.without)]
        said = NEEDLESS
        for who, needs, without in later:
            useful = [_say(f) for f in made if f in needs]
            useful += ["no longer " + _say(f) for f in gone if any(matches(f, p) for p in without)]
            if useful:
                said = f"{useful[0]}, as {who} needs"
                break
        yield said
        facts = after


def _say(fact: Fact) -> str:
    return f"{fact[0]}({', '.join(fact[1:])})"


def explain_unreachable(goal: GoalFacts, operators: Iterable[Operator]) -> str:
    """Return why no sequence was found: a fact that no task brings about, or that none is short enough."""
    made = {f for o in operators for f in o.adds}
    missing = [_say(f) for f in sorted(goal.needs) if f not in made]
    if missing:
        return f"no task's rule makes {missing[0]} so with these things"
    return f"no sequence of at most {LONGEST} tasks achieves it"


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
    """Generate the goal with described objects replaced by things of the world, the best choice first."""
    words = {w for g in goal.says for w in g.split()}
    names = [n for n in objects if n in words]
    for choice in product(*(_things(objects[n], grounder) for n in names)):
        swap = dict(zip(names, choice, strict=True))
        if len(set(choice)) == len(choice):
            yield Goal(tuple(" ".join(swap.get(w, w) for w in g.split()) for g in goal.says))


def _things(spec: ObjectSpec, grounder: Grounder) -> list[str]:
    """Things that an object may mean: those of its class first, then those that have what is asked for."""
    if spec.entity:
        return [spec.entity]
    fit = [n for n in grounder.things if all(grounder.scene.has(n, f) for f in spec.features)]
    taxonomy, types = grounder.scene.taxonomy, grounder.scene.types
    fit = [n for n in fit if all(taxonomy.affords(types[n], a) for a in spec.affords)]
    own = [n for n in fit if any(taxonomy.is_a(types[n], t) for t in spec.types)]
    return own + [n for n in fit if n not in own and (spec.features or spec.affords or not spec.types)]
