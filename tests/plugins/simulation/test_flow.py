"""Control steps, emitted and carried out as text: order, first success, what a failure does to the others, monitors."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_programs import CLOSED, FINGERTIP, GUARDED, down, go, run, text
from msgspec import json
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Control,
    Fallback,
    Monitor,
    MoveLinear,
    Parallel,
    Pose,
    Program,
    Repeat,
    RobotMount,
    Rollout,
    SetGripper,
    SpiralSearch,
    Wait,
    World,
    ZeroSensor,
    walk,
)
from cramlite.plugin import UserError
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.ur5e import UR5E

TOP, EDGE = 0.10, 0.55  # of a board: its height, and where it ends in x [m]
WORLD = World(
    (
        table("floor", Pose((0.4, 0, -0.001))),
        table("board", Pose((EDGE - 0.1, 0.1, TOP)), size=(0.2, 0.3, 0.02)),
    ),
    (RobotMount("arm", "ur5e"),),
)
# Closed fingertips near the edge of the board: a spiral of 9 mm finds where it ends, one of 1.5 mm does not.
START = down(EDGE + 0.008, 0.1, TOP + FINGERTIP + 0.01)
HIGH = down(0.45, 0.1, 0.35)
OPEN = SetGripper(opening=0.085, speed=0.15, force=50, expect="none", origin="open")
NOTHING_HELD = SetGripper(opening=0.0, speed=0.15, force=50, expect="object", origin="hold")
ABOVE = MoveLinear(target=START, speed=0.1, acceleration=0.5, origin="above")
TOUCH = replace(GUARDED, speed=0.01)


def spiral(radius: float, origin: str) -> SpiralSearch:
    return SpiralSearch(
        frame=Pose.from_axes((0, 0, 0), (0, 0, -1), (1, 0, 0)), force=4, pitch=0.0015, radius=radius, speed=0.03,
        advance=0.002, force_limit=25, timeout=30, origin=origin,
    )  # fmt: skip


def flow(*steps: AnyStep) -> Rollout:
    return run(*steps, world=WORLD, settle=0.0)


def said(rollout: Rollout) -> str:
    return "\n".join(m.text for m in rollout.messages)


# Attempts


BEFORE = (CLOSED, go(START), ZeroSensor())
SMALL, LARGE = (TOUCH, spiral(0.0015, "small")), (ABOVE, TOUCH, spiral(0.009, "large"))


def test_a_search_with_a_larger_radius_succeeds_where_the_first_one_failed() -> None:
    rollout = flow(*BEFORE, Fallback((SMALL, LARGE), origin="search"))
    assert rollout.outcome == "finished"
    log = said(rollout)
    assert "cramlite failed: search, attempt 1: small: nothing gave way within a radius of 0.0015 m" in log
    assert "large: it gave way" in log


def test_without_the_retry_the_same_search_ends_the_program() -> None:
    rollout = flow(*BEFORE, *SMALL)
    assert rollout.outcome == "halted"
    assert rollout.reason == "small: nothing gave way within a radius of 0.0015 m"


def test_attempts_are_made_in_order_and_stop_at_the_first_success() -> None:
    tries = (*tuple((replace(NOTHING_HELD, origin=f"try {k}"),) for k in (1, 2)), (CLOSED,), (OPEN,))
    rollout = flow(Fallback(tries, origin="grip"))
    log = said(rollout)
    assert rollout.outcome == "finished"
    assert log.index("grip, attempt 1: try 1: no object") < log.index("grip, attempt 2: try 2: no object")
    assert "attempt 3" not in log
    assert rollout.opening[-1] < 0.005  # the fourth, which opens, was not made


def test_if_the_last_attempt_fails_the_program_ends_with_its_reason() -> None:
    tries = tuple((replace(NOTHING_HELD, origin=f"try {k}"),) for k in (1, 2))
    rollout = flow(Fallback(tries), OPEN)
    assert (rollout.outcome, rollout.reason) == ("halted", "try 2: no object between the fingers")
    assert rollout.opening[-1] < 0.005


def test_steps_of_an_attempt_after_its_failure_are_left_out() -> None:
    rollout = flow(Fallback(((NOTHING_HELD, go(HIGH)), (Wait(0.1),))))
    assert rollout.outcome == "finished"
    assert np.abs(rollout.joints[-1] - UR5E.home).max() < 0.01


# Repetition


def test_a_motion_is_repeated_as_often_as_asked() -> None:
    up, back = replace(ABOVE, target=Pose((0, 0, 0.03)) * START), ABOVE
    rollout = flow(go(START), Repeat((up, back), 3))
    heights = rollout.poses["effector"][:, 2]
    raised = heights > START.position[2] + 0.02
    assert rollout.outcome == "finished"
    assert np.count_nonzero(np.diff(raised[np.argmax(~raised) :].astype(int)) == 1) == 3


def test_a_failure_ends_the_repetition() -> None:
    rollout = flow(Repeat((OPEN, NOTHING_HELD), 5))
    assert (rollout.outcome, rollout.reason) == ("halted", "hold: no object between the fingers")
    assert rollout.times[-1] < 4.0


# Parallel


def moving(rollout: Rollout) -> np.ndarray:
    return np.abs(np.diff(rollout.joints, axis=0)).max(axis=1) > 1e-4


def test_the_gripper_moves_while_the_arm_moves() -> None:
    both = flow(Parallel(((go(HIGH),), (CLOSED,))))
    after = flow(go(HIGH), CLOSED)
    closing = np.abs(np.diff(both.opening)) > 1e-4
    assert both.outcome == after.outcome == "finished"
    assert np.count_nonzero(moving(both) & closing) > 20
    assert np.count_nonzero(moving(after) & (np.abs(np.diff(after.opening)) > 1e-4)) < 5
    assert both.times[-1] < after.times[-1] - 0.4
    assert both.opening[-1] < 0.005
    assert np.linalg.norm(both.poses["effector"][-1, :3] - HIGH.position) < 2e-3


def test_in_parallel_a_failure_stops_the_others() -> None:
    slow = replace(go(HIGH), speed=0.2)
    rollout = flow(Parallel(((slow,), (NOTHING_HELD,))))
    assert (rollout.outcome, rollout.reason) == ("halted", "hold: no object between the fingers")
    assert np.linalg.norm(rollout.poses["effector"][-1, :3] - HIGH.position) > 0.05


def test_of_all_tried_at_once_the_first_success_stops_the_others() -> None:
    slow = replace(go(HIGH), speed=0.2)
    rollout = flow(Parallel(((slow,), (CLOSED,)), until="first"))
    assert rollout.outcome == "finished"
    assert np.linalg.norm(rollout.poses["effector"][-1, :3] - HIGH.position) > 0.05


def test_of_all_tried_at_once_one_failure_is_no_failure() -> None:
    rollout = flow(Parallel(((go(HIGH),), (NOTHING_HELD,)), until="first"))
    assert rollout.outcome == "finished"
    assert np.linalg.norm(rollout.poses["effector"][-1, :3] - HIGH.position) < 2e-3


def test_if_all_tried_at_once_fail_the_program_ends() -> None:
    nowhere = replace(GUARDED, distance=0.01)
    rollout = flow(go(HIGH), Parallel(((nowhere,), (NOTHING_HELD,)), until="first"))
    assert rollout.outcome == "halted"


def test_two_branches_cannot_both_move_the_arm() -> None:
    with pytest.raises(UserError, match="more than one branch needs the arm"):
        text(Parallel(((go(HIGH),), (go(START),))))


# Monitors


INTO = MoveLinear(target=Pose((0, 0, -0.03)) * START, speed=0.02, acceleration=0.2, origin="into")


def test_a_force_that_is_exceeded_ends_the_program_with_its_reason() -> None:
    rollout = flow(*BEFORE, Monitor((INTO,), force=10.0, origin="careful"))
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith("careful: force 1")
    assert rollout.reason.endswith("N > 10.0 N")


def test_without_the_monitor_the_arm_presses_on_until_the_limit_of_the_program() -> None:
    rollout = flow(*BEFORE, INTO)
    assert rollout.outcome != "finished"
    assert "careful" not in rollout.reason


def test_a_monitor_that_sees_nothing_changes_nothing() -> None:
    rollout = flow(go(START), Monitor((replace(INTO, target=HIGH, speed=0.1),), force=20.0, time=10.0, slip=0.02), CLOSED)
    assert rollout.outcome == "finished"
    assert rollout.opening[-1] < 0.005


def test_what_takes_too_long_is_stopped() -> None:
    rollout = flow(Monitor((Wait(5.0),), time=0.5, origin="quick"))
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith("quick: not done after 0.5")
    assert rollout.times[-1] < 1.0


def test_fingers_that_close_further_are_a_slip() -> None:
    rollout = flow(Monitor((CLOSED, Wait(1.0)), slip=0.010, origin="firm"))
    assert rollout.outcome == "halted"
    assert "slip" in rollout.reason
    assert flow(Monitor((Wait(0.5),), slip=0.010)).outcome == "finished"


def test_a_monitor_that_trips_is_a_failure_that_an_attempt_survives() -> None:
    rollout = flow(*BEFORE, Fallback(((Monitor((INTO,), force=10.0, origin="careful"),), (ABOVE,)), origin="any"))
    assert rollout.outcome == "finished"
    assert "cramlite failed: any, attempt 1: careful: force" in said(rollout)


def test_attempts_inside_a_monitor_do_not_survive_it() -> None:
    attempts = Fallback(((Wait(5.0),), (Wait(0.1),)), origin="any")
    rollout = flow(Monitor((attempts,), time=0.5, origin="quick"))
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith("quick")
    assert "attempt 1" not in said(rollout)


# As values


NESTED = Monitor((Fallback(((Repeat((Wait(0.1),), 2),), (Parallel(((OPEN,), (Wait(0.2),))),))),), time=3.0)


def test_control_steps_are_values() -> None:
    assert [type(s).__name__ for s in walk([NESTED]) if isinstance(s, Control)] == [
        "Monitor", "Fallback", "Repeat", "Parallel",
    ]  # fmt: skip
    program = Program("p", "arm", "ur5e", Pose(), UR5E.home, (NESTED,), ())
    assert b'"count":2' in json.encode(program)
    assert text(NESTED) == text(NESTED)
    assert flow(NESTED).outcome == "finished"
