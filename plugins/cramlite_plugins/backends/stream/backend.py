"""Backend for robots that are commanded by actions at a fixed rate, as a plugin."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cramlite.model import Program, Robot, Rollout
from cramlite.plugin import Backend, Code, UserError, hookimpl


class Stream:
    """Backend that writes typed programs for robots that take actions at a fixed rate: joint positions, or deltas of
    the end effector."""

    name = "stream"
    executable = True
    remark = "the controller model ran the program at 125 Hz; a robot process is sent the same motions at its own rate"

    def emit(self, program: Program, robot: Robot) -> Code:
        """Write the program as the JSON text that ``run.drive`` streams to a robot process.

        Fingers that hold nothing are made to open or close while the arm is on a transfer.

        Raises:
            UserError: the program is for another robot, drives a platform or asks for poses while it runs.
        """
        from cramlite.model import typed_code

        from ..unsupported import refuse_drives
        from .on_the_way import opened_on_the_way

        if program.robot_type != robot.type:
            raise UserError(f"a program for '{program.robot_type}' is not one for '{robot.type}'")
        if program.late:
            raise UserError("the program asks for poses when it runs, and a stream of actions carries no poses")
        refuse_drives(program, "a stream of actions")
        return typed_code(opened_on_the_way(program))

    def drive(self, text: str, robot: Robot, command: Sequence[str]) -> Rollout:
        """Run a program's text on the robot of a process; see ``run.drive``."""
        from .run import drive

        return drive(text, robot, command)


@hookimpl
def backends() -> Iterable[Backend]:
    """Declare the streaming backend."""
    return [Stream()]
