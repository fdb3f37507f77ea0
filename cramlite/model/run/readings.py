"""Sensor readings taken while a program runs, and notices of deviations from the program's proof."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from msgspec import field

from ...base.value import Value
from ...base.word import Word
from ..geometry import Pose, Vector3


class Readings(Value):
    """Sensor readings, pose of the tool and poses of things at one moment of a run.

    Args:
        time: since the start [s].
        line: of the program, 0 for none.
        joints: encoders, base to flange [rad].
        opening: distance between the finger pads [m].
        force: that the program feels [N].
        pressing: force that the fingers are told to press with [N]; 0 where they are not.
        tool: of the tool centre point in the world, from the encoders.
        across: direction in which the fingers close, world frame.
        poses: thing -> pose in the world, of all that can be read; None where poses are not to be had.
        goal: sentences of another goal that is asked for; () where none is any more, None where nothing changed.
    """

    time: float
    line: int
    joints: tuple[float, ...]
    opening: float
    force: float
    pressing: float
    tool: Pose
    across: Vector3
    poses: Mapping[str, Pose] | None = field(default_factory=dict)
    goal: tuple[str, ...] | None = None


class Deviation(Word):
    """Kind of a run's deviation from its proof; each is a class of the ontology."""

    NO_GRASP = "NoGrasp", "the hand closed on nothing"
    GRASP_LOST = "GraspLost", "the payload is no longer in the hand"
    SLIP = "GraspSlip", "the payload moved in the hand"
    GRIPPER = "GripperDeviation", "the fingers are not where they should be"
    MOVED = "ObjectMoved", "a thing stands elsewhere"
    FALLEN = "ObjectFallen", "a thing leans or lies"
    MISSING = "ObjectMissing", "a thing can no longer be seen"
    ADDED = "ObjectAppeared", "a thing is there that was not"
    CONTACT = "UnexpectedContact", "more is felt than should be"
    STUCK = "NoProgress", "a step takes longer than it should"
    READINGS_LOST = "ReadingsLost", "there are no readings"
    READINGS_FROZEN = "ReadingsFrozen", "the same is read again and again"
    STOPPED = "ProtectiveStop", "the controller stopped the arm"
    KILLED = "ProgramKilled", "the program ended without a word"
    REFUSED = "StepFailed", "a step of the program did not come to its end"
    GOAL_CHANGED = "GoalChanged", "another goal is asked for"
    CANCELLED = "Cancelled", "the task was cancelled"
    GOAL_MISSED = "GoalMissed", "the program ended, and its goal does not hold"


class Notice(Value):
    """Deviation that was noticed in a run.

    Args:
        kind: class of the deviation.
        time: since the program's start [s].
        reason: one clause with numbers.
        step: designator of the step under way; "" before the first.
        thing: that it is about; "" for none.
        measured, limit: what was read, and what it may be, in ``unit``; None where there are no numbers.
        unit: of both.
    """

    kind: Deviation
    time: float
    reason: str
    step: str = ""
    thing: str = ""
    measured: float | None = None
    limit: float | None = None
    unit: str = ""

    def __str__(self) -> str:
        """Return the notice as a line of text: the kind of deviation, the program's step, and the reason."""
        where = f" in {self.step}" if self.step else ""
        return f"{self.kind}{where}: {self.reason}"


class Watch(Protocol):
    """Watcher of a run: it is shown the sensor readings, and returns a notice when the arm must stop."""

    period: float
    """Time between two readings [s]."""

    def see(self, readings: Readings) -> Notice | None:
        """Return the notice that must stop the arm; None while the sensor readings are as expected."""
        ...

    def rest(self, readings: Readings) -> None:
        """Receive the last sensor readings of a run, with the arm at rest, however the run ended."""
        ...
