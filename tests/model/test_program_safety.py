"""The static safety check: a sound program passes, and each rule refuses what breaks it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from cramlite.cli.main import main
from cramlite.model import (
    AnyStep,
    Fallback,
    ForceInsert,
    ForceMove,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Repeat,
    SetGripper,
    SetPayload,
    Wait,
    violations,
    write_program,
)
from cramlite_plugins.kinematics.kinematics import forward
from cramlite_plugins.robots.ur5e import UR5E

PLACE = forward(UR5E, UR5E.home)
MOVE = MoveJoints((tuple(q + 0.1 for q in UR5E.home),), 1.0, 1.4, origin="1.A/move")
LINE = MoveLinear(PLACE, 0.1, 0.5, UR5E.home, origin="1.A/line")
FEEL = MoveUntilContact((0, 0, -1), 0.01, 3.0, 0.05, 10.0, origin="1.A/feel")
PUSH = ForceInsert(PLACE, 8.0, 0.07, 0.02, 25.0, 11.0, origin="1.A/push")
PULL = ForceMove((PLACE,), PLACE, (True,) + (False,) * 5, (5.0,) + (0.0,) * 5, (0.02,) * 6, 0.02, 30.0, 9.0, origin="1.A/pull")
GRIP = SetGripper(0.0, 0.1, 50.0, "object", origin="1.A/grip")
SOUND: tuple[AnyStep, ...] = (MOVE, LINE, FEEL, PUSH, PULL, GRIP, SetPayload(1.2, (0, 0, 0.1)), Repeat((Wait(1.0),), 2))


def program(*steps: AnyStep, **changes: Any) -> Program:
    made = Program("p", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, steps, (), mass=0.925)
    return replace(made, **changes)


def test_a_sound_program_passes() -> None:
    assert list(violations(program(*SOUND), UR5E)) == []


@pytest.mark.parametrize(
    ("steps", "changes", "rule", "said"),
    [
        ((), {"start": (7.0, *UR5E.home[1:])}, "start", "the start posture has shoulder_pan at 7.000 rad, outside"),
        ((), {"start": UR5E.home[:5]}, "start", "has 5 joints, the arm 6"),
        ((), {"force_limit": 500.0}, "start", "500 N is not in 0 .. 150 N"),
        ((), {"mass": 9.0}, "payload", "payload 9.000 kg is outside 0 .. 5 kg of 'ur5e'"),
        ((replace(MOVE, path=((0.0, 0.0, 0.0, 0.0, 0.0, 9.0),)),), {}, "joint limits", "wrist_3 at 9.000 rad"),
        ((replace(MOVE, speed=4.0),), {}, "joint speeds", "wrist_3 at 4.00 rad/s > 3.14 rad/s"),
        ((replace(MOVE, acceleration=0.0),), {}, "speed", "acceleration 0 is not positive"),
        ((replace(LINE, speed=2.0),), {}, "speed", "TCP speed 2 m/s > 1.5 m/s"),
        ((replace(FEEL, speed=0.3, timeout=1.0),), {}, "speed", "0.3 m/s > 0.25 m/s while feeling"),
        ((replace(LINE, target=Pose((2.0, 0.0, 0.3))),), {}, "workspace", "2.02 m from the base, farther than 1.17 m"),
        ((replace(PUSH, force_limit=80.0),), {}, "forces", "limit of 80 N is not in 0 .. 60 N, the program's"),
        ((replace(PUSH, force=30.0),), {}, "forces", "presses with 30 N, which is not below its force limit of 25 N"),
        ((replace(FEEL, force=70.0),), {}, "forces", "presses with 70 N"),
        ((SetPayload(6.0, (0, 0, 0.1)),), {}, "payload", "payload 6.000 kg"),
        ((replace(FEEL, timeout=0.0),), {}, "time-outs", "timeout 0 s is not in 0 .. 600 s"),
        ((replace(GRIP, timeout=float("inf")),), {}, "time-outs", "timeout inf s"),
        ((Wait(3600.0),), {}, "time-outs", "duration 3600 s"),
        ((replace(FEEL, timeout=2.0),), {}, "time-outs", "takes 5.0 s, longer than its time-out of 2 s"),
        ((Repeat((Wait(1.0),), 5000),), {}, "time-outs", "5000 repetitions"),
        ((replace(GRIP, force=500.0),), {}, "gripper", "gripper force 500 N is outside 20 .. 235 N"),
        ((Fallback(((Wait(1.0),), ())),), {}, "paths", "a branch has no steps"),
        ((Parallel(((MOVE,), (LINE,))),), {}, "paths", "more than one branch needs the arm"),
        ((Fallback(((Wait(1.0),), (replace(LINE, speed=2.0),))),), {}, "speed", "TCP speed 2 m/s"),
    ],
)
def test_each_rule_refuses_what_breaks_it(
    steps: tuple[AnyStep, ...], changes: dict[str, Any], rule: str, said: str
) -> None:
    found = list(violations(program(*steps, **changes), UR5E))
    assert [o.rule for o in found if said in o.reason] == [rule], found


def test_check_judges_a_typed_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "program.json"
    path.write_text(write_program(program(*SOUND)))
    assert main(["check", str(path)]) == 0
    assert "8 steps, nothing stands against it" in capsys.readouterr().out
    path.write_text(write_program(program(*SOUND, replace(LINE, speed=2.0))))
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr()
    assert "program.json:" in said.out + said.err
    assert "1.A/line: speed: TCP speed 2 m/s > 1.5 m/s" in said.out + said.err
