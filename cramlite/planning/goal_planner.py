"""Goals that say what should hold, "coffee in basket": which tasks achieve it, found by what their rules need and change.

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
from ..plugin.task_type import TaskType
from ..scenario.scenario import ObjectSpec
from ..scenario.task_specs import TaskSpec, WhereSpec
from .operators import GRIPPER, Fact, Grounder, Operator, Pattern, contents, matches
from .task_goals import Goal

LONGEST = 10
"""Tasks of a sequence: goals of this kind take three to six."""

TRIED = 20000
"""States that are looked at: with ten things and pegs a four-task sequence takes some hundred."""

FORMS = "'THING on PLACE', 'THING in PLACE', 'THING off PLACE', 'VESSEL poured into VESSEL', 'THING held', 'THING open' or 'THING closed'"
"""What a goal may say; "on" a thing with a peg means that it hangs there."""

SIDES = {"near": "near", "left of": "left_of", "right of": "right_of", "in front of": "in_front_of", "behind": "behind"}
"""Where on or in the place, beside another thing: the words of a goal, and a task's ``where``."""

PLACED = "placed"
"""Fact of a goal with a side: (PLACED, place, thing), made by the task that chooses the spot."""

NEEDLESS = "no step asks for what it changes"

_GOAL = re.compile(
    r"(\w+) (?:hangs |stands |lies |is )?(on|in|off|poured into|held|open|closed)(?: (\w+)(?: ({}) (\w+))?)?".format(
        "|".join(SIDES)
    )
)


class Wanted(Value):
    """What must hold in the end, and what may not.

    Args:
        sides: fact that a thing was placed -> the ``where`` of the task that places it.
    """

    needs: frozenset[Fact]
    without: frozenset[Pattern]
    sides: Mapping[Fact, Mapping[str, str]] = field(default_factory=dict)

    def met(self, facts: frozenset[Fact]) -> bool:
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)


class TaskPlan(Value):
    """Operators that lead to a goal, each with why it is there."""

    steps: tuple[Operator, ...]
    reasons: tuple[str, ...]


def wanted(goals: Iterable[str], grounder: Grounder, where: str = "") -> Wanted:
    """The facts of goals such as "coffee on hook", "tin in basket near cup", "tea off hanger", "drawer open".

    Raises:
        UserError: a goal that is none of these, or names what there is not.
    """
    needs: set[Fact] = set()
    without: set[Pattern] = set()
    sides: dict[Fact, dict[str, str]] = {}
    for text in goals:
        said = _GOAL.fullmatch(text.strip())
        if said is None or (said[2] in ("held", "open", "closed")) != (said[3] is None):
            raise UserError(
                f"{where}'{text}' is no goal; say {FORMS}; a place may end in 'near', {_quoted(SIDES)} THING."
            )
        thing, word, place, side, other = said.groups()
        for name in filter(None, (thing, place, other)):
            if name not in grounder.things:
                raise UserError(f"{where}the goal '{text}' names '{name}'; {nearest(name, grounder.things)}.")
        more, no = _facts(thing, word, place or "", grounder, f"{where}the goal '{text}'")
        if side:
            if word not in ("on", "in") or grounder.things[place].feature("vrps:Peg"):
                why = f"'{side}' chooses a spot on a surface or in a container, and there is none here"
                raise UserError(f"{where}the goal '{text}': {why}.")
            if other in (thing, place):
                why = f"what it is '{side}' must be another thing than '{thing}' and '{place}'"
                raise UserError(f"{where}the goal '{text}': {why}.")
            fact = (PLACED, place, thing)
            more, sides[fact] = more | {fact}, {SIDES[side]: other}
        needs |= more
        without |= no
    return Wanted(frozenset(needs), frozenset(without), sides)


def _quoted(words: Iterable[str]) -> str:
    return ", ".join(f"'{w}'" for w in words if w != "near")


