"""``cramlite goal``: the tasks that achieve a scenario's goal, its PDDL, and plans of other planners for it."""

from __future__ import annotations

import argparse
from itertools import islice
from pathlib import Path

from ..base.errors import NoSolution, UserError
from ..base.resources import find_scenario
from ..engine.engine import Engine, make_engine
from ..planning.goal_parts import PART, goal_answers
from ..planning.scenario_goals import problem_of_scenario
from ..planning.task_sequences import plans_for_goal
from ..planning.trace import Trace
from ..scenario.scenario import Scenario
from .arguments import Add, plugin_choice
from .say import add_say, said_in, said_of, understood_text
from .texts import counted


def _goal(arguments: argparse.Namespace) -> int:
    if arguments.plans < 1:
        raise UserError(f"--plans {arguments.plans}: the number of plans is at least 1.")
    scenario = said_in(find_scenario(arguments.scenario), said_of(arguments))
    if scenario.spec.goal is None:
        raise UserError(f"{scenario.path} has no goal; write one such as 'goal: [drawer open]' in the place of its tasks.")
    scenario = scenario.planned_by(arguments.plan) if arguments.plan else scenario
    engine = make_engine(scenario, plugin_choice(arguments))
    if arguments.pddl:
        return _write(scenario, engine, arguments)
    return _show(scenario, engine, arguments)


def _show(scenario: Scenario, engine: Engine, arguments: argparse.Namespace) -> int:
    """Print the plans that achieve a scenario's goal, with the reason for each of their tasks."""
    setting, trace, shown = engine.setting(scenario, seed=arguments.seed), Trace(), 0
    scene = setting.symbolic(engine.knowledge.taxonomy)
    for line in understood_text(scenario, setting, engine.knowledge):
        print(line)
    for plan in islice(plans_for_goal(setting.name, scenario, scene, engine.knowledge, trace), arguments.plans):
        print(f"{plan}, for '{' and '.join(plan.goal)}'")
        steps = (e for e in trace.entries[shown:] if e.outcome == "chosen")
        for number, entry in enumerate(steps, 1):
            print(f"  {number}. {entry.text}: {entry.reason.partition(': ')[2]}")
        shown = len(trace.entries)
    if not any(e.outcome == "chosen" for e in trace.entries):
        why = "; ".join(dict.fromkeys(e.reason for e in trace.entries if e.designator != PART))
        parts = "".join(f"\n  {answer}" for answer in goal_answers(trace))
        raise NoSolution(f"{scenario.where('goal')}: no tasks achieve the goal: {why}.{parts}")
    return 0


def _write(scenario: Scenario, engine: Engine, arguments: argparse.Namespace) -> int:
    """Write the PDDL domain and problem of a scenario's goal."""
    scene = engine.setting(scenario, seed=arguments.seed).symbolic(engine.knowledge.taxonomy)
    problem = problem_of_scenario(scenario, scene, engine.knowledge)
    scope = None if arguments.all else next(problem.scopes())
    text, folder = problem.pddl(scope), arguments.pddl
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "domain.pddl").write_text(text.domain, encoding="utf-8", newline="\n")
        (folder / "problem.pddl").write_text(text.problem, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UserError(f"'{folder}' cannot be written: {error.strerror}; give another folder.") from error
    left = len(problem.grounder.things) - len(scope.things) if scope else 0
    told = f", {counted(left, 'thing')} that the goal does not need left out (--all keeps all)" if left else ""
    print(f"{folder}/domain.pddl and problem.pddl: '{' and '.join(problem.says)}', {counted(len(text.actions), 'action')}{told}.")
    print(f"A program from a plan for this problem: cramlite resolve {arguments.scenario} --plan FILE")
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``goal``, with its arguments, to the command line."""
    goal = add("goal", _goal)
    goal.add_argument("scenario", help="a scenario file with a goal, or the name of a shipped one")
    goal.add_argument("--seed", type=int, default=0, help="0 (default) is the world as written; others vary it")
    add_say(goal)
    goal.add_argument("--plans", type=int, default=1, help="number of plans that are printed; default 1")
    goal.add_argument("--pddl", type=Path, metavar="DIR", help="write domain.pddl and problem.pddl there, and do not plan")
    goal.add_argument("--all", action="store_true", help="all things of the world in the PDDL, not those that the goal is about")
    goal.add_argument("--plan", type=Path, metavar="FILE", help="check a PDDL plan for the goal, and say what each step is for")
