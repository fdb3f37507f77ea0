"""The static safety check: a sound program passes, and each rule refuses what breaks it."""

from __future__ import annotations

import math
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
from cramlite.model.program.program_safety import SLACK
from cramlite_plugins.kinematics.forward import forward
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


# Borders


ZERO, MOST_TURN, MOST_SPEED = (0.0,) * 6, UR5E.limits[0][1], UR5E.velocity[0]
FAR = UR5E.reach + math.hypot(*UR5E.gripper.tcp.position) + UR5E.dh[0][1]  # type: ignore[index]


def at(angle: float, joint: int = 0) -> tuple[float, ...]:
    return (*ZERO[:joint], angle, *ZERO[joint + 1 :])


def turned(angle: float, speed: float = 1.0) -> MoveJoints:
    return MoveJoints((at(angle),), speed, 1.4)


def waits(seconds: float) -> Wait:
    return Wait(seconds)


BORDERS: dict[str, tuple[Any, list[float], list[float]]] = {
    "joint limits": (lambda v: (turned(v),), [MOST_TURN + SLACK, -MOST_TURN - SLACK], [MOST_TURN + 2 * SLACK, -MOST_TURN - 2 * SLACK]),
    "joint speeds": (lambda v: (turned(0.5, v),), [MOST_SPEED + SLACK], [MOST_SPEED + 2 * SLACK]),
    "speed of a line": (lambda v: (replace(LINE, speed=v),), [1.5], [1.501]),
    "speed while feeling": (lambda v: (replace(PUSH, speed=v),), [0.25], [0.251]),
    "positive speeds": (lambda v: (replace(LINE, speed=v),), [1e-9], [0.0, -1.0, math.nan]),
    "workspace": (lambda v: (replace(LINE, target=Pose((v, 0.0, 0.0))),), [FAR], [math.nextafter(FAR, 9.0)]),
    "force limit of a step": (lambda v: (replace(PUSH, force=0.0, force_limit=v),), [0.5, 60 + SLACK], [0.0, -0.5, 60 + 2 * SLACK]),
    "force of a step": (lambda v: (replace(PUSH, force=v),), [24.9, -24.9], [25.0, -25.0]),
    "force up": (lambda v: (replace(PULL, wrench=(0.0, 0.0, v, 0.0, 0.0, 0.0)),), [29.9, -29.9], [30.0]),
    "moment": (lambda v: (replace(PULL, wrench=(5.0, 0.0, 0.0, v, 0.0, 0.0)),), [30.0], []),
    "payload": (lambda v: (SetPayload(v, (0, 0, 0)),), [0.0, 5.0], [-0.5, 5.001]),
    "a way until contact": (lambda v: (replace(FEEL, speed=0.25, distance=v, timeout=2.0),), [0.5], [0.51]),
    "a way without speed": (lambda v: (replace(FEEL, speed=v),), [], [0.0, -0.5]),
    "time": (lambda v: (waits(v),), [600.0, 1e-9], [0.0, 600.1]),
    "repetitions": (lambda v: (Repeat((Wait(1.0),), int(v)),), [1, 1000], [0, 1001]),
    "opening": (lambda v: (replace(GRIP, opening=v),), [-SLACK, 0.085 + SLACK], [-2 * SLACK, 0.085 + 2 * SLACK]),
    "force of the gripper": (lambda v: (replace(GRIP, force=v),), [20.0, 235.0], [19.9, 235.1]),
}


@pytest.mark.parametrize("what", BORDERS)
def test_a_rule_lets_pass_what_is_just_inside_and_nothing_beside_it(what: str) -> None:
    steps, inside, outside = BORDERS[what]
    assert [list(violations(program(*steps(v), start=ZERO), UR5E)) for v in inside] == [[]] * len(inside)
    assert all(list(violations(program(*steps(v), start=ZERO), UR5E)) for v in outside)


@pytest.mark.parametrize(("limit", "passes"), [(0.0, False), (0.5, True), (150.0, True), (150.1, False)])
def test_the_force_limit_of_a_program_is_positive_and_at_most_150_newtons(limit: float, passes: bool) -> None:
    assert (list(violations(program(force_limit=limit), UR5E)) == []) is passes


@pytest.mark.parametrize("limit", [0.0, -0.5])
def test_a_step_without_a_force_limit_is_told_so(limit: float) -> None:
    said = [v.reason for v in violations(program(replace(PUSH, force=0.0, force_limit=limit)), UR5E)]
    assert said[0] == f"its force limit of {limit:g} N is not in 0 .. 60 N, the program's (of robot 'ur5e')"


def test_a_posture_that_is_there_already_takes_no_speed() -> None:
    assert list(violations(program(turned(0.0, 9.0), start=ZERO), UR5E)) == []


def test_speeds_are_asked_from_where_the_step_before_ended() -> None:
    """The first axis is slow; once the arm is at the end of its path, the last step turns another one."""
    slow = replace(UR5E, velocity=(0.1, *UR5E.velocity[1:]))
    there, beyond = at(0.5), (0.5, 0.4, 0.0, 0.0, 0.0, 0.0)
    path = MoveJoints((at(0.2), there), 0.1, 1.4)
    for steps, passes in (((path,), True), ((path, replace(MOVE, path=(beyond,))), True), ((replace(MOVE, path=(beyond,)),), False)):
        assert (list(violations(program(*steps, start=ZERO), slow)) == []) is passes
    line = replace(LINE, joints=there)
    assert list(violations(program(line, replace(MOVE, path=(beyond,)), start=ZERO), slow)) == []


@pytest.mark.parametrize("count", [5, 7])
def test_targets_with_another_number_of_joints_are_said_and_nothing_is_asked_of_them(count: int) -> None:
    short = (0.1,) * count
    moves = program(replace(MOVE, path=(short, UR5E.home, short)), MOVE, replace(LINE, joints=short), MOVE, start=short)
    found = list(violations(moves, UR5E))
    assert {v.rule for v in found} == {"start", "joint limits"}
    assert all(f"has {count} joints, the arm 6" in v.reason for v in found) and len(found) == 4


@pytest.mark.parametrize(("far", "passes"), [(0.4, True), (0.41, False)])
def test_an_arm_of_unknown_base_may_have_one_of_forty_centimetres(far: float, passes: bool) -> None:
    unknown = replace(UR5E, dh=None)
    target = Pose((UR5E.reach + math.hypot(*UR5E.gripper.tcp.position) + far, 0.0, 0.0))
    assert (list(violations(program(replace(LINE, target=target)), unknown)) == []) is passes


def test_check_judges_a_typed_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "program.json"
    path.write_text(write_program(program(*SOUND)))
    assert main(["check", str(path)]) == 0
    assert "8 steps, no safety rule is violated" in capsys.readouterr().out
    path.write_text(write_program(program(*SOUND, replace(LINE, speed=2.0))))
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr()
    assert "program.json:" in said.out + said.err
    assert "1.A/line: speed: TCP speed 2 m/s > 1.5 m/s" in said.out + said.err
