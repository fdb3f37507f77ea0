"""Making of plans from interpreted task sequences, or from a scenario's tasks and rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import Any

from msgspec.structs import replace

from ..base.value import Value
from ..model.control_flow import Compound, Kind, compound, retry
from ..model.designator_name import part_name
from ..model.designators import Action, Designator, Location, Object
from ..model.episode import Entity, Episode
from ..model.plan import HOME, Plan
from ..ontology.taxonomy import Taxonomy
from ..plugin.task_type import TaskType


class TaskCall(Value):
    """Task with things in its roles: one step of an interpreted sequence or of a scenario."""

    task: TaskType
    roles: Mapping[str, str]
    parameters: Mapping[str, float] | None = None
    where: Mapping[str, Any] | None = None


class RuleCall(Value):
    """Call of a control structure of the plan language, such as a retry or a choice, over task calls.

    Args:
        rule: as the scenario has it; it becomes part of the compound's name.
        parameters: of the compound.
        changes: of a retry: the parameters of each further attempt.
    """

    rule: str
    kind: Kind
    branches: tuple[tuple[Call, ...], ...]
    parameters: Mapping[str, float]
    changes: tuple[Mapping[str, float], ...] = ()


Call = TaskCall | RuleCall


def task_calls(calls: Iterable[Call], *, alternatives: bool = True) -> Iterator[TaskCall]:
    """Yield the task calls in order, also those inside control structures.

    ``alternatives=False`` leaves out those inside a choice, since the search may choose others.
    """
    for call in calls:
        if isinstance(call, TaskCall):
            yield call
        elif alternatives or call.kind != "choose":
            for branch in call.branches:
                yield from task_calls(branch, alternatives=alternatives)


def plan_from_episode(name: str, calls: Sequence[TaskCall], episode: Episode, taxonomy: Taxonomy) -> Plan:
    """Generalise an interpreted task sequence into a plan.

    Entities become variables that keep their classes; what the tasks need of them (features,
    affordances) is added; poses, times, sizes and instance names stay behind. Of what has no class, its name may suggest one.
    """
    entities = {e.name: e for e in episode.entities}
    effectors = _effectors(episode)
    fillers = [f for c in calls for r, f in c.roles.items() if f not in effectors and f in entities]
    variables = _variables(fillers, entities)
    objects = {entity: _describe(variables, entities[entity], taxonomy) for entity in variables}
    return build_plan(name, calls, objects)


def build_plan(name: str, calls: Sequence[Call], objects: Mapping[str, Object]) -> Plan:
    """Build a plan from task calls, with a designator for each object that fills a role.

    Fillers that are no keys of ``objects``, such as the effector, are left out.
    """
    constrained = dict(objects)
    for call in task_calls(calls):
        for role, filler in call.roles.items():
            declared = call.task.role(role)
            if filler in constrained and declared is not None and not declared.effector:
                constrained[filler] = declared.constrain(constrained[filler])
    numbers, types = count(1), {c.task.task: c.task for c in task_calls(calls)}
    actions = [_action(call, constrained, numbers) for call in calls]
    always = {f for c in task_calls(calls, alternatives=False) for f in c.roles.values()}
    needed = {constrained[f].part_of for f in always if f in constrained} | always
    ordered = _in_order(o for filler, o in constrained.items() if filler in needed or o.name in needed)
    return Plan(name, ordered, _with_goals(actions, types, (HOME, None))[0])


def _in_order(objects: Iterable[Object]) -> tuple[Object, ...]:
    """Return the objects sorted so that wholes come before their parts."""
    return tuple(sorted(objects, key=lambda o: (o.part_of is not None, o.name)))


def _action(call: Call, objects: Mapping[str, Object], numbers: Iterator[int], whole: str = "") -> Action:
    """Return the designator of a task call or of a control structure, numbered in order.

    Calls inside a fallback are named as its parts.
    """
    if isinstance(call, TaskCall):
        roles = {r: objects[f] for r, f in call.roles.items() if f in objects}
        name = part_name(whole, f"{next(numbers)}.{call.task.task.split(':')[-1]}")
        where = {"where": call.where} if call.where else {}
        return Action(name, call.task.task, roles, parameters={**(call.parameters or {}), **where})
    name = part_name(whole, f"{next(numbers)}.{call.rule}")
    within = name if call.kind == "fallback" and not call.changes else whole
    branches: tuple[tuple[Designator, ...], ...]
    branches = tuple(tuple(_action(c, objects, numbers, within) for c in branch) for branch in call.branches)
    if call.kind == "choose":  # what only one alternative is about is looked for when that one is tried
        used = [{f for c in task_calls(b) for f in c.roles.values() if f in objects} for b in call.branches]
        branches = tuple((*_in_order(objects[f] for f in u), *b) for u, b in zip(used, branches, strict=True))
    if call.changes:
        part = branches[0][0]
        assert isinstance(part, Action)  # a retry is of one task
        return retry(name, part, *call.changes)
    return compound(call.kind, name, branches, **call.parameters)


Ahead = tuple[Location, Action | None]
"""Place to which a free motion leads, and the next task, which begins there; None in place of the task if no later task states its
beginning."""


def _with_goals(actions: Sequence[Any], types: Mapping[str, TaskType], ahead: Ahead) -> tuple[tuple[Any, ...], Ahead]:
    """Set the target of each free motion (a task that only moves the arm) in a task sequence.

    The result is the sequence, and the place where its first task begins.

    A free motion leads to where the next task starts; the last one leads to ``ahead``.
    """
    result: list[Action] = []
    for action in reversed(actions):
        if isinstance(action, Compound):
            done = [_with_goals(branch, types, ahead) for branch in action.branches]
            action, ahead = replace(action, branches=tuple(branch for branch, _ in done)), done[0][1]
        elif isinstance(action, Action):
            task = types[action.task]
            if task.leads_on:
                action = replace(action, goal=task.leads_to(action, ahead[1], ahead[0]))
            begins = task.begins_at(action)
            ahead = (begins, action) if begins else ahead
        result.append(action)
    return tuple(reversed(result)), ahead


def _effectors(episode: Episode) -> set[str]:
    """Return the names of the effector and its parts."""
    own = {e.name for e in episode.entities if e.part_of == episode.effector}
    return own | ({episode.effector} if episode.effector else set())


def _variables(fillers: Iterable[str], entities: Mapping[str, Entity]) -> dict[str, str]:
    """Map each entity to a variable, in order of first appearance; a part's whole gets a variable too."""
    names: dict[str, str] = {}
    for filler in fillers:
        whole = entities[filler].part_of
        for entity in (whole, filler) if whole else (filler,):
            names.setdefault(entity, f"object_{len(names) + 1}")
    return names


def _describe(variables: Mapping[str, str], entity: Entity, taxonomy: Taxonomy) -> Object:
    part_of = variables.get(entity.part_of) if entity.part_of else None
    like = () if entity.types or part_of else _suggested(entity.name, taxonomy)
    return Object(variables[entity.name], types=entity.types, part_of=part_of, like=like)


def _suggested(name: str, taxonomy: Taxonomy) -> tuple[str, ...]:
    """Return the class whose label occurs in a thing's name, and superclasses whose other members may replace
    the thing.

    Any crockery may replace a plate. A superclass counts only if it, or one above it, has a restriction.
    """
    if (named := taxonomy.thing_named(name)) is None:
        return ()
    above = taxonomy.parents.get(named[0], ())
    return (named[0], *(c for c in above if any(taxonomy.restrictions.get(a) for a in taxonomy.ancestors(c))))
