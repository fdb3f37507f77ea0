"""cramlite: demonstrations become robot programs whose text was proven in simulation.

This module is for programs that embed the engine; `cramlite.plugin` is for those who write plugins, `cramlite.model` has the
values that both talk about, and `cramlite.testing` checks plugins. These four are the whole public API. Names are imported
when they are first used, so that ``import cramlite`` costs next to nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .base.lazy_names import LazyNames
from .version import VERSION

if TYPE_CHECKING:
    from .base.errors import CramliteError, NoSolution, PluginError, Unresolvable, UserError
    from .base.resources import data_folder, find_scenario
    from .cli.trace_text import trace_text
    from .engine.candidates import CandidateSequence
    from .engine.engine import Engine
    from .engine.reading import Reading
    from .engine.setting import Setting
    from .engine.solution import Solution
    from .interpretation.interpretation import Interpretation
    from .model.plan import Plan
    from .model.verdict import Verdict
    from .perception.active_perception import Picture
    from .perception.pictures import depth_image, overlay
    from .perception.result import Percept
    from .planning.budget import Budget
    from .planning.diagnosis import how_it_ended, nearest_miss
    from .planning.failure import failure_text
    from .planning.goal_parts import GoalAnswer, goal_answers
    from .planning.heartbeat import NowDone
    from .planning.operators import Operator
    from .planning.pddl import PddlText, PlanStep
    from .planning.plan_file import checked_steps, steps_of
    from .planning.planning_problem import PlanningProblem, planning_problem
    from .planning.task_goals import Goal
    from .planning.trace import Entry, Trace
    from .planning.what_to_try import what_to_try
    from .report import Finished
    from .report.reading_picture import reading_picture
    from .scenario.scenario import Scenario, read_scenario
    from .scenario.task_specs import RuleSpec, TaskSpec, task_entry

__version__ = VERSION

_HOMES = {
    ".base.errors": "CramliteError NoSolution PluginError Unresolvable UserError",
    ".base.resources": "data_folder find_scenario",
    ".engine.candidates": "CandidateSequence",
    ".engine.engine": "Engine",
    ".engine.reading": "Reading",
    ".engine.setting": "Setting",
    ".engine.solution": "Solution",
    ".interpretation.interpretation": "Interpretation",
    ".model.plan": "Plan",
    ".model.verdict": "Verdict",
    ".perception.active_perception": "Picture",
    ".perception.pictures": "depth_image overlay",
    ".perception.result": "Percept",
    ".planning.budget": "Budget",
    ".planning.planning_problem": "PlanningProblem planning_problem",
    ".planning.goal_parts": "GoalAnswer goal_answers",
    ".planning.heartbeat": "NowDone",
    ".planning.operators": "Operator",
    ".planning.pddl": "PddlText PlanStep",
    ".planning.plan_file": "checked_steps steps_of",
    ".planning.diagnosis": "how_it_ended nearest_miss",
    ".planning.failure": "failure_text",
    ".planning.what_to_try": "what_to_try",
    ".planning.task_goals": "Goal",
    ".planning.trace": "Entry Trace",
    ".report": "Finished",
    ".report.reading_picture": "reading_picture",
    ".scenario.scenario": "Scenario read_scenario",
    ".scenario.task_specs": "RuleSpec TaskSpec task_entry",
    ".cli.trace_text": "trace_text",
}
_NAMES = LazyNames(__name__, _HOMES)

__all__ = [
    "Budget",
    "CandidateSequence",
    "CramliteError",
    "Engine",
    "Entry",
    "Finished",
    "Goal",
    "GoalAnswer",
    "Interpretation",
    "NoSolution",
    "NowDone",
    "Operator",
    "PddlText",
    "Percept",
    "Picture",
    "Plan",
    "PlanStep",
    "PlanningProblem",
    "PluginError",
    "Reading",
    "RuleSpec",
    "Scenario",
    "Setting",
    "Solution",
    "TaskSpec",
    "Trace",
    "Unresolvable",
    "UserError",
    "Verdict",
    "checked_steps",
    "data_folder",
    "depth_image",
    "failure_text",
    "find_scenario",
    "goal_answers",
    "how_it_ended",
    "nearest_miss",
    "overlay",
    "planning_problem",
    "read_scenario",
    "reading_picture",
    "steps_of",
    "task_entry",
    "trace_text",
    "what_to_try",
]


if not TYPE_CHECKING:  # else any name would do

    def __getattr__(name: str) -> Any:
        return _NAMES.load(name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
