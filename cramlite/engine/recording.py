"""Recording of demonstrations: a simulated person acts, and the run is written as an episode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.control_flow import Compound
from ..model.episode import Episode
from ..planning.task_goals import Entry, plan_from_tasks
from ..plugin.demonstration import Shown
from ..plugin.task_type import task_type
from ..scenario.task_specs import TaskSpec
from ..scenario.worlds import build_world

if TYPE_CHECKING:
    from ..model.designators import Action
    from ..model.world.world import World
    from ..plugin.catalogue import Knowledge
    from ..plugin.demonstration import RecordScript
    from ..plugin.task_type import TaskType
    from ..scenario.scenario import Scenario
    from .engine import Engine


class Recording(Value):
    """Recording of a demonstration.

    Args:
        episode: that was written.
        failure: what the person did not bring about; "" where it came off, or the script does not say what it is for.
    """

    episode: Episode
    failure: str


def record_episode(
    scenario: Scenario, engine: Engine, *, seed: int, out: Path, tasks: Sequence[TaskSpec] = ()
) -> Recording:
    """Record a demonstration of a scenario into a folder, also if the demonstration fails.

    The person performs ``tasks``; else what the scenario's ``record:`` section says; else the scenario's own tasks. They act in the
    world of that section, else in the scenario's own, without the robot.

    Raises:
        UserError: the scenario says nothing about what to record, or the person cannot show it; says what they can.
    """
    recipe, spec = scenario.spec.record, scenario.spec
    things, vary = (recipe.things, recipe.vary) if recipe and recipe.things else (spec.things, spec.vary)
    knowledge = engine.knowledge
    world, _ = build_world(scenario, things, vary, knowledge, seed)
    shown = _shown(scenario, tasks or (recipe.tasks if recipe and recipe.tasks else ()), knowledge, world)
    rollout = knowledge.simulator.demonstrate(world, shown, seed=seed)
    if not len(rollout.times):
        raise UserError(f"{scenario.path}: the demonstration takes no time, so nothing was recorded; its script has to move, grip or wait.")
    episode = knowledge.episodes.detect(rollout, scenario.name)
    knowledge.episodes.write(episode, out)
    return Recording(episode, rollout.reason)


def _shown(scenario: Scenario, tasks: Sequence[Entry], knowledge: Knowledge, world: World) -> list[Shown]:
    """Return what the simulated person performs, in order: one script, or a script for each task."""
    recipe, scripts = scenario.spec.record, knowledge.record_scripts
    if not tasks and recipe is not None and recipe.script is not None:
        if recipe.script not in scripts:
            whole = [n for n in scripts if ":" not in n]
            raise UserError(f"{scenario.where('record', 'script')}: there is no script '{recipe.script}'; {nearest(recipe.script, whole)}.")
        return [Shown(scripts[recipe.script])]
    if not tasks and scenario.spec.tasks is None:
        raise UserError(
            f"{scenario.path}: the person has nothing to do: it has neither a 'record' section nor 'tasks'. Write one, or give "
            "--tasks 'PickingUp cup, Pouring cup bowl'."
        )
    plan = plan_from_tasks(scenario.name, tasks or scenario, knowledge.tasks, world)
    return [_shows(action, scripts) for action in plan.actions]


def _shows(action: Action, scripts: Mapping[str, RecordScript]) -> Shown:
    """Return the simulated person's script for a task, with the task's parameters and the things that fill
    its roles.

    Raises:
        UserError: it is a control structure, no script shows it, or a role is filled by a class.
    """
    if isinstance(action, Compound):
        raise UserError(f"A person shows tasks one after the other; '{action.kind}' is a control structure. Give a list with --tasks.")
    if action.task not in scripts:
        can = ", ".join(sorted(n.split(":")[1] for n in scripts if ":" in n))
        raise UserError(f"No script shows {action.task}. The simulated person can show: {can}.")
    classes = [r for r, o in action.roles.items() if o.entity is None]
    if classes:
        raise UserError(f"{action.name}: a person acts on a thing, and its role '{classes[0]}' names a class of things; name one thing.")
    fillers = {role: object_.entity for role, object_ in action.roles.items()}
    return Shown(scripts[action.task], {**fillers, **action.parameters})


def tasks_in_words(text: str, tasks: Mapping[str, TaskType]) -> list[TaskSpec]:
    """Parse tasks with commas between, each with its roles' fillers in order, or by name: "PickingUp cup,
    Pouring cup bowl".

    Raises:
        UserError: no task, an unknown one, or more fillers than it has roles.
    """
    found = []
    for words in (part.split() for part in text.split(",") if part.strip()):
        task = task_type(tasks, words[0])
        free = [r.name for r in task.roles if not r.effector]
        named = dict(w.split("=", 1) for w in words[1:] if "=" in w)
        plain = [w for w in words[1:] if "=" not in w]
        open_ = [r for r in free if r not in named]
        if len(plain) > len(open_):
            has = f"has the roles {', '.join(free)}" if free else "has no roles"
            raise UserError(f"'{' '.join(words)}' names {len(plain)} things, and {task.task} {has}; put a comma between two tasks.")
        found.append(TaskSpec(task=task.task, roles={**dict(zip(open_, plain, strict=False)), **named}))
    if not found:
        raise UserError("--tasks names no task; write them with commas between: 'PickingUp cup, Pouring cup bowl'.")
    return found
