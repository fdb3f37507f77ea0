"""Values of the domain: geometry, worlds, robots, episodes, beliefs, designators, plans, programs, verdicts.

Names are imported when they are first used, so that ``import cramlite.model`` costs next to nothing.
"""

# ruff: noqa: I001  # names of one module stay together, each with the alias that exports it

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.lazy_names import LazyNames

if TYPE_CHECKING:
    from ..base.value import Value as Value, replace as replace
    from ..base.word import Word as Word
    from .belief import (
        Belief as Belief,
        Estimate as Estimate,
        Held as Held,
        Relation as Relation,
        initial_belief as initial_belief,
    )
    from .collision import Collision as Collision
    from .control_flow import (
        Compound as Compound,
        choose as choose,
        fallback as fallback,
        monitor as monitor,
        parallel as parallel,
        repeat as repeat,
        retry as retry,
        sequence as sequence,
        try_all as try_all,
    )
    from .designator_name import (
        enclosing_names as enclosing_names,
        is_part_of as is_part_of,
        part_name as part_name,
        task_of as task_of,
    )
    from .designators import (
        Action as Action,
        Designator as Designator,
        Late as Late,
        Location as Location,
        Motion as Motion,
        Object as Object,
        Place as Place,
        Stand as Stand,
    )
    from .entity_name import EntityName as EntityName, thing_of as thing_of
    from .episode import Entity as Entity, Episode as Episode, Event as Event, Repair as Repair, Track as Track
    from .twins.error_model import ErrorModel as ErrorModel, PoseError as PoseError
    from .fault import Fault as Fault, FaultKind as FaultKind, Trigger as Trigger
    from .world.friction import pair_friction as pair_friction
    from .geometry import (
        Floats as Floats,
        Pose as Pose,
        Vector3 as Vector3,
        vector3 as vector3,
        quaternion_product as quaternion_product,
        rotations as rotations,
        rotvec_quaternion as rotvec_quaternion,
        seen_from as seen_from,
    )
    from .handover import Handover as Handover
    from .imported_robot import ImportedRobot as ImportedRobot
    from .world.imported_scene import ImportedScene as ImportedScene, StatedJoint as StatedJoint
    from .world.joint import Joint as Joint, opened as opened
    from .world.kind_joint import KindJoint as KindJoint
    from .world.known_kind import BuiltLibrary as BuiltLibrary, KnownKind as KnownKind
    from .run.judging_limits import JudgingLimits as JudgingLimits
    from .linkage import Linkage as Linkage
    from .world.colour_words import colour_words as colour_words
    from .world.looks import Looks as Looks
    from .motion_words import (
        ExpectedContact as ExpectedContact,
        ExpectedGrip as ExpectedGrip,
        Fingers as Fingers,
        Hang as Hang,
        Stage as Stage,
        Tilt as Tilt,
    )
    from .place_facts import CarriedAlong as CarriedAlong, GripFacts as GripFacts, PegFit as PegFit, Release as Release
    from .plan import Plan as Plan
    from .program.program import Code as Code, LatePose as LatePose, Program as Program, Section as Section
    from .program.program_json import (
        ProgramText as ProgramText,
        is_program_text as is_program_text,
        read_program as read_program,
        typed_code as typed_code,
        write_program as write_program,
    )
    from .program.program_safety import (
        PROGRAM_RULES as PROGRAM_RULES,
        STEP_RULES as STEP_RULES,
        TOOL_SPEED as TOOL_SPEED,
        violations as violations,
    )
    from .twins.proof_doubts import ProofDoubts as ProofDoubts
    from .remedy import Remedy as Remedy
    from .run.readings import Deviation as Deviation, Notice as Notice, Readings as Readings, Watch as Watch
    from .robot import WRIST_TURN as WRIST_TURN, Gripper as Gripper, Platform as Platform, Robot as Robot
    from .robot_file import HandFile as HandFile, RobotFile as RobotFile, Stated as Stated
    from .run.rollout import Message as Message, Rollout as Rollout, Scene as Scene, Solid as Solid, Touch as Touch
    from .run.run_limits import OVERSHOOT as OVERSHOOT, Reached as Reached, reached as reached
    from .run.run_peaks import RunPeaks as RunPeaks, force_while_running as force_while_running, peaks_of as peaks_of
    from .run.run_record import RunRecord as RunRecord, TimeSpan as TimeSpan
    from .sensor_errors import SensorErrors as SensorErrors
    from .shown_path import Anchor as Anchor, ShownPath as ShownPath, foot as foot
    from .program.steps import (
        AnyStep as AnyStep,
        CompliantSlide as CompliantSlide,
        Control as Control,
        Drive as Drive,
        Fallback as Fallback,
        ForceExtract as ForceExtract,
        ForceInsert as ForceInsert,
        ForceMove as ForceMove,
        Joints as Joints,
        Monitor as Monitor,
        MoveJoints as MoveJoints,
        MoveLinear as MoveLinear,
        MoveUntilContact as MoveUntilContact,
        Parallel as Parallel,
        Repeat as Repeat,
        SetGripper as SetGripper,
        SetPayload as SetPayload,
        SpiralSearch as SpiralSearch,
        Step as Step,
        Wait as Wait,
        ZeroSensor as ZeroSensor,
        branch_conflict as branch_conflict,
        uses_arm as uses_arm,
        walk as walk,
    )
    from .program.swing import Swing as Swing
    from .twins.twin_drawing import Draw as Draw
    from .run.twin_verdict import TwinRun as TwinRun, TwinVerdict as TwinVerdict
    from .run.verdict import Cost as Cost, Finding as Finding, Verdict as Verdict
    from .view import (
        D435 as D435,
        CameraOffset as CameraOffset,
        Depth as Depth,
        Image as Image,
        Intrinsics as Intrinsics,
        Mask as Mask,
        Points as Points,
        View as View,
    )
    from .world.thing import (
        Contact as Contact,
        Feature as Feature,
        Filling as Filling,
        Geom as Geom,
        Inertia as Inertia,
        MeshFile as MeshFile,
        Thing as Thing,
    )
    from .world.world import (
        GRAVITY as GRAVITY,
        Camera as Camera,
        Disturbance as Disturbance,
        InHand as InHand,
        Physics as Physics,
        RobotMount as RobotMount,
        World as World,
    )

_NAMES = LazyNames(__name__)

if not TYPE_CHECKING:  # else any name would do
    __getattr__, __dir__ = _NAMES.load, _NAMES.known
