"""API for plugins: hooks, their arguments and answers.

Everything that a plugin needs is here and in `cramlite.model`; a package for a new one is made by ``cramlite new``.
Names are imported when they are first used, so that ``import cramlite.plugin`` costs next to nothing.
"""

# ruff: noqa: I001  # names of one module stay together, each with the alias that exports it

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.lazy_names import LazyNames

if TYPE_CHECKING:
    from ..base.cache import cache_folder as cache_folder, keep_file as keep_file
    from ..base.errors import (
        CramliteError as CramliteError,
        InTheWay as InTheWay,
        ProcessGone as ProcessGone,
        Unresolvable as Unresolvable,
        UserError as UserError,
        did_you_mean as did_you_mean,
        nearest as nearest,
    )
    from ..base.guarded_files import (
        check_file as check_file,
        check_json_ld as check_json_ld,
        check_xml as check_xml,
        read_arrays as read_arrays,
    )
    from ..base.html_template import html_template as html_template
    from ..base.pulse import checkpoint as checkpoint, stop_asked as stop_asked
    from ..base.quantities import Angle as Angle, Length as Length, Mass as Mass, parse_quantity as parse_quantity
    from ..base.spec import Spec as Spec, read_value as read_value
    from ..base.yaml_file import explain_validation as explain_validation, load_yaml as load_yaml
    from ..interpretation.conditions import Atom as Atom, Compare as Compare, Not as Not, atoms as atoms
    from ..interpretation.fluents import (
        EFFECTOR as EFFECTOR,
        Bound as Bound,
        Fact as Fact,
        Fluent as Fluent,
        GoalCondition as GoalCondition,
        GoalPhrase as GoalPhrase,
        Manner as Manner,
        Pattern as Pattern,
        SymbolicWorld as SymbolicWorld,
        contents as contents,
    )
    from ..interpretation.goal_literal import GoalLiteral as GoalLiteral
    from ..interpretation.interpretation import Interpreted as Interpreted
    from ..interpretation.matching import Match as Match, measured as measured
    from ..interpretation.path_predicate import path_predicate as path_predicate, rest_predicate as rest_predicate
    from ..interpretation.turn_predicate import turn_predicate as turn_predicate
    from ..interpretation.goal_sides import SIDES as SIDES, wrong_side as wrong_side
    from ..interpretation.ranking import TaskSequence as TaskSequence
    from ..interpretation.rules import Clause as Clause, Rule as Rule
    from ..interpretation.timeline import (
        PADDING as PADDING,
        Phase as Phase,
        PhaseName as PhaseName,
        Predicate as Predicate,
        Row as Row,
        Segment as Segment,
        Timeline as Timeline,
    )
    from ..model.program.program import Code as Code
    from ..model.run.verdict import Cost as Cost, Finding as Finding
    from .allowance import HAND as HAND, HELD as HELD, Allowance as Allowance
    from .demonstration import (
        Hand as Hand,
        Performance as Performance,
        Performer as Performer,
        RecordScript as RecordScript,
        Shown as Shown,
    )
    from .expert import (
        RELATIONS as RELATIONS,
        SEGMENTS as SEGMENTS,
        UNKNOWN as UNKNOWN,
        Expert as Expert,
        Inputs as Inputs,
        Judged as Judged,
    )
    from .grounding import (
        Answer as Answer,
        Answers as Answers,
        Context as Context,
        Grounding as Grounding,
        LaterTask as LaterTask,
        Refused as Refused,
    )
    from .hookspecs import hookimpl as hookimpl
    from .location_kind import LocationKind as LocationKind
    from .motion_kind import MotionKind as MotionKind
    from .protocols import (
        Adviser as Adviser,
        Backend as Backend,
        Candidate as Candidate,
        Correcting as Correcting,
        Doubting as Doubting,
        Driver as Driver,
        EpisodeRepair as EpisodeRepair,
        Exporter as Exporter,
        GoalValidator as GoalValidator,
        ModelMaker as ModelMaker,
        Remarking as Remarking,
        ReportSection as ReportSection,
        Simulator as Simulator,
        StandIn as StandIn,
        Validator as Validator,
    )
    from .task_type import Decomposition as Decomposition, Parameter as Parameter, Role as Role, TaskType as TaskType

_NAMES = LazyNames(__name__, deprecated={"GoalJudge": ("GoalValidator", "0.1")})

if not TYPE_CHECKING:  # else any name would do
    __getattr__, __dir__ = _NAMES.load, _NAMES.known
