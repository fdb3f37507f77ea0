"""Typed robot program, and the text that a backend made of it."""

from __future__ import annotations

from typing import Literal

from ...base.value import Value
from ..designator_name import task_of
from ..geometry import Pose, Vector3
from ..robot import FORCE_LIMIT
from .steps import (
    AnyStep,
    Joints,
)


class Section(Value):
    """Section of a program: the steps of one task, from index ``first`` up to, but without, index ``last``.

    Args:
        task: the task designator's name, e.g. "3.Grasping".
        title: what it does in words, with the grounded objects.
    """

    task: str
    title: str
    first: int
    last: int


class Snapshot(Value):
    """Pose of a thing that the program relies on; the header of the program's text states it.

    Args:
        thing: name in the robot's world.
        pose: in the robot's base frame.
        source: who said so, e.g. "known from the scenario".
        age: [s] at planning.
    """

    thing: str
    pose: Pose
    source: str
    age: float = 0.0


class LatePose(Value):
    """Pose of a thing that the program asks a perception server for while it runs.

    Args:
        thing: name, as the perception server knows it.
        pose: where it was when this was planned, in the robot's base frame.
        tolerance: how far from there the program works, and is refused beyond [m, rad].
    """

    thing: str
    pose: Pose
    tolerance: tuple[float, float]


class Program(Value):
    """Typed program for one robot.

    Args:
        name: an identifier, used as the name of the code's function.
        robot: the mount's name in the world.
        robot_type: e.g. "ur5e".
        tcp: pinch point in the flange frame.
        start: joint position it must be started from [rad].
        steps, sections: in order of execution.
        snapshots: poses that were bound at plan time.
        force_limit: protective limit on the TCP force over the whole program [N].
        mass, center: the gripper's payload [kg, m in the flange frame].
        late: poses that are bound at run time.
        force_limit_of: who set the force limit, "robot" or "scenario".
    """

    name: str
    robot: str
    robot_type: str
    tcp: Pose
    start: Joints
    steps: tuple[AnyStep, ...]
    sections: tuple[Section, ...]
    snapshots: tuple[Snapshot, ...] = ()
    force_limit: float = FORCE_LIMIT
    mass: float = 0.0
    center: Vector3 = (0.0, 0.0, 0.0)
    late: tuple[LatePose, ...] = ()
    force_limit_of: Literal["robot", "scenario"] = "robot"

    @property
    def force_limit_source(self) -> str:
        """Source of the force limit in words: "of robot 'ur5e'", or "of the scenario"."""
        return "of the scenario" if self.force_limit_of == "scenario" else f"of robot '{self.robot_type}'"


class Code(Value):
    """Text of a program in a robot language.

    Args:
        language: e.g. "urscript".
        text: what a robot is given.
        origins: line (from 1) -> origin of the step it came from.
        suffix: of its file, e.g. ".script".
    """

    language: str
    text: str
    origins: dict[int, str]
    suffix: str

    def lines_of(self, first: int) -> tuple[str, ...]:
        """Return the lines of the step that begins at a line, without comments and blank lines; empty if the
        step's code was removed.

        Args:
            first: a line of ``origins``.
        """
        last = min((k for k in self.origins if k > first), default=first + 1)
        lines = (line.strip() for line in self.text.splitlines()[first - 1 : last - 1])
        return tuple(line for line in lines if line and not line.startswith("#"))

    def origin_of(self, line: int) -> str:
        """Return the origin (name of a step) of the code in a line: that of the nearest line at or above it
        with an origin.

        It is "" above the first of these.
        """
        before = [k for k in self.origins if k <= line]
        return self.origins[max(before)] if before else ""

    def task_of(self, line: int) -> str:
        """Return the task whose code a line of the text is in; "" above the first task."""
        return task_of(self.origin_of(line))
