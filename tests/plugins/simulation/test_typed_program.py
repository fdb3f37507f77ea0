"""The controller model runs the text of typed programs, in the same way as it runs URScript."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Fallback,
    ForceInsert,
    ForceMove,
    Geom,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Repeat,
    Robot,
    RobotMount,
    Rollout,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Thing,
    Wait,
    World,
    ZeroSensor,
    write_program,
)
from cramlite.plugin import UserError
from cramlite_plugins.backends import typed_json
from cramlite_plugins.backends.urscript import emit as urscript
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.execute import execute

ROBOTS = {r.type: r for r in (FR3, UR5E)}
BLOCK = Thing("block", "cram:Block", Pose((0.42, 0.0, 0.15)), (Geom("box", (0.1, 0.1, 0.15)),))


def world(robot: Robot, *things: Thing) -> World:
    return World(things, (RobotMount("arm", robot.type),))


def program(robot: Robot, *steps: AnyStep) -> Program:
    mass = robot.gripper.mass
    return Program(
        "test", "arm", robot.type, robot.gripper.tcp, robot.home, steps, (), mass=mass, center=(0.0, 0.0, 0.05)
    )


def run(robot: Robot, *steps: AnyStep, things: tuple[Thing, ...] = ()) -> Rollout:
    text = typed_json.TypedJson().emit(program(robot, *steps), robot).text
    return execute(text, world(robot, *things), ROBOTS, mount="arm", settle=0.2)


def over_the_block() -> tuple[AnyStep, ...]:
    """Every kind of step; the block's top is 100 mm under the tool of the UR5e at home."""
    home = forward(UR5E, UR5E.home)
    low = Pose((*home.position[:2], 0.35), home.quaternion)
    down = Pose((0, 0, 0), home.quaternion)
    return (
        MoveJoints(((UR5E.home[0] + 0.2, *UR5E.home[1:]), UR5E.home), 1.0, 1.4),
        SetGripper(0.0, 0.1, 40.0, "none", origin="shut"),
        SetPayload(UR5E.gripper.mass, (0.0, 0.0, 0.06)),
        ZeroSensor(),
        MoveLinear(low, 0.1, 0.5),
        MoveUntilContact((0.0, 0.0, -1.0), 0.01, 3.0, 0.08, 20.0, origin="touch"),
        SpiralSearch(down, 3.0, 0.001, 0.003, 0.01, 0.002, 25.0, 20.0, origin="search"),
        ForceMove(
            (low,), down, (True, True, False, False, False, False), (0.0,) * 6, (0.02, 0.02, 0.15, 0.35, 0.35, 0.35),
            0.02, 25.0, 20.0, origin="lift",
        ),
        Wait(0.2),
    )  # fmt: skip


@pytest.mark.heavy
def test_both_languages_do_the_same() -> None:
    """On a flat block the search finds nothing, so both abort there, after the same motions."""
    steps = over_the_block()
    place = world(UR5E, BLOCK)
    script = execute(urscript.emit(program(UR5E, *steps), UR5E).text, place, ROBOTS, mount="arm", settle=0.2)
    typed = run(UR5E, *steps, things=(BLOCK,))
    assert script.outcome == typed.outcome == "halted"
    assert "search: nothing gave way within a radius of 0.003" in script.reason
    assert typed.reason.startswith("search: nothing gave way within a radius of 0.003")
    said = [[m.text.split(",")[0] for m in r.messages[:-1]] for r in (script, typed)]
    assert said[0] == said[1]
    assert script.times[-1] - typed.times[-1] == pytest.approx(0.0, abs=0.5)
    assert script.joints[-1] == pytest.approx(typed.joints[-1], abs=0.01)
    peaks = [np.abs(r.wrench[:, :3]).max() for r in (script, typed)]
    assert peaks[0] == pytest.approx(peaks[1], rel=0.25)


def test_without_the_search_it_comes_to_its_end() -> None:
    steps = tuple(s for s in over_the_block() if not isinstance(s, SpiralSearch))
    done = run(UR5E, *steps, things=(BLOCK,))
    assert done.outcome == "finished"
    assert [m.text.split(",")[0] for m in done.messages] == ["touch: contact", "cramlite: finished"]
    first = min(line for line in done.lines if line)
    lasting = {first + k for k, s in enumerate(steps) if not isinstance(s, SetPayload)}  # that takes one cycle
    assert set(done.lines) == lasting | {0}


def test_what_the_text_says_is_what_happens() -> None:
    step = MoveJoints((tuple(q + 0.05 for q in FR3.home),), 1.0, 1.4)
    data = json.loads(write_program(program(FR3, step)))
    data["steps"][0]["path"][0][0] = 0.5
    edited = execute(json.dumps(data, indent=2), world(FR3), ROBOTS, mount="arm", settle=0.2)
    assert run(FR3, step).joints[-1][0] == pytest.approx(0.05, abs=2e-3)
    assert edited.joints[-1][0] == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(
    ("step", "outcome", "said"),
    [
        (MoveJoints(((0.0, -0.8, 0.0, -0.1, 0.0, 1.6, 0.8),), 1.0, 1.4), "protective stop", "'joint4' at -0.15"),
        (SetPayload(9.0, (0, 0, 0), origin="load"), "halted", "load: payload 9.000 kg is outside 0 .. 3 kg"),
        (SetGripper(0.0, 0.1, 40.0, "object", origin="close"), "halted", "close: no object between the fingers"),
        (
            MoveUntilContact((0.0, 0.0, -1.0), 0.02, 3.0, 0.03, 10.0, origin="feel"),
            "halted", "feel: no contact within 0.03 m",
        ),
        (
            ForceInsert(Pose((0, 0, 0), (0, 1, 0, 0)), 8.0, 0.2, 0.02, 25.0, 0.5, origin="push"),
            "halted", "push: only 0.01",
        ),
    ],
)  # fmt: skip
def test_a_step_that_fails_says_why(step: AnyStep, outcome: str, said: str) -> None:
    done = run(FR3, Wait(0.1), step)
    assert done.outcome == outcome, done.reason
    assert said in done.reason


