"""Plans of goals that are given as tasks: a scenario's task list, a list of tasks, or a single task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.control_flow import Kind
from ..model.designators import Object
from ..model.entity_name import EntityName
from ..model.plan import Plan
from ..model.world.world import World
from ..plugin.task_type import TaskType, task_type
from ..scenario.goal_spec import goal_texts
from ..scenario.scenario import ObjectSpec, Scenario
from ..scenario.task_specs import Path, RuleSpec, TaskSpec
from .plan import Call, RuleCall, TaskCall, build_plan, task_calls

Entry = TaskSpec | RuleSpec
Tasks = Scenario | Sequence[Entry] | Entry


class Goal(Value):
    """Goal as sentences about facts that should hold, for ``Engine.resolve``.

    Args:
        says: such as "coffee on hook", "tin in basket", "cup held", "drawer open"; all of it.
    """

    says: tuple[str, ...]

    @classmethod
    def said(cls, sentence: str, view: str = "") -> Goal:
        """Return a goal from a sentence such as "put both cups onto the tray", which ``Engine.resolve``
        interprets later.

        Args:
            view: from where left and right are told: "robot", "camera" or "x, y"; by default that of a fixed camera, else the robot's.
        """
        return cls(goal_texts([{"say": sentence, "view": view}]))

    @classmethod
    def from_json(cls, data: Sequence[Any]) -> Goal:
        """Return a goal that is given as JSON data, a list such as [{"goal": "on", "things": ["tin", "tray"]}]; its
        items may also be sentences.

        Raises:
            UserError: it is no list of goals.
        """
        return cls(goal_texts(data))

    def __post_init__(self) -> None:
        if isinstance(self.says, str) or not self.says:
            raise UserError(f"A goal is one or more sentences: Goal((\"block on shelf\",)), not Goal({self.says!r}).")

    def __str__(self) -> str:
        return " and ".join(self.says)


def plan_from_tasks(name: str, goal: Tasks, tasks: Mapping[str, TaskType], world: World) -> Plan:
    """Build the plan of a goal that lists tasks, its names checked against task types and world.

    Raises:
        UserError: no task, an unknown task, role, parameter or object; a scenario's with file and line.
    """
    objects = dict(goal.spec.objects) if isinstance(goal, Scenario) else {}

    def called(entry: Entry, path: Path) -> Call:
        where = goal.where(*path) + ": " if isinstance(goal, Scenario) else ""
        if isinstance(entry, TaskSpec):
            return _call(entry, where, tasks, objects, world)
        branches = tuple(
            tuple(called(e, (*path, *p)) for e, p in zip(branch, paths, strict=True))
            for branch, paths in zip(entry.do, entry.paths, strict=True)
        )
        return _ruled(entry, where, branches)

    calls = [called(entry, path) for entry, path in _listed(goal)]
    if not calls:
        place = f"{goal.where('tasks')}: " if isinstance(goal, Scenario) else ""
        raise UserError(f"{place}There is no task, so there is nothing to do; name one, such as 'Grasping'.")
    fillers = dict.fromkeys(f for c in task_calls(calls) for f in c.roles.values())
    return build_plan(name, calls, {f: _object(f, objects, world) for f in fillers})


def _listed(goal: Tasks) -> list[tuple[Entry, Path]]:
    """Return the tasks of a goal, each with the keys that lead to it in the scenario, such as ("tasks", 0)."""
    if isinstance(goal, Entry):
        return [(goal, ())]
    if not isinstance(goal, Scenario):
        return [(task, ()) for task in goal]
    if goal.spec.designator is not None:
        return [(goal.spec.designator, ("designator",))]
    return [(task, ("tasks", k)) for k, task in enumerate(goal.spec.tasks or ())]


def _ruled(entry: RuleSpec, where: str, branches: tuple[tuple[Call, ...], ...]) -> RuleCall:
    kinds: Mapping[str, Kind] = {
        "sequence": "sequence", "choose": "choose", "fallback": "fallback", "try_all": "try_all",
        "parallel": "parallel", "repeat": "repeat", "retry": "fallback", "monitor": "monitor",
    }  # fmt: skip
    watched = {"force_n": entry.force, "slip_m": entry.slip, "time_s": entry.time}
    parameters = {k: v for k, v in watched.items() if v is not None}
    if entry.rule == "repeat":
        parameters["times"] = entry.times
    for change in entry.changes:
        for call in task_calls(branches[0]):
            _check_parameters(call.task, change, where)
    return RuleCall(entry.rule, kinds[entry.rule], branches, parameters, entry.changes)


def _call(
    task: TaskSpec, place: str, tasks: Mapping[str, TaskType], objects: Mapping[str, ObjectSpec], world: World
) -> TaskCall:
    try:
        where = task.where.model_dump(exclude_none=True) if task.where else None
        kind = task_type(tasks, task.task)
        call = TaskCall(kind, _own_roles(kind, task.roles), task.parameters, where)
        _check_call(call)
        for filler in (*call.roles.values(), *(task.where.things if task.where else ())):
            _object(filler, objects, world)
    except UserError as error:
        raise UserError(f"{place}{error}") from error
    return call


def _own_roles(task: TaskType, given: Mapping[str, str]) -> dict[str, str]:
    """Return which thing fills each role of a task, with the roles' names in place of aliases that a scenario
    may use."""
    meant = {alias: role.name for role in task.roles for alias in role.aliases}
    found: dict[str, str] = {}
    for name, filler in given.items():
        role = meant.get(name, name)
        if role in found:
            raise UserError(f"Task '{task.task}' has two fillers for its role '{role}': '{found[role]}' and '{filler}'; leave one out.")
        found[role] = filler
    return found


def _check_call(call: TaskCall) -> None:
    """Check that the roles of a task call exist, and that all required ones are filled."""
    names = {r.name for r in call.task.roles}
    for role in call.roles:
        if role not in names:
            valid = names.union(*(r.aliases for r in call.task.roles))
            raise UserError(f"Task '{call.task.task}' has no role '{role}'; {nearest(role, valid)}.")
    _check_parameters(call.task, call.parameters or {})
    if call.where and not call.task.places:
        raise UserError(f"Task '{call.task.task}' chooses no place, so 'where' says nothing about it; leave it out.")
    for needed in call.task.roles:
        if needed.required and not needed.effector and needed.name not in call.roles:
            raise UserError(f"Task '{call.task.task}' needs a filler for its role '{needed.name}'.")


def _check_parameters(task: TaskType, given: Mapping[str, float], where: str = "") -> None:
    valid = [p.name for p in task.parameters]
    for name in given:
        if name not in valid:
            raise UserError(f"{where}Task '{task.task}' has no parameter '{name}'; {nearest(name, valid)}.")


def _object(name: str, objects: Mapping[str, ObjectSpec], world: World) -> Object:
    """Return the designator of a declared object, or of a thing or feature ("thing/feature") of the world."""
    if name in objects:
        return Object(name, **objects[name].model_dump())
    features = {str(EntityName(t.name, f.name)) for t in world.things for f in t.features}
    valid = {t.name for t in world.things} | features
    if name not in valid | set(objects):
        raise UserError(
            f"No object '{name}' is declared under 'objects' or stands in the world; {nearest(name, valid | set(objects))}."
        )
    return replace(Object(name), entity=name)
