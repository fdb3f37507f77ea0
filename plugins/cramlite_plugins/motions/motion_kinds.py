"""Motion kinds: parameters with defaults and sources, end and abort conditions of each kind of motion designator.

One table for motion plugins, tests and the page docs/reference/motions.md. Abort reasons
are the words of the log, in simulation and on the robot alike, with the numbers left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from cramlite.model import ExpectedContact, ExpectedGrip, Fingers, Hang, Motion, Stage, Tilt, Word
from cramlite.plugin import MotionKind, Parameter, Unresolvable, hookimpl, nearest

W = TypeVar("W", bound=Word)
FORCE, LATE = "force # N > # N", "not done within # s"


LIMIT = Parameter("force_limit_n", 25.0, "a jammed rim reached 31 N in simulation; a free one stays below 12 N")
# Measured: how far a held box shifted in the hand over threading, 100 seeds: 1.0 mm at most (grasp_slip).
SHIFT, SHIFT_SLIDE = 0.001, 0.002

KINDS: Mapping[str, MotionKind] = {
    kind.name: kind
    for kind in (
        MotionKind(
            "transfer", "MoveJoints", "at the stand-off of the place",
            (
                Parameter("speed_rad_s", 1.05, "of the leading axis: URScript's default"),
                Parameter("acceleration_rad_s2", 1.4, "of the leading axis: URScript's default"),
            ),
        ),
        MotionKind(
            "linear", "MoveLinear", "at the place",
            (
                Parameter("speed_m_s", 0.10, "under half of URScript's default 0.25"),
                Parameter("acceleration_m_s2", 0.5, "under half of URScript's default 1.2"),
                Parameter("paced", 0.0, "a given speed is kept; 1: times the robot's `pace`, as default speeds are"),
                Parameter("free_m_s", 0.0, "no other speed for robots whose `pace` is over 1"),
            ),
            words={"stage": Stage}, other=("aside_m",),
        ),
        MotionKind(
            "force_path", "ForceMove", "at the last corner of the place's path",
            (
                Parameter("speed_m_s", 0.04, "half of what kept forces under 12 N on bent tips in simulation"),
                Parameter("press_n", 0.0, "nothing is pressed"), LIMIT,
                Parameter("paced", 0.0, "a given speed is kept; 1: times the robot's `pace`, its root at most on legs that turn"),
            ),
            (FORCE, LATE), SHIFT_SLIDE,
            other=("corner", "end"),
        ),
        MotionKind(
            "until_contact", "MoveUntilContact", "at a reaction of force_n along the way; with expect 'any' also beyond the place",
            (
                Parameter("speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
                Parameter("force_n", 3.0, "above sensor noise and the inertia of slow motion"),
                Parameter("beyond_m", 0.03, "six sigma of a 5 mm estimate"),
                Parameter("free_m_s", 0.0, "no part of the way is gone faster"),
                Parameter("paced", 0.0, "a given speed is kept where `free_m_s` is 0; 1: times the robot's `pace`"),
            ),
            ("no contact within # m", "no contact within # s"), SHIFT / 2,
            words={"expect": ExpectedContact}, other=("corner", "aside_m"),
        ),
        MotionKind(
            "spiral_search", "SpiralSearch", "when the tool gives way by advance_m, or a rim holds it",
            (
                Parameter("force_n", 3.0, "keeps contact; 0.9 N of friction at the tip does not shift the grasp"),
                Parameter("speed_m_s", 0.01, "found in simulation: the hole drops onto the tip before it has passed"),
                Parameter("radius_m", 0.0, "0: from the sizes of hole and peg, ontologies/motions.ttl"),
                Parameter("advance_m", 0.002, "the tip is in the hole: its hemisphere is 3 mm high"), LIMIT,
            ),
            ("nothing gave way within a radius of # m", "nothing gave way within # s", FORCE), SHIFT,
            other=("corner", "aside_m"),
        ),
        MotionKind(
            "force_insert", "ForceInsert", "at the depth that the place says",
            (
                Parameter("force_n", 8.0, "slides over a bent tip in simulation; a jammed rim takes 31 N"),
                Parameter("speed_m_s", 0.02, "faster compliance oscillates against a stiff peg in simulation"), LIMIT,
            ),
            ("only # m deep within # s", FORCE), SHIFT,
            other=("corner", "end"),
        ),
        MotionKind(
            "force_extract", "ForceExtract", "at the end of the place's path, measured along the peg",
            (
                Parameter("force_n", 8.0, "as for insertion"),
                Parameter("speed_m_s", 0.04, "half of what kept forces under 12 N on bent tips in simulation"), LIMIT,
            ),
            ("only # m out within # s", FORCE), SHIFT,
        ),
        MotionKind(
            "compliant_slide", "CompliantSlide", "at the last corner of the place's path",
            (
                Parameter("speed_m_s", 0.03, "below the 50 mm/s where inertia looks like contact"),
                Parameter("press_n", 3.0, "keeps contact without lifting friction above 2 N"),
                Parameter("lost_s", 0.5, "5 mm of settling at the 10 mm/s with which it follows the surface"), LIMIT,
            ),
            (FORCE, "no contact for # s", LATE), SHIFT_SLIDE,
        ),
        MotionKind(
            "gripper", "SetGripper", "at the opening, or on an object",
            (
                Parameter("force_n", 0.0, "0: from weight and friction when closing; what is outside the gripper's range is refused"),
                Parameter("most_n", 0.0, "bound of what force_n 0 asks for, as far as the gripper can; 0: none"),
                Parameter("speed_m_s", 0.10, "of the pads: mid-range of the 2F-85's 20 to 150 mm/s"),
            ),
            ("the gripper still moved after # s", "no object between the fingers", "an object stopped the fingers"),
            words={"to": Fingers, "expect": ExpectedGrip},
        ),
        MotionKind("payload", "SetPayload", "at once"),
        MotionKind("zero_sensor", "ZeroSensor", "after 0.3 s at rest, or as long as a streamed robot says"),
        MotionKind(
            "hold", "Wait", "after duration_s",
            (
                Parameter("duration_s", 1.0, "long enough for a slip of 1 mm/s to show"),
                Parameter("paced", 0.0, "a time that is said is kept; 1: shorter by the robot's pace"),
            ),
        ),
        MotionKind(
            "tilt", "MoveJoints", "at the end of the place's path, or upright again at its beginning",
            (
                Parameter("speed_rad_s", 0.5, "of the tilt: contents slide on walls faster than that"),
                Parameter("acceleration_rad_s2", 1.4, "of the leading axis: URScript's default"),
            ),
            words={"to": Tilt},
        ),
        MotionKind(
            "trace", "MoveJoints", "at the last corner of the place's path, after as many rounds as the place says",
            (
                Parameter("speed_m_s", 0.1, "as straight lines: under half of URScript's default 0.25"),
                Parameter("acceleration_rad_s2", 1.4, "of the leading axis: URScript's default"),
            ),
        ),
        MotionKind(
            "swing", "MoveLinear", "at the place, where it hangs; or at the last corner of the place's path, where it lies",
            (
                Parameter("speed_m_s", 0.05, "a plate of 0.13 m then turns at 25 mm/s in the hand; above 30 it would count as slipping"),
                Parameter("acceleration_m_s2", 0.5, "under half of URScript's default 1.2"),
            ),
            words={"to": Hang},
        ),
        MotionKind(
            "drive", "Drive", "where the platform stands at the place",
            (
                Parameter("speed_m_s", 0.5, "a little over half of an MPO-500's 0.9"),
                Parameter("acceleration_m_s2", 0.5, "a fifth of an MPO-500's 2.4: a held thing of 0.8 kg pulls with 0.4 N"),
                Parameter("speed_rad_s", 0.6, "a corner of the platform then moves at 0.36 m/s"),
                Parameter("acceleration_rad_s2", 0.6, "full speed after a second, as on a straight leg"),
            ),
        ),
        MotionKind("back", "MoveLinear", "where a control step began; only the plan language asks for it", other=("to", "after")),
    )
}  # fmt: skip


def word(motion: Motion, name: str, of: type[W], default: W | None = None) -> W:
    """Return the value of a motion's parameter as a member of an enumeration of words, or the default if the motion does not state the
    parameter.

    Raises:
        Unresolvable: it says none of the words that there are.
    """
    said = motion.parameters.get(name, default)
    if (found := next((one for one in of if one == said), None)) is None:
        raise Unresolvable(f"a motion of kind '{motion.kind}' knows no {name} '{said}'; {nearest(str(said), of)}")
    return found


def value(motion: Motion, name: str) -> float:
    """Return a parameter of a motion: its own, else the default of its kind."""
    default = next(p.default for p in KINDS[motion.kind].parameters if p.name == name)
    return float(motion.parameters.get(name, default))


@hookimpl
def motion_kinds() -> Iterable[MotionKind]:
    """Declare the kinds of motions that the motion plugins of cramlite resolve."""
    return KINDS.values()
