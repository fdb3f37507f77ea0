"""Force-controlled sliding and extraction as text: they get there, and what goes wrong is said in the log."""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers.short_programs import CLOSED, FINGERTIP, GUARDED, down, go, run
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    ForceExtract,
    MoveLinear,
    Pose,
    RobotMount,
    Rollout,
    SetGripper,
    Thing,
    World,
    ZeroSensor,
)
from cramlite_plugins.objects.products_and_fixtures import block, table

TOP, X = 0.10, 0.45  # of a board: its height, and where sliding begins [m]
FLOOR = table("floor", Pose((0.4, 0, -0.001)))
START = down(X, 0.0, TOP + FINGERTIP + 0.01)
TOUCH = replace(GUARDED, speed=0.01)
DOWNWARDS = Pose.from_axes((0, 0, 0), (0, 0, -1), (1, 0, 0))


def board(end: float) -> Thing:
    """A board under the way, that ends at an x [m]."""
    return table("board", Pose(((0.3 + end) / 2, 0.0, TOP)), size=(end - 0.3, 0.3, 0.02))


def world(*things: Thing) -> World:
    return World((FLOOR, *things), (RobotMount("arm", "ur5e"),))


def slide(to: float, **changes: object) -> CompliantSlide:
    step = CompliantSlide(
        waypoints=(down(to, 0.0, TOP + FINGERTIP),), frame=DOWNWARDS, force=4.0, speed=0.03, lost=0.5, force_limit=20.0,
        timeout=15.0, origin="slide",
    )  # fmt: skip
    return replace(step, **changes)  # type: ignore[arg-type]


def slid(step: AnyStep, *things: Thing) -> Rollout:
    return run(CLOSED, go(START), ZeroSensor(), TOUCH, step, world=world(*things), settle=0.0)


def test_a_slide_presses_all_the_way() -> None:
    rollout = slid(slide(X + 0.08), board(0.65))
    assert (rollout.outcome, rollout.reason) == ("finished", "")
    assert abs(rollout.poses["effector"][-1, 0] - (X + 0.08)) < 0.003
    sliding = rollout.poses["effector"][:, 0] > X + 0.02
    pressed = -rollout.wrench[sliding, 2]  # at its largest since the last sample: the contact of steel on steel rattles
    assert 2.0 < np.median(pressed) < 9.0
    assert np.count_nonzero(pressed < 0.5) < 0.05 * pressed.size
    assert np.linalg.norm(rollout.wrench[sliding, :3], axis=1).max() < 18.0


def test_a_slide_follows_a_board_that_is_lower_than_planned() -> None:
    waypoint = down(X + 0.08, 0.0, TOP + FINGERTIP + 0.004)  # 4 mm into the air
    rollout = slid(slide(0.0, waypoints=(waypoint,)), board(0.65))
    assert rollout.outcome == "finished"
    assert rollout.poses["effector"][-1, 2] < TOP + FINGERTIP + 0.002


def test_where_the_board_ends_the_slide_is_given_up() -> None:
    rollout = slid(slide(X + 0.12), board(X + 0.05))
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"slide: no contact for 0\.5\d* s", rollout.reason)


def test_what_is_stuck_exceeds_the_force_limit() -> None:
    wall = table("wall", Pose((X + 0.07, 0.0, TOP + 0.05)), size=(0.02, 0.2, 0.05))
    rollout = slid(slide(X + 0.12), board(0.65), wall)
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"slide: force 2\d\.\d+ N > 20\.?0* N", rollout.reason)


def test_a_slide_has_a_time_limit() -> None:
    rollout = slid(slide(X + 0.08, timeout=1.0), board(0.65))
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"slide: not done within 1\.?0* s", rollout.reason)


# Extraction: what is gripped is free, or a post that is fixed to the ground

GRIP = down(0.5, 0.1, 0.10)
HOLD = SetGripper(opening=0.0, speed=0.1, force=50, expect="object", origin="hold")
WIDE = SetGripper(opening=0.085, speed=0.15, force=50, origin="open")
UPWARDS = Pose.from_axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
PULL = ForceExtract(
    frame=UPWARDS, force=8.0, across=(0.0, 0.0), way=0.06, speed=0.04, force_limit=25.0, timeout=6.0, origin="pull"
)
POST = table("post", Pose((0.5, 0.1, 0.12)), size=(0.04, 0.04, 0.12))
FREE = block("free", Pose((0.5, 0.1, 0.062)), size=(0.04, 0.04, 0.12), mass=0.1)


def pulled(thing: Thing, step: AnyStep = PULL) -> Rollout:
    above = Pose((0, 0, 0.08)) * GRIP
    down_ = MoveLinear(target=GRIP, speed=0.1, acceleration=0.5)
    return run(WIDE, go(above), down_, HOLD, ZeroSensor(), step, world=world(thing), settle=0.0)


def test_what_is_free_is_pulled_out() -> None:
    rollout = pulled(FREE)
    assert rollout.outcome == "finished"
    assert any(re.fullmatch(r"pull: out after [\d.]+ s", m.text) for m in rollout.messages)
    assert rollout.poses["free"][-1, 2] - rollout.poses["free"][0, 2] > 0.05


def test_what_is_stuck_is_pulled_no_harder_than_asked_and_given_up() -> None:
    rollout = pulled(POST)
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"pull: only [-\d.e]+ m out within 6\.?0* s", rollout.reason)
    assert np.linalg.norm(rollout.wrench[:, :3], axis=1).max() < 14.0
    assert np.ptp(rollout.poses["effector"][-200:, 2]) < 0.003


def test_a_motion_would_have_pulled_until_something_gives() -> None:
    rollout = pulled(POST, MoveLinear(target=Pose((0, 0, 0.06)) * GRIP, speed=0.04, acceleration=0.5))
    assert np.linalg.norm(rollout.wrench[:, :3], axis=1).max() > 30.0


@pytest.mark.parametrize("limit", [5.0])
def test_an_extraction_has_a_force_limit(limit: float) -> None:
    rollout = pulled(POST, replace(PULL, force_limit=limit))
    assert rollout.outcome == "halted"
    assert re.fullmatch(r"pull: force 5\.\d+ N > 5\.?0* N", rollout.reason)
