"""Sentences on the command line: the option ``--say``, a scenario with a sentence as its goal, and what it means."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.value import Value
from ..base.yaml_file import load_yaml
from ..scenario.scenario import Scenario, scenario_from, started_by

if TYPE_CHECKING:
    from ..engine.setting import Setting
    from ..plugin.catalogue import Knowledge


class Said(Value):
    """Sentence in which a person says what shall be done.

    Args:
        sentence: what shall be done.
        view: from where left and right are told; "" for that of a fixed camera, else the robot's.
    """

    sentence: str
    view: str = ""


def add_say(command: argparse.ArgumentParser) -> None:
    """Declare the command-line options ``--say`` and ``--view``."""
    command.add_argument("--say", metavar="SENTENCE", help="what shall be done, in English, in the place of the scenario's start")
    command.add_argument(
        "--view", default="", metavar="VIEW",
        help="from where left and right are told: robot, camera, or a point 'x, y'; default a fixed camera, else the robot",
    )  # fmt: skip


def said_of(arguments: argparse.Namespace) -> Said | None:
    """Return the sentence of a command line; None without one.

    Raises:
        UserError: it is empty.
    """
    if arguments.say is not None and not arguments.say.strip():
        raise UserError("--say is empty; say what shall be done, such as --say 'put the tin on the tray'.")
    return Said(arguments.say, arguments.view) if arguments.say is not None else None


def said_in(path: Path, said: Said | None) -> Scenario:
    """Read a scenario and, if a sentence is given, put it in the place of its goal.

    The scenario's file then needs no goal or tasks of its own.

    Raises:
        UserError: as ``read_scenario``.
    """
    data = load_yaml(path)
    if said is None:
        return scenario_from(path, data)
    goal = {"say": said.sentence, "view": said.view}
    return scenario_from(path, started_by(data, goal)).with_goal(goal)


def understood_text(scenario: Scenario, setting: Setting, knowledge: Knowledge) -> Iterator[str]:
    """Yield one line for each English sentence in a scenario's goal: how the sentence was understood.

    Raises:
        NotUnderstood: a sentence is ambiguous, false of the scene, or in words that are not known.
    """
    from ..planning.spoken_goals import spoken
    from ..planning.task_goals import Goal
    from ..planning.trace import Trace, understood_entries

    if scenario.spec.goal is not None:
        trace = Trace()
        where = f"{scenario.where('goal')}: " if "goal" in scenario.data else ""
        spoken(Goal(scenario.spec.goal), setting.symbolic(knowledge.taxonomy), knowledge, where, trace)
        yield from (f"understood '{e.text}' {e.reason}" for e in understood_entries(trace.entries))
