"""``cramlite check``: checks files without running anything."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import UserError
from ..base.resources import find_scenario
from ..plugin.selection import INSTALLED, PluginChoice
from .arguments import Add, plugin_choice

if TYPE_CHECKING:
    from ..scenario.scenario import Scenario



def check_file(name: str, plugins: PluginChoice = INSTALLED) -> int:
    """Check a scenario, a rule file or a program, and print what was found.

    Returns:
        0 if nothing stands against it; doubts are printed and do not count.

    Raises:
        UserError: the first thing that is wrong, with file and line.
    """
    path = Path(name)
    if path.suffix in (".ttl", ".owl", ".rdf"):
        raise UserError(f"'{path}' is an ontology; 'cramlite ontology check {path}' checks it.")
    if path.suffix in (".script", ".urscript"):
        return _check_program(path, plugins)
    if path.suffix == ".json":
        return _check_typed(path, plugins)
    return _check_yaml(find_scenario(name), plugins)


def _check_yaml(path: Path, plugins: PluginChoice) -> int:
    from ..base.yaml_file import load_yaml

    data = load_yaml(path)
    if isinstance(data, dict) and "task" in data and "scenario" not in data:
        return _check_rule(path, plugins)
    return _check_scenario(path, data, plugins)


def _check_rule(path: Path, plugins: PluginChoice) -> int:
    from ..interpretation.rules import load_rules
    from ..plugin.catalogue import Knowledge

    knowledge = Knowledge(plugins.registry())
    (rule,) = load_rules([path], knowledge.predicates, knowledge.taxonomy)
    print(f"{path}: the rule of {rule.task}, {len(rule.clauses)} conditions, roles {', '.join(rule.roles) or 'none'}")
    return 0


def _check_scenario(path: Path, data: Any, plugins: PluginChoice) -> int:
    from ..engine.engine import make_engine
    from ..engine.scenario_doubts import doubts
    from ..planning.trace import Trace
    from ..scenario.scenario import scenario_from

    scenario = scenario_from(path, data)
    engine = make_engine(scenario, plugins)
    setting = engine.setting(scenario)
    for doubt in doubts(scenario, setting, engine.knowledge):
        print(doubt)
    if scenario.spec.world is not None:
        for thing in setting.world.things:
            print("".join(f"thing '{thing.name}': {note}\n" for note in thing.notes), end="")
    things = len(setting.world.things)
    start = _start(scenario) if scenario.spec.demonstration is not None else ""
    if scenario.spec.goal is not None:
        from ..planning.task_sequences import plans_for_goal

        trace, goal = Trace(), " and ".join(scenario.spec.goal)
        plan = next(plans_for_goal(setting.name, scenario, setting.symbolic(engine.knowledge.taxonomy), engine.knowledge, trace), None)
        if plan is None:
            why = "; ".join(dict.fromkeys(e.reason for e in trace.entries if e.outcome == "refused"))
            raise UserError(f"{scenario.where('goal')}: no plan achieves the goal '{goal}': {why}.")
        start = f"the goal '{goal}', with the plan {plan}"
    elif scenario.spec.demonstration is None:
        from ..planning.task_goals import plan_from_tasks

        start = f"the plan {plan_from_tasks(scenario.name, scenario, engine.knowledge.tasks, setting.world)}"
    print(f"{path}: '{scenario.name}' starts from {start}; robot {setting.robot.type}, {things} things, "
          f"code by {setting.backend.name}")  # fmt: skip
    return 0


def _start(scenario: Scenario) -> str:
    name = scenario.spec.demonstration or ""
    place = scenario.resolve_path(name)
    if not place.exists():
        raise UserError(
            f"{scenario.where('demonstration')}: there is no episode at '{place}'; record one with 'cramlite record'."
        )
    return f"the demonstration '{name}'"


def _check_program(path: Path, plugins: PluginChoice) -> int:
    from ..plugin.catalogue import Knowledge
    from .judge import read_text

    text = read_text(path)
    simulator = Knowledge(plugins.registry()).simulator
    try:
        doubts = list(simulator.inspect(text))
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    for line, doubt in doubts:
        print(f"{path}:{line}: {doubt}")
    print(f"{path}: {len(text.splitlines())} lines, nothing is wrong, {len(doubts) or 'no'} doubt{'' if len(doubts) == 1 else 's'}")
    return 0


def _check_typed(path: Path, plugins: PluginChoice) -> int:
    from ..model.program_json import read_program
    from ..model.program_safety import violations
    from ..model.steps import walk
    from ..model.world import World
    from ..plugin.catalogue import Knowledge, pick
    from ..scenario.worlds import read_world

    try:
        read = read_program(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"The program '{path}' cannot be read: {error}.") from error
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    knowledge = Knowledge(plugins.registry())
    beside = path.parent / "world.json"  # a robot from a file is known by the world that it stands in
    world = read_world(str(beside), knowledge, 0) if beside.is_file() else World(())
    robot = pick("robot", knowledge.robots_of(world), read.program.robot_type, str(path))
    lines = {s.origin: read.lines[id(s)] for s in walk(read.program.steps)}
    found = [f"{path}:{lines.get(o.origin, 1)}: {o.origin or 'the program'}: {o.rule}: {o.reason}"
             for o in violations(read.program, robot)]  # fmt: skip
    if found:
        raise UserError("\n".join([f"{len(found)} things stand against the program:", *found]))
    print(f"{path}: a program for '{robot.type}', {len(read.program.steps)} steps, nothing stands against it")
    return 0


def _check(arguments: argparse.Namespace) -> int:

    return check_file(arguments.file, plugins=plugin_choice(arguments))


def add_commands(add: Add) -> None:
    """Declare ``check`` with its arguments."""
    check = add("check", _check)
    check.add_argument("file", help="a scenario's file or name, a rule file, or a program's text")
