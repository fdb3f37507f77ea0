"""Values of the domain: geometry, worlds, robots, episodes, beliefs, designators, plans, programs, verdicts.

Names are imported when they are first used, so that ``import cramlite.model`` costs next to nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..base.lazy_names import LazyNames

if TYPE_CHECKING:
    from ..base.value import Value, replace
    from ..base.word import Word
    from .belief import Belief, Estimate, Held, Relation, initial_belief
    from .collision import Collision
    from .control_flow import Compound, choose, fallback, monitor, parallel, repeat, retry, sequence, try_all
    from .designator_name import enclosing_names, is_part_of, part_name, task_of
    from .designators import Action, Designator, Late, Location, Motion, Object, Place, Stand
    from .entity_name import EntityName, thing_of
    from .episode import Entity, Episode, Event, Repair, Track
    from .error_model import ErrorModel, PoseError
    from .fault import Fault, FaultKind
    from .friction import pair_friction
    from .geometry import Floats, Pose, Vector3, quaternion_product, rotvec_quaternion
    from .handover import Handover
    from .imported_robot import ImportedRobot
    from .imported_scene import ImportedScene, StatedJoint
    from .judging_limits import JudgingLimits
    from .linkage import Linkage
    from .motion_words import ExpectedContact, ExpectedGrip, Fingers, Hang, Stage, Tilt
    from .place_facts import CarriedAlong, GripFacts, PegFit, Release
    from .plan import Plan
    from .program import Code, LatePose, Program, Section
    from .program_json import ProgramText, is_program_text, read_program, typed_code, write_program
    from .program_safety import PROGRAM_RULES, STEP_RULES, TOOL_SPEED, violations
    from .proof_doubts import ProofDoubts
    from .remedy import Remedy
    from .robot import Gripper, Platform, Robot
    from .robot_file import HandFile, RobotFile, Stated
    from .rollout import Message, Rollout, Scene, Solid, Touch
    from .run_limits import OVERSHOOT, Reached, reached
    from .run_peaks import RunPeaks, force_while_running, peaks_of
    from .run_record import RunRecord, TimeSpan
    from .sensor_errors import SensorErrors
    from .steps import (
        AnyStep,
        CompliantSlide,
        Control,
        Drive,
        Fallback,
        ForceExtract,
        ForceInsert,
        ForceMove,
        Joints,
        Monitor,
        MoveJoints,
        MoveLinear,
        MoveUntilContact,
        Parallel,
        Repeat,
        SetGripper,
        SetPayload,
        SpiralSearch,
        Step,
        Wait,
        ZeroSensor,
        branch_conflict,
        uses_arm,
        walk,
    )
    from .swing import Swing
    from .twin_drawing import Draw
    from .twin_verdict import TwinRun, TwinVerdict
    from .verdict import Cost, Finding, Verdict
    from .view import D435, Depth, Image, Intrinsics, Mask, Points, View
    from .world import (
        Camera,
        Contact,
        Disturbance,
        Feature,
        Filling,
        Geom,
        Inertia,
        Joint,
        MeshFile,
        Physics,
        RobotMount,
        Thing,
        World,
    )

_HOMES = {
    "..base.value": "Value replace",
    "..base.word": "Word",
    ".belief": "Belief Estimate Held Relation initial_belief",
    ".collision": "Collision",
    ".control_flow": "Compound choose fallback monitor parallel repeat retry sequence try_all",
    ".designators": "Action Designator Late Location Motion Object Place Stand",
    ".designator_name": "enclosing_names part_name is_part_of task_of",
    ".entity_name": "EntityName thing_of",
    ".episode": "Entity Episode Event Repair Track",
    ".error_model": "ErrorModel PoseError",
    ".friction": "pair_friction",
    ".fault": "Fault FaultKind",
    ".geometry": "Floats Pose Vector3 quaternion_product rotvec_quaternion",
    ".handover": "Handover",
    ".imported_robot": "ImportedRobot",
    ".imported_scene": "ImportedScene StatedJoint",
    ".judging_limits": "JudgingLimits",
    ".linkage": "Linkage",
    ".motion_words": "ExpectedContact ExpectedGrip Fingers Hang Stage Tilt",
    ".place_facts": "CarriedAlong GripFacts PegFit Release",
    ".plan": "Plan",
    ".program": "Code LatePose Program Section",
    ".program_json": "ProgramText is_program_text read_program typed_code write_program",
    ".program_safety": "TOOL_SPEED PROGRAM_RULES STEP_RULES violations",
    ".proof_doubts": "ProofDoubts",
    ".remedy": "Remedy",
    ".robot": "Gripper Platform Robot",
    ".robot_file": "HandFile RobotFile Stated",
    ".rollout": "Message Rollout Scene Solid Touch",
    ".run_limits": "OVERSHOOT Reached reached",
    ".run_peaks": "RunPeaks force_while_running peaks_of",
    ".run_record": "RunRecord TimeSpan",
    ".sensor_errors": "SensorErrors",
    ".steps": "AnyStep CompliantSlide Control Drive Fallback ForceExtract ForceInsert ForceMove Joints"
    " Monitor MoveJoints MoveLinear MoveUntilContact Parallel Repeat SetGripper SetPayload"
    " SpiralSearch Step Wait ZeroSensor branch_conflict uses_arm walk",
    ".swing": "Swing",
    ".twin_drawing": "Draw",
    ".twin_verdict": "TwinRun TwinVerdict",
    ".verdict": "Cost Finding Verdict",
    ".view": "D435 Depth Image Intrinsics Mask Points View",
    ".world": "Camera Contact Disturbance Feature Filling Geom Inertia Joint MeshFile Physics RobotMount Thing World",
}
_NAMES = LazyNames(__name__, _HOMES)

__all__ = [
    "D435",
    "OVERSHOOT",
    "PROGRAM_RULES",
    "STEP_RULES",
    "TOOL_SPEED",
    "Action",
    "AnyStep",
    "Belief",
    "Camera",
    "CarriedAlong",
    "Code",
    "Collision",
    "CompliantSlide",
    "Compound",
    "Contact",
    "Control",
    "Cost",
    "Depth",
    "Designator",
    "Disturbance",
    "Draw",
    "Drive",
    "Entity",
    "EntityName",
    "Episode",
    "ErrorModel",
    "Estimate",
    "Event",
    "ExpectedContact",
    "ExpectedGrip",
    "Fallback",
    "Fault",
    "FaultKind",
    "Feature",
    "Filling",
    "Finding",
    "Fingers",
    "Floats",
    "ForceExtract",
    "ForceInsert",
    "ForceMove",
    "Geom",
    "GripFacts",
    "Gripper",
    "HandFile",
    "Handover",
    "Hang",
    "Held",
    "Image",
    "ImportedRobot",
    "ImportedScene",
    "Inertia",
    "Intrinsics",
    "Joint",
    "Joints",
    "JudgingLimits",
    "Late",
    "LatePose",
    "Linkage",
    "Location",
    "Mask",
    "MeshFile",
    "Message",
    "Monitor",
    "Motion",
    "MoveJoints",
    "MoveLinear",
    "MoveUntilContact",
    "Object",
    "Parallel",
    "PegFit",
    "Physics",
    "Place",
    "Plan",
    "Platform",
    "Points",
    "Pose",
    "PoseError",
    "Program",
    "ProgramText",
    "ProofDoubts",
    "Reached",
    "Relation",
    "Release",
    "Remedy",
    "Repair",
    "Repeat",
    "Robot",
    "RobotFile",
    "RobotMount",
    "Rollout",
    "RunPeaks",
    "RunRecord",
    "Scene",
    "Section",
    "SensorErrors",
    "SetGripper",
    "SetPayload",
    "Solid",
    "SpiralSearch",
    "Stage",
    "Stand",
    "Stated",
    "StatedJoint",
    "Step",
    "Swing",
    "Thing",
    "Tilt",
    "TimeSpan",
    "Touch",
    "Track",
    "TwinRun",
    "TwinVerdict",
    "Value",
    "Vector3",
    "Verdict",
    "View",
    "Wait",
    "Word",
    "World",
    "ZeroSensor",
    "branch_conflict",
    "choose",
    "enclosing_names",
    "fallback",
    "force_while_running",
    "initial_belief",
    "is_part_of",
    "is_program_text",
    "monitor",
    "pair_friction",
    "parallel",
    "part_name",
    "peaks_of",
    "quaternion_product",
    "reached",
    "read_program",
    "repeat",
    "replace",
    "retry",
    "rotvec_quaternion",
    "sequence",
    "task_of",
    "thing_of",
    "try_all",
    "typed_code",
    "uses_arm",
    "violations",
    "walk",
    "write_program",
]


if not TYPE_CHECKING:  # else any name would do

    def __getattr__(name: str) -> Any:
        return _NAMES.load(name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
