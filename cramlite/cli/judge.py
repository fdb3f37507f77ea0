"""Judging of any program text against a plan or a goal, for ``cramlite judge`` and ``cramlite execute``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError
from ..base.json_text import as_json
from ..base.resources import find_scenario
from ..engine.proof.intent import read_intent
from ..engine.proof.judging import JudgedRun, Purpose, judge_text
from ..interpretation.fluents import symbolic_world
from ..model.world.world import World
from ..planning.scenario_goals import meanings
from ..planning.task_goals import Goal, plan_from_tasks
from ..plugin.catalogue import Knowledge
from ..scenario.scenario import Scenario, read_scenario
from .arguments import Add, add_seed, plugin_choice
from .program_input import naming, read_text, robots_world
from .texts import findings_text, warn_of


def _judge(arguments: argparse.Namespace) -> int:
    """Run a program's text, which may have been edited, and print the findings of every validator.

    Raises:
        NoSolution: a validator objects; all findings were printed.
        UserError: a file that cannot be used, a goal that is none, or neither plan nor goal.
    """
    program, seed = arguments.program, arguments.seed
    knowledge = Knowledge(plugin_choice(arguments).registry())
    text, place = read_text(program), robots_world(arguments.world, program, knowledge, seed)
    judged = judged_text(program, text, place, purpose_of(arguments.plan, arguments.goal, knowledge, place), knowledge, seed)
    print(as_json(judged_json(judged)) if arguments.json else findings_text(judged.verdict, judged.remarks))
    warn_of(knowledge.registry.faults)
    refuse(program, judged)
    return 0


def judged_text(program: Path, text: str, place: World, purpose: Purpose, knowledge: Knowledge, seed: int) -> JudgedRun:
    """Run and judge a program's text; errors in the text name its file."""
    with naming(program):
        return judge_text(text, place, purpose, knowledge, seed)


def judged_json(judged: JudgedRun) -> dict[str, Any]:
    """Return a verdict as ``--json`` prints it."""
    verdict = judged.verdict
    return {
        "passed": verdict.passed, "reason": verdict.reason, "findings": verdict.findings,
        "advice": [f.reason for f in verdict.advice], "left_out": verdict.left_out,
        "remarks": judged.remarks,
    }  # fmt: skip


def refuse(program: Path, judged: JudgedRun) -> None:
    """End the command with an error if a validator objects, or if no validator applied.

    Raises:
        NoSolution: with the objections.
    """
    if not judged.verdict.passed:
        why = judged.verdict.reason if judged.verdict.findings else "no validator had anything to look at"
        raise NoSolution(f"'{program}' was refused: {why}")


def purpose_of(plan: str, goals: Sequence[str], knowledge: Knowledge, place: World) -> Purpose:
    """Return the plan or goal against which a program text is judged.

    Args:
        plan: a run directory, its ``plan.json``, or a scenario with tasks or a goal; "" for none.
        goals: what should hold in the end, e.g. "coffee in basket".

    Raises:
        UserError: neither plan nor goal, or a plan that cannot be used.
    """
    if not plan and not goals:
        raise UserError("Say what the program is for: --plan with a run directory or scenario, --goal 'THING on PLACE', or both.")
    if not plan:
        return Purpose(goal=tuple(goals))
    path = Path(plan)
    if path.is_dir() or path.suffix == ".json":
        return Purpose(intent=read_intent(path if path.is_dir() else path.parent), goal=tuple(goals))
    found = _of_scenario(read_scenario(find_scenario(plan)), knowledge, place)
    return replace(found, goal=(*found.goal, *goals))


def _of_scenario(scenario: Scenario, knowledge: Knowledge, place: World) -> Purpose:
    """Return what a program text is judged by: the scenario's goal, or its tasks if they name all their things."""
    if scenario.spec.demonstration is not None:
        raise UserError(
            f"{scenario.where('demonstration')}: which things a demonstration means is found when it is resolved; give the run "
            f"directory of 'cramlite resolve {scenario.name}'."
        )
    limits = scenario.spec.limits.judging()
    if scenario.spec.goal is not None:
        return Purpose(goal=_meant(scenario, knowledge, place), limits=limits)
    plan = plan_from_tasks(scenario.name, scenario, knowledge.tasks, place)
    open_ones = [o.name for a in plan.actions for o in a.roles.values() if not o.entity]
    if open_ones or any(a.task not in knowledge.tasks for a in plan.actions):
        what = f"which thing '{open_ones[0]}' is" if open_ones else "what its rules decide"
        why = f"the scenario leaves open {what}, which is only found when it is resolved"
        raise UserError(f"{scenario.where('tasks')}: {why}; give the run directory of 'cramlite resolve'.")
    return Purpose(plan=plan, actions=plan.actions, limits=limits)


def _meant(scenario: Scenario, knowledge: Knowledge, place: World) -> tuple[str, ...]:
    """Goal of a scenario with its described objects replaced by things of the world.

    Raises:
        UserError: a described object may be several of them, or none.
    """
    choices = list(meanings(scenario, symbolic_world(place, knowledge.taxonomy), knowledge))
    if len(choices) != 1:
        may = f"may mean '{choices[0]}' or '{choices[1]}'" if choices else "means nothing that is there"
        raise UserError(f"{scenario.where('goal')}: '{Goal(scenario.spec.goal or ())}' {may}; name the things with --goal.")
    return choices[0].says


def add_purpose(command: argparse.ArgumentParser) -> None:
    """Declare the options for the plan or goal that a text is judged by."""
    command.add_argument(
        "--plan", default="",
        help="what it is for: a run directory, its plan.json, or a scenario with tasks or a goal",
    )
    command.add_argument(
        "--goal", action="append", default=[], help="what should hold in the end, such as 'coffee in basket'; may be given several times"
    )


def add_commands(add: Add) -> None:
    """Add the command ``judge``, with its arguments, to the command line."""
    judge = add("judge", _judge)
    judge.add_argument("program", type=Path, help="the text, URScript or a typed program as JSON")
    judge.add_argument(
        "--world", required=True,
        help="a run directory, its world.json, or a scenario, whose real world with this seed is taken",
    )
    add_purpose(judge)
    add_seed(judge)
    judge.add_argument(
        "--json", action="store_true",
        help="print as JSON: passed, reason, findings, advice, left_out, remarks",
    )
