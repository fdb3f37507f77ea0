"""API for plugins: the hooks, what each is given, and what it answers.

Everything that a plugin needs is here and in `cramlite.model`; a package for a new one is made by ``cramlite new``.
Names are imported when they are first used, so that ``import cramlite.plugin`` costs next to nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..base.lazy_names import LazyNames

if TYPE_CHECKING:
    from ..base.errors import CramliteError, InTheWay, ProcessGone, Unresolvable, UserError, did_you_mean, nearest
    from ..base.guarded_files import check_file, check_json_ld, check_xml, read_arrays
    from ..base.html_template import html_template
    from ..base.pulse import checkpoint, stop_asked
    from ..base.quantities import Angle, Length, Mass, parse_quantity
    from ..base.spec import Spec, read_value
    from ..base.yaml_file import explain_validation, load_yaml
    from ..interpretation.conditions import Compare, Not, atoms
    from ..interpretation.fluents import (
        EFFECTOR,
        Bound,
        Fact,
        Fluent,
        GoalCondition,
        GoalPhrase,
        Manner,
        Pattern,
        SymbolicWorld,
        contents,
    )
    from ..interpretation.goal_literal import GoalLiteral
    from ..interpretation.interpretation import Interpreted
    from ..interpretation.matching import Match, measured
    from ..interpretation.ranking import TaskSequence
    from ..interpretation.rules import Clause, Rule
    from ..interpretation.timeline import PADDING, Phase, PhaseName, Predicate, Row, Segment, Timeline
    from ..model.program import Code
    from ..model.verdict import Cost, Finding
    from .allowance import HAND, HELD, Allowance
    from .demonstration import Hand, Performance, Performer, RecordScript, Shown
    from .expert import RELATIONS, SEGMENTS, UNKNOWN, Expert, Inputs, Judged
    from .grounding import Answers, Context, Grounding, LaterTask, Refused
    from .hookspecs import hookimpl
    from .location_kind import LocationKind
    from .motion_kind import MotionKind
    from .protocols import (
        Backend,
        Candidate,
        Driver,
        EpisodeRepair,
        Exporter,
        ModelMaker,
        ReportSection,
        Simulator,
        Validator,
    )
    from .task_type import Decomposition, Parameter, Role, TaskType

_HOMES = {
    "..base.errors": "CramliteError InTheWay ProcessGone Unresolvable UserError did_you_mean nearest",
    "..base.guarded_files": "check_file check_json_ld check_xml read_arrays",
    "..base.html_template": "html_template",
    "..base.pulse": "checkpoint stop_asked",
    "..base.quantities": "Angle Length Mass parse_quantity",
    "..base.spec": "Spec read_value",
    "..base.yaml_file": "explain_validation load_yaml",
    "..interpretation.conditions": "Compare Not atoms",
    "..interpretation.fluents": "Bound EFFECTOR Fact Fluent GoalCondition GoalPhrase Manner Pattern SymbolicWorld"
    " contents",
    "..interpretation.goal_literal": "GoalLiteral",
    "..interpretation.interpretation": "Interpreted",
    "..interpretation.matching": "Match measured",
    "..interpretation.ranking": "TaskSequence",
    "..interpretation.rules": "Clause Rule",
    "..interpretation.timeline": "PADDING Phase PhaseName Predicate Row Segment Timeline",
    "..model.program": "Code",
    "..model.verdict": "Cost Finding",
    ".allowance": "Allowance HAND HELD",
    ".demonstration": "Hand Performance Performer RecordScript Shown",
    ".expert": "Expert Inputs Judged RELATIONS SEGMENTS UNKNOWN",
    ".grounding": "Answers Context Grounding LaterTask Refused",
    ".hookspecs": "hookimpl",
    ".location_kind": "LocationKind",
    ".motion_kind": "MotionKind",
    ".protocols": "Backend Candidate Driver EpisodeRepair Exporter ModelMaker ReportSection Simulator Validator",
    ".task_type": "Decomposition Parameter Role TaskType",
}
_NAMES = LazyNames(__name__, _HOMES)

__all__ = [
    "EFFECTOR",
    "HAND",
    "HELD",
    "PADDING",
    "RELATIONS",
    "SEGMENTS",
    "UNKNOWN",
    "Allowance",
    "Angle",
    "Answers",
    "Backend",
    "Bound",
    "Candidate",
    "Clause",
    "Code",
    "Compare",
    "Context",
    "Cost",
    "CramliteError",
    "Decomposition",
    "Driver",
    "EpisodeRepair",
    "Expert",
    "Exporter",
    "Fact",
    "Finding",
    "Fluent",
    "GoalCondition",
    "GoalLiteral",
    "GoalPhrase",
    "Grounding",
    "Hand",
    "InTheWay",
    "Inputs",
    "Interpreted",
    "Judged",
    "LaterTask",
    "Length",
    "LocationKind",
    "Manner",
    "Mass",
    "Match",
    "ModelMaker",
    "MotionKind",
    "Not",
    "Parameter",
    "Pattern",
    "Performance",
    "Performer",
    "Phase",
    "PhaseName",
    "Predicate",
    "ProcessGone",
    "RecordScript",
    "Refused",
    "ReportSection",
    "Role",
    "Row",
    "Rule",
    "Segment",
    "Shown",
    "Simulator",
    "Spec",
    "SymbolicWorld",
    "TaskSequence",
    "TaskType",
    "Timeline",
    "Unresolvable",
    "UserError",
    "Validator",
    "atoms",
    "check_file",
    "check_json_ld",
    "check_xml",
    "checkpoint",
    "contents",
    "did_you_mean",
    "explain_validation",
    "hookimpl",
    "html_template",
    "load_yaml",
    "measured",
    "nearest",
    "parse_quantity",
    "read_arrays",
    "read_value",
    "stop_asked",
]


if not TYPE_CHECKING:  # else any name would do

    def __getattr__(name: str) -> Any:
        return _NAMES.load(name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
