"""Goals that name their tasks: a scenario's task list, a list of tasks, or a single one become a plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from .designators import Object
from .errors import UserError, nearest
from .plan import Plan, TaskCall, build_plan
from .scenario import ObjectSpec, Scenario, TaskSpec
from .tasks import TaskType, task_type
from .world import World


def plan_from_tasks(
    name: str, goal: Scenario | Sequence[TaskSpec] | TaskSpec, tasks: Mapping[str, TaskType], world: World
) -> Plan:
    """The plan of a goal, its names checked against task types and world.

    Raises:
        UserError: an unknown task, role, parameter or object; a scenario's with file and line.
    """
    objects = dict(goal.spec.objects) if isinstance(goal, Scenario) else {}
    calls = [_call(task, place, tasks, objects, world) for task, place in _listed(goal)]
    fillers = dict.fromkeys(f for c in calls for f in c.roles.values())
    return build_plan(name, calls, {f: _object(f, objects, world) for f in fillers})


def _listed(goal: Scenario | Sequence[TaskSpec] | TaskSpec) -> list[tuple[TaskSpec, str]]:
    """Tasks, each with where it stands, "file:line: " or nothing."""
    if isinstance(goal, TaskSpec):
        return [(goal, "")]
    if not isinstance(goal, Scenario):
        return [(task, "") for task in goal]
    if goal.spec.designator is not None:
        return [(goal.spec.designator, goal.where("designator") + ": ")]
    return [(task, goal.where("tasks", k) + ": ") for k, task in enumerate(goal.spec.tasks or ())]


def _call(
    task: TaskSpec, place: str, tasks: Mapping[str, TaskType], objects: Mapping[str, ObjectSpec], world: World
) -> TaskCall:
    try:
        call = TaskCall(task_type(tasks, task.task), task.roles, task.parameters)
        _check_call(call)
        for filler in call.roles.values():
            _object(filler, objects, world)
    except UserError as error:
        raise UserError(f"{place}{error}") from error
    return call


def _check_call(call: TaskCall) -> None:
    """Roles are known and complete."""
    names = {r.name for r in call.task.roles}
    for role in call.roles:
        if role not in names:
            raise UserError(f"Task '{call.task.task}' has no role '{role}'; {nearest(role, names)}.")
    parameters = [p.name for p in call.task.parameters]
    for name in call.parameters or {}:
        if name not in parameters:
            raise UserError(f"Task '{call.task.task}' has no parameter '{name}'; {nearest(name, parameters)}.")
    for needed in call.task.roles:
        if needed.required and not needed.effector and needed.name not in call.roles:
            raise UserError(f"Task '{call.task.task}' needs a filler for its role '{needed.name}'.")


def _object(name: str, objects: Mapping[str, ObjectSpec], world: World) -> Object:
    """A declared object, or a thing (or "thing/feature") of the world by name."""
    if name in objects:
        return Object(name, **objects[name].model_dump())
    features = {f"{t.name}/{f.name}" for t in world.things for f in t.features}
    valid = {t.name for t in world.things} | features
    if name not in valid | set(objects):
        raise UserError(
            f"No object '{name}' is declared under 'objects' or stands in the world; {nearest(name, valid | set(objects))}."
        )
    return replace(Object(name), entity=name)
