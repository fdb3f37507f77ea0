"""cramlite: demonstrations become robot programs whose text was proven in simulation.

This module is the whole public API. Names are imported when they are first used,
so that ``import cramlite`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .hookspecs import hookimpl
from .version import VERSION

if TYPE_CHECKING:
    from .answers import Answers, Context, Grounding, Refused
    from .belief import Belief, Estimate, Held, initial_belief
    from .budget import Budget
    from .designators import Action, Late, Location, Motion, Object, Place, Stand
    from .engine import Engine
    from .episode import Entity, Episode, Event, Repair, Track
    from .errors import EARLIER_TASKS, CramliteError, NoSolution, PluginError, Unresolvable, UserError, nearest
    from .experts import Expert, Inputs, Judged
    from .geometry import Pose
    from .goals import Goal
    from .interpretation import Interpretation
    from .plan import Plan
    from .plugin_types import Backend, Candidate, ModelMaker, ReportSection, Simulator, Validator
    from .program import (
        CompliantSlide,
        Drive,
        ForceExtract,
        ForceInsert,
        ForceMove,
        Monitor,
        MoveJoints,
        MoveLinear,
        MoveUntilContact,
        Parallel,
        Program,
        Repeat,
        SetGripper,
        SetPayload,
        SpiralSearch,
        Step,
        TryInOrder,
        Wait,
        ZeroSensor,
    )
    from .robot_code import Code
    from .robots import Gripper, Platform, Robot
    from .rollout import Message, Rollout, Touch
    from .scenario import Scenario, read_scenario
    from .solution import Solution
    from .tasks import Decomposition, Parameter, Role, TaskType
    from .trace import Trace
    from .value import Value, replace
    from .verdict import Finding, Verdict
    from .view import Intrinsics, View
    from .world import Feature, Geom, Physics, RobotMount, Thing, World

__version__ = VERSION

_HOMES = {
    "answers": "Answers Context Grounding Refused",
    "belief": "Belief Estimate Held initial_belief",
    "budget": "Budget",
    "designators": "Action Late Location Motion Object Place Stand",
    "engine": "Engine",
    "episode": "Entity Episode Event Repair Track",
    "errors": "EARLIER_TASKS CramliteError NoSolution PluginError Unresolvable UserError nearest",
    "experts": "Expert Inputs Judged",
    "geometry": "Pose",
    "goals": "Goal",
    "interpretation": "Interpretation",
    "plan": "Plan",
    "plugin_types": "Backend Candidate ModelMaker ReportSection Simulator Validator",
    "program": "CompliantSlide Drive ForceExtract ForceInsert ForceMove Monitor MoveJoints MoveLinear MoveUntilContact Parallel"
    " Program Repeat SetGripper SetPayload SpiralSearch Step TryInOrder Wait ZeroSensor",
    "robot_code": "Code",
    "robots": "Gripper Platform Robot",
    "rollout": "Message Rollout Touch",
    "scenario": "Scenario read_scenario",
    "solution": "Solution",
    "tasks": "Decomposition Parameter Role TaskType",
    "trace": "Trace",
    "value": "Value replace",
    "verdict": "Finding Verdict",
    "view": "Intrinsics View",
    "world": "Feature Geom Physics RobotMount Thing World",
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names.split()}

__all__ = [
    "EARLIER_TASKS",
    "Action",
    "Answers",
    "Backend",
    "Belief",
    "Budget",
    "Candidate",
    "Code",
    "CompliantSlide",
    "Context",
    "CramliteError",
    "Decomposition",
    "Drive",
    "Engine",
    "Entity",
    "Episode",
    "Estimate",
    "Event",
    "Expert",
    "Feature",
    "Finding",
    "ForceExtract",
    "ForceInsert",
    "ForceMove",
    "Geom",
    "Goal",
    "Gripper",
    "Grounding",
    "Held",
    "Inputs",
    "Interpretation",
    "Intrinsics",
    "Judged",
    "Late",
    "Location",
    "Message",
    "ModelMaker",
    "Monitor",
    "Motion",
    "MoveJoints",
    "MoveLinear",
    "MoveUntilContact",
    "NoSolution",
    "Object",
    "Parallel",
    "Parameter",
    "Physics",
    "Place",
    "Plan",
    "Platform",
    "PluginError",
    "Pose",
    "Program",
    "Refused",
    "Repair",
    "Repeat",
    "ReportSection",
    "Robot",
    "RobotMount",
    "Role",
    "Rollout",
    "Scenario",
    "SetGripper",
    "SetPayload",
    "Simulator",
    "Solution",
    "SpiralSearch",
    "Stand",
    "Step",
    "TaskType",
    "Thing",
    "Touch",
    "Trace",
    "Track",
    "TryInOrder",
    "Unresolvable",
    "UserError",
    "Validator",
    "Value",
    "Verdict",
    "View",
    "Wait",
    "World",
    "ZeroSensor",
    "hookimpl",
    "initial_belief",
    "nearest",
    "read_scenario",
    "replace",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'cramlite' has no attribute '{name}'")
    found = globals()[name] = getattr(importlib.import_module(f".{_HOME_OF[name]}", __name__), name)
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME_OF])