def _facts(thing: str, word: str, place: str, grounder: Grounder, what: str) -> tuple[set[Fact], set[Pattern]]:
    free: set[Pattern] = {("grasps", None, thing), ("touches", GRIPPER, thing)}
    if word == "held":
        return {("grasps", GRIPPER, thing)}, set()
    if word in ("open", "closed"):
        return {(f"joint_{word}", thing)}, {("touches", GRIPPER, thing)}
    if word == "poured into":
        if contents(thing) not in grounder.contents:
            raise UserError(f"{what}: '{thing}' holds nothing that could be poured.")
        lifted: set[Pattern] = {("supports", None, thing)}  # its rule does not ask for it, but nobody tilts what stands
        return {("contains", place, contents(thing))}, lifted
    if word == "in":
        return {("in_or_above", thing, place)}, free
    peg = grounder.things[place].feature("vrps:Peg")
    there: Fact = ("touches", thing, f"{place}/{peg.name}") if peg else ("supports", place, thing)
    return (set(), {there}) if word == "off" else ({there}, free)


def with_sides(goal: Wanted, operators: Iterable[Operator], tasks: Mapping[str, TaskType]) -> tuple[Operator, ...]:
    """Operators that also say where they put what the goal wants beside something: those whose tasks choose the spot."""
    return tuple(replace(o, adds=o.adds | _placed(o, goal)) if tasks[o.task].places else o for o in operators)


def _placed(operator: Operator, goal: Wanted) -> set[Fact]:
    made = {("supports", p, t) for _, p, t in goal.sides} | {("in_or_above", t, p) for _, p, t in goal.sides}
    pairs = {f[1:] if f[0] == "supports" else f[:0:-1] for f in operator.adds & made}
    return {f for f in goal.sides if f[1:] in pairs}


def task_plans(
    goal: Wanted, facts: frozenset[Fact], operators: Iterable[Operator], most: int = 6
) -> Iterator[TaskPlan]:
    """Sequences of tasks that achieve a goal, the shortest first, lazily.

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


def _relevant(goal: Wanted, operators: tuple[Operator, ...]) -> tuple[Operator, ...]:
    """Operators that change something which the goal, or a relevant operator, asks about."""
    asked = {p[0] for p in (*goal.needs, *goal.without)}
    while True:
        found = [o for o in operators if asked & {p[0] for p in (*o.adds, *o.removes)}]
        more = asked | {p[0] for o in found for p in (*o.needs, *o.without)}
        if more == asked:
            return tuple(found)
        asked = more


def _reasons(goal: Wanted, facts: frozenset[Fact], steps: tuple[Operator, ...]) -> Iterator[str]:
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


def impossible(goal: Wanted, operators: Iterable[Operator]) -> str:
    """Why no sequence was found: what no task brings about, or that none is short enough."""
    made = {f for o in operators for f in o.adds}
    missing = [_say(f) for f in sorted(goal.needs) if f not in made]
    if missing:
        return f"no task's rule makes {missing[0]} so with these things"
    return f"no sequence of at most {LONGEST} tasks achieves it"


def as_tasks(plan: TaskPlan, tasks: Mapping[str, TaskType], goal: Wanted | None = None) -> list[TaskSpec]:
    """The tasks of a plan as a scenario would list them; those that the goal wants beside something with their ``where``."""
    sides = goal.sides if goal else {}
    chosen = [
        next((WhereSpec.model_validate(sides[f]) for f in sorted(s.adds) if f in sides), None) for s in plan.steps
    ]
    return [
        TaskSpec(task=s.task, roles=_fillers(s, tasks[s.task]), where=where)
        for s, where in zip(plan.steps, chosen, strict=True)
    ]


def _fillers(step: Operator, task: TaskType) -> dict[str, str]:
    return {r: e for r, e in step.roles.items() if e != GRIPPER and task.role(r) is not None}


def meant(goal: Goal, objects: Mapping[str, ObjectSpec], grounder: Grounder) -> Iterator[Goal]:
    """The goal with described objects replaced by things of the world, one choice after another, best first."""
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
    fit = [n for n in grounder.things if all(grounder.has(n, f) for f in spec.features)]
    fit = [n for n in fit if all(grounder.taxonomy.affords(grounder.types[n], a) for a in spec.affords)]
    own = [n for n in fit if any(grounder.taxonomy.is_a(grounder.types[n], t) for t in spec.types)]
    return own + [n for n in fit if n not in own and (spec.features or spec.affords or not spec.types)]
