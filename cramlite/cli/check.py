"""``cramlite check``: checks files without running anything."""

from __future__ import annotations

import argparse
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import UserError
from ..base.resources import find_scenario
from .arguments import Add, plugin_choice
from .texts import counted

if TYPE_CHECKING:
    from ..engine.engine import Engine
    from ..engine.setting import Setting
    from ..model.plan import Plan
    from ..planning.trace import Trace
    from ..plugin.catalogue import Knowledge
    from ..plugin.selection import PluginChoice
    from ..scenario.scenario import Scenario


def _check(arguments: argparse.Namespace) -> int:
    """Check a scenario, a rule file or a program, and print the findings.

    Returns:
        0 if no safety rule is violated; doubts are printed and do not count.

    Raises:
        UserError: the first thing that is wrong, with file and line.
    """
    path, plugins = Path(arguments.file), plugin_choice(arguments)
    if path.suffix in (".ttl", ".owl", ".rdf", ".nt", ".ofn", ".jsonld"):
        raise UserError(f"'{path}' is an ontology; 'cramlite ontology check {path}' checks it.")
    if path.suffix in (".script", ".urscript", ".urp"):
        return _check_program(path, plugins)
    if path.suffix == ".json":
        return _check_typed(path, plugins)
    return _check_yaml(find_scenario(arguments.file), plugins)


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
    print(f"{path}: the rule of {rule.task}, {counted(len(rule.clauses), 'condition')}, roles {', '.join(rule.roles) or 'none'}")
    return 0


def _check_scenario(path: Path, data: Any, plugins: PluginChoice) -> int:
    from ..engine.engine import make_engine
    from ..engine.scenario_doubts import doubts, doubts_of_files
    from ..scenario.scenario import scenario_from

    scenario = scenario_from(path, data)
    engine = make_engine(scenario, plugins)
    setting = engine.setting(scenario)
    for doubt in (*doubts(scenario, setting, engine.knowledge), *doubts_of_files(scenario, setting)):
        print(doubt)
    things = counted(len(setting.world.things), "thing")
    print(f"{path}: '{scenario.name}' starts from {_start(scenario, setting, engine)}; robot {setting.robot.type}, {things}, "
          f"code by {setting.backend.name}")  # fmt: skip
    return 0


def _start(scenario: Scenario, setting: Setting, engine: Engine) -> str:
    """Describe what a scenario starts from (a demonstration's reading, a goal's plan, or its tasks), or raise
    if a run could not start from it."""
    if scenario.spec.demonstration is not None:
        return f"the demonstration '{scenario.spec.demonstration}', read as {_shown(scenario, setting, engine).with_things}"
    if scenario.spec.goal is not None:
        return f"the goal '{' and '.join(scenario.spec.goal)}', with the plan {_planned(scenario, setting, engine.knowledge).with_things}"
    from ..planning.task_goals import plan_from_tasks

    return f"the plan {plan_from_tasks(scenario.name, scenario, engine.knowledge.tasks, setting.world).with_things}"


def _planned(scenario: Scenario, setting: Setting, knowledge: Knowledge) -> Plan:
    from ..planning.task_sequences import plans_for_goal
    from ..planning.trace import Trace

    trace = Trace()
    plan = next(plans_for_goal(setting.name, scenario, setting.symbolic(knowledge.taxonomy), knowledge, trace), None)
    if plan is None:
        goal = " and ".join(scenario.spec.goal or ())
        raise UserError(f"{scenario.where('goal')}: no plan achieves the goal '{goal}': {_refused(trace)}.")
    return plan


def _shown(scenario: Scenario, setting: Setting, engine: Engine) -> Plan:
    """Return the plan of the likeliest reading of the demonstration for which the scenario has all things.

    Things that a camera is still to find count as there.
    """
    from ..engine.search_in_setting import are_there
    from ..planning.diagnosis import nearest_miss
    from ..planning.search.budget import budget_of
    from ..planning.trace import Trace

    place, trace = scenario.where("demonstration"), Trace()
    try:
        plans = [plan for plan, _ in islice(engine.plans(scenario, setting, trace), budget_of(scenario).sequences)]
    except UserError as error:
        raise UserError(f"{place}: the demonstration cannot be used: {error}") from error
    if not plans:
        raise UserError(f"{place}: no task sequence can be made of the demonstration: {_refused(trace)}.")
    found = next((plan for plan in plans if are_there(plan, setting, engine.knowledge, trace)), None)
    if found is None:
        miss = nearest_miss(trace.entries)
        raise UserError(
            f"{place}: the scenario has no things for the demonstration, read as {plans[0]}: "
            f"{f'{miss.designator}: {miss.reason}' if miss else 'no thing fits'}."
        )
    return found


def _refused(trace: Trace) -> str:
    return "; ".join(dict.fromkeys(e.reason for e in trace.entries if e.outcome == "refused"))


def _check_program(path: Path, plugins: PluginChoice) -> int:
    from ..plugin.catalogue import Knowledge
    from .program_input import naming, read_text

    text = read_text(path)
    simulator = Knowledge(plugins.registry()).simulator
    with naming(path):
        doubts = list(simulator.inspect(text))
    for line, doubt in doubts:
        print(f"{path}:{line}: {doubt}")
    said = counted(len(doubts), "doubt") if doubts else "no doubts"
    print(f"{path}: {counted(len(text.splitlines()), 'line')}, no errors, {said}")
    return 0


def _check_typed(path: Path, plugins: PluginChoice) -> int:
    from ..model.program.program_json import read_program
    from ..model.program.program_safety import violations
    from ..model.program.steps import walk
    from ..model.world.world import World
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
        raise UserError("\n".join([f"{counted(len(found), 'objection')} to the program:", *found]))
    print(f"{path}: a program for '{robot.type}', {counted(len(read.program.steps), 'step')}, no safety rule is violated")
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``check``, with its arguments, to the command line."""
    check = add("check", _check)
    check.add_argument("file", help="a scenario's file or name, a rule file, or a program's text")
