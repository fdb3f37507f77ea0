"""The typed program as JSON: the program text for robots whose native language no backend here writes.

What is written is what runs: the controller model reads this text and nothing else (``simulation.program_machine``).
No robot takes it as it is; a driver for one performs the same steps.
"""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Program, Robot
from cramlite.plugin import Backend, Code, UserError, hookimpl


class TypedJson:
    """Programs as JSON, for an arm of any make."""

    name = "typed_json"
    executable = True

    def emit(self, program: Program, robot: Robot) -> Code:
        """Write the program as JSON; ``origins`` map the line of each step to the designator that the step grounds.

        Raises:
            UserError: the program is for another robot.
        """
        from cramlite.model import typed_code

        if program.robot_type != robot.type:
            raise UserError(f"a program for '{program.robot_type}' is not one for '{robot.type}'")
        return typed_code(program)


@hookimpl
def backends() -> Iterable[Backend]:
    """Declare the JSON backend."""
    return [TypedJson()]