FEEL = MoveUntilContact((0.0, 0.0, -1.0), 0.02, 3.0, 0.02, 10.0, origin="feel")
SHUT = SetGripper(0.0, 0.1, 40.0, "none", origin="shut")
OPEN = SetGripper(0.08, 0.1, 40.0, "none", origin="open")
AWAY = MoveJoints(((0.4, *FR3.home[1:]), FR3.home), 1.0, 1.4, origin="away")
WRONG = SetGripper(0.0, 0.1, 40.0, "object", origin="wrong")


def messages(done: Rollout) -> list[str]:
    return [m.text for m in done.messages]


def test_attempts_stop_at_the_first_success_and_fail_with_the_last() -> None:
    done = run(FR3, Fallback(((FEEL,), (SHUT,), (WRONG,)), origin="try"), OPEN)
    assert messages(done) == ["cramlite failed: try, attempt 1: feel: no contact within 0.02 m", "cramlite: finished"]
    assert done.opening.min() < 0.005  # the second attempt ran
    failed = run(FR3, Fallback(((FEEL,), (WRONG,))))
    assert failed.outcome == "halted"
    assert failed.reason == "wrong: no object between the fingers"


def test_repetition_counts_and_ends_at_a_failure() -> None:
    done = run(FR3, Repeat((SHUT, OPEN), 3))
    shut = done.opening < 0.01
    assert int(np.sum(shut[1:] & ~shut[:-1])) == 3
    assert run(FR3, Repeat((SHUT, WRONG), 3)).reason == "wrong: no object between the fingers"


def test_branches_run_at_the_same_time_and_a_failure_stops_the_others() -> None:
    together, one = run(FR3, Parallel(((AWAY,), (SHUT, OPEN)))), run(FR3, AWAY, SHUT, OPEN)
    assert together.outcome == "finished"
    assert together.times[-1] < one.times[-1] - 1.0
    failed = run(FR3, Parallel(((AWAY,), (WRONG,))))
    assert failed.reason == "wrong: no object between the fingers"
    assert failed.joints[-1][0] == pytest.approx(failed.joints[-10][0], abs=1e-3)  # at rest
    assert failed.joints[:, 0].max() < one.joints[:, 0].max()
    first = run(FR3, Parallel(((AWAY,), (Wait(0.2),)), until="first"))
    assert first.outcome == "finished"
    assert first.joints[:, 0].max() < 0.2


def test_a_monitor_stops_what_takes_too_long_or_presses_too_hard() -> None:
    late = run(FR3, Monitor((AWAY,), time=0.4, origin="watch"))
    assert late.reason.startswith("watch: not done after 0.4")
    assert run(FR3, Monitor((AWAY,), time=30.0, force=50.0, slip=0.01)).outcome == "finished"
    home = forward(UR5E, UR5E.home)
    deep = MoveLinear(Pose((*home.position[:2], 0.25), home.quaternion), 0.02, 0.25)
    hard = run(UR5E, Monitor((deep,), force=10.0, origin="press"), things=(BLOCK,))
    assert hard.reason.startswith("press: force 1")
    assert run(FR3, Monitor((SHUT,), slip=0.01, origin="held")).reason.startswith("held: the fingers closed further")


def test_the_force_limit_of_the_program_holds_over_every_step() -> None:
    home = forward(UR5E, UR5E.home)
    deep = MoveLinear(Pose((*home.position[:2], 0.25), home.quaternion), 0.02, 0.25)
    done = run(UR5E, deep, things=(BLOCK,))
    assert done.outcome == "halted"
    assert "N > 60 N" in done.reason


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"robot_type": "ur5e"}, "for a robot of type 'ur5e'; the world has a 'fr3'"),
        ({"start": FR3.home[:6]}, "start posture has 6 joints; a 'fr3' has 7"),
        ({"steps": (MoveJoints((UR5E.home,), 1.0, 1.0),)}, r"step in line 9 has 6 joints"),
        ({"steps": (MoveJoints((FR3.home,), 1.0, 0.0),)}, "line 9: MoveJoints: acceleration 0 is not positive"),
        ({"steps": (MoveJoints((FR3.home,), 1.0, 1.0, (0.1,)),)}, "line 9: MoveJoints: 1 radii for 1 points"),
        ({"steps": (Parallel(((ZeroSensor(),), (ZeroSensor(),))),)}, "line 9: Parallel: more than one branch needs the arm"),
    ],
)
def test_a_program_of_another_arm_is_refused_before_it_runs(change: dict[str, Any], said: str) -> None:
    text = write_program(replace(program(FR3), **change))
    with pytest.raises(UserError, match=said):
        execute(text, world(FR3), ROBOTS, mount="arm")


def test_a_wrong_start_is_an_abort() -> None:
    moved = replace(program(FR3, Wait(1.0)), start=(0.1, *FR3.home[1:]))
    done = execute(write_program(moved), world(FR3), ROBOTS, mount="arm", settle=0.1)
    assert done.outcome == "halted"
    assert "joint 0 is at 0.000" in done.reason
