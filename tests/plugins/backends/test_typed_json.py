"""The typed program as text: each line leads back to its step, and only the right robot is written for."""

from __future__ import annotations

import pytest

from cramlite.model import MoveJoints, Program, Wait, read_program
from cramlite.plugin import UserError
from cramlite_plugins.backends.typed_json import TypedJson
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E

PROGRAM = Program(
    "fetch", "arm", "fr3", FR3.gripper.tcp, FR3.home,
    (MoveJoints((FR3.home,), 1.0, 1.4, origin="1.Reaching/transfer"), Wait(0.5, origin="2.Holding/hold"), Wait(0.5)), (),
)  # fmt: skip


def test_lines_lead_back_to_steps() -> None:
    code = TypedJson().emit(PROGRAM, FR3)
    assert read_program(code.text).program == PROGRAM
    lines = code.text.split("\n")
    said = {origin: lines[line - 1] for line, origin in code.origins.items()}
    assert '"MoveJoints"' in said["1.Reaching/transfer"]
    assert '"Wait"' in said["2.Holding/hold"]
    assert code.task_of(max(code.origins) + 1) == "2.Holding"
    assert code == TypedJson().emit(PROGRAM, FR3)


def test_a_program_for_another_robot_is_refused() -> None:
    with pytest.raises(UserError, match="a program for 'fr3' is not one for 'ur5e'"):
        TypedJson().emit(PROGRAM, UR5E)
