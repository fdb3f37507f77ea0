"""A plan: a task sequence with types, roles and constraints, and nothing of the instance it came from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from .designators import Action, Location, Object
from .episode import Entity, Episode
from .tasks import TaskType

HOME = Location("home", "home")


@dataclass(frozen=True)
class Plan:
    """An underspecified plan.

    Args:
        name: for people.
        objects: what plays a role, one designator per thing meant.
        actions: in order.
    """

    name: str
    objects: tuple[Object, ...]
    actions: tuple[Action, ...]

    def __str__(self) -> str:
        return " -> ".join(a.task.split(":")[-1] for a in self.actions)


@dataclass(frozen=True)
class TaskCall:
    """A task with fillers for its roles: one step of an interpreted sequence or of a scenario."""

    task: TaskType
    roles: Mapping[str, str]
    parameters: Mapping[str, float] | None = None


def plan_from_episode(name: str, calls: Sequence[TaskCall], episode: Episode) -> Plan:
    """Generalise an interpreted task sequence.

    Entities become variables that keep their classes; what the tasks need of them (features,
    affordances) is added; poses, times, sizes and instance names stay behind.
    """
    entities = {e.name: e for e in episode.entities}
    effectors = _effectors(episode)
    fillers = [f for c in calls for r, f in c.roles.items() if f not in effectors and f in entities]
    variables = _variables(fillers, entities)
    objects = {entity: _describe(variables, entities[entity]) for entity in variables}
    return build_plan(name, calls, objects)


def build_plan(name: str, calls: Sequence[TaskCall], objects: Mapping[str, Object]) -> Plan:
    """A plan of task calls whose fillers are keys of ``objects``; other fillers (the effector) are left out."""
    constrained = dict(objects)
    for call in calls:
        for role, filler in call.roles.items():
            declared = call.task.role(role)
            if filler in constrained and declared is not None and not declared.effector:
                constrained[filler] = declared.constrain(constrained[filler])
    actions = [
        Action(
            f"{k}.{call.task.task.split(':')[-1]}",
            call.task.task,
            {r: constrained[f] for r, f in call.roles.items() if f in constrained},
            parameters=call.parameters or {},
        )
        for k, call in enumerate(calls, 1)
    ]
    ordered = sorted(constrained.values(), key=lambda o: (o.part_of is not None, o.name))
    return Plan(name, tuple(ordered), tuple(_with_goals(actions, [c.task for c in calls])))


def _with_goals(actions: Sequence[Action], types: Sequence[TaskType]) -> Iterable[Action]:
    """A free motion leads to where the next task begins; the last one leads home."""
    goal = HOME
    result: list[Action] = []
    for action, task in zip(reversed(actions), reversed(types), strict=True):
        if task.leads_on:
            action = replace(action, goal=goal)
        goal = task.begins_at(action) or goal
        result.append(action)
    return reversed(result)


def _effectors(episode: Episode) -> set[str]:
    """The effector and its parts."""
    own = {e.name for e in episode.entities if e.part_of == episode.effector}
    return own | ({episode.effector} if episode.effector else set())


def _variables(fillers: Iterable[str], entities: Mapping[str, Entity]) -> dict[str, str]:
    """entity -> variable, in order of first appearance; the whole of a part gets one too."""
    names: dict[str, str] = {}
    for filler in fillers:
        whole = entities[filler].part_of
        for entity in (whole, filler) if whole else (filler,):
            names.setdefault(entity, f"object_{len(names) + 1}")
    return names


def _describe(variables: Mapping[str, str], entity: Entity) -> Object:
    part_of = variables.get(entity.part_of) if entity.part_of else None
    return Object(variables[entity.name], types=entity.types, part_of=part_of)
