"""cramlite: demonstrations become robot programs whose text was proven in simulation.

This module is for programs that embed the engine; `cramlite.plugin` is for those who write plugins, `cramlite.model` has the
values that both talk about, and `cramlite.testing` checks plugins. These four are the whole public API. Names are imported
when they are first used, so that ``import cramlite`` costs next to nothing.
"""

# ruff: noqa: I001  # names of one module stay together, each with the alias that exports it

from __future__ import annotations

from typing import TYPE_CHECKING

from .base.lazy_names import LazyNames
from .version import VERSION

if TYPE_CHECKING:
    from .base.errors import (
        CramliteError as CramliteError,
        NoSolution as NoSolution,
        PluginError as PluginError,
        Unresolvable as Unresolvable,
        UserError as UserError,
    )
    from .base.resources import data_folder as data_folder, find_scenario as find_scenario
    from .cli.trace_text import trace_text as trace_text
    from .engine.candidates import CandidateSequence as CandidateSequence
    from .engine.engine import Engine as Engine
    from .engine.recovery.expectation import Noise as Noise
    from .engine.recovery.going_on import GoingOn as GoingOn, Stretch as Stretch
    from .engine.recovery.read_belief import setting_as_read as setting_as_read
    from .engine.reading import Reading as Reading
    from .engine.setting import Setting as Setting
    from .engine.solution import Solution as Solution
    from .interpretation.interpretation import Interpretation as Interpretation
    from .language.sentence import NotUnderstood as NotUnderstood
    from .model.plan import Plan as Plan
    from .model.run.verdict import Verdict as Verdict
    from .perception.active_perception import Picture as Picture
    from .perception.pictures import depth_image as depth_image, overlay as overlay
    from .perception.result import Percept as Percept
    from .planning.search.budget import Budget as Budget
    from .planning.diagnosis import how_it_ended as how_it_ended, nearest_miss as nearest_miss
    from .planning.failure import failure_text as failure_text
    from .planning.goal_parts import GoalAnswer as GoalAnswer, goal_answers as goal_answers
    from .planning.heartbeat import NowDone as NowDone
    from .planning.operators import Operator as Operator
    from .planning.symbolic.pddl import PddlText as PddlText, PlanStep as PlanStep
    from .planning.symbolic.plan_file import checked_steps as checked_steps, steps_of as steps_of
    from .planning.symbolic.planning_problem import PlanningProblem as PlanningProblem, planning_problem as planning_problem
    from .planning.trace import understood_entries as understood_entries
    from .planning.task_goals import Goal as Goal
    from .planning.trace import Entry as Entry, Trace as Trace
    from .planning.what_to_try import what_to_try as what_to_try
    from .report import Finished as Finished
    from .report.reading_picture import reading_picture as reading_picture
    from .scenario.scenario import Scenario as Scenario, read_scenario as read_scenario
    from .scenario.task_specs import RuleSpec as RuleSpec, TaskSpec as TaskSpec, task_entry as task_entry

__version__ = VERSION
_NAMES = LazyNames(__name__)

if not TYPE_CHECKING:  # else any name would do
    __getattr__, __dir__ = _NAMES.load, _NAMES.known
