"""Transfers: where they may end, and why they are refused."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.scenes import TABLE, WALL, down, world

from cramlite.model import Location, Motion, MoveJoints, Place, Pose, Thing, initial_belief
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.kinematics.kinematics import inverse
from cramlite_plugins.motions.free_motion import resolve_motion
from cramlite_plugins.robots.ur5e import UR5E

MOTION = Motion("1.Reaching/move", "transfer", Location("there", "on"))


def transfer(pose: Pose, *things: Thing, start: tuple[float, ...] = UR5E.home) -> list[Any]:
    """All ways to a place 50 mm below its stand-off."""
    room = world(*things)
    below = pose * Pose((0, 0, 0.05))
    context = Context(UR5E, room.robots[0], {"there": Place(below, pose)}, None)  # type: ignore[arg-type]
    answers = resolve_motion(MOTION, initial_belief(room, "arm1", start, 0.085), context)
    assert answers is not None
    return list(answers)


def refusal(pose: Pose, *things: Thing, start: tuple[float, ...] = UR5E.home) -> str:
    with pytest.raises(Unresolvable) as caught:
        transfer(pose, *things, start=start)
    return str(caught.value.reason)


def test_a_transfer_ends_at_the_stand_off() -> None:
    first = transfer(down(0.5, 0.2, 0.2), TABLE)[0]
    assert isinstance(first.value[0], MoveJoints)
    assert first.belief.joints == first.value[0].path[-1]


def test_a_goal_out_of_reach_is_explained_with_numbers() -> None:
    reason = refusal(down(1.5, 0.2, 0.2), TABLE)
    assert "0 inverse solutions" in reason
    assert "m of arm 'ur5e'" in reason


def test_a_goal_in_collision_names_what_is_there_and_how_deep() -> None:
    reason = refusal(down(0.55, 0.0, 0.2), WALL)
    assert "0 of them free" in reason
    assert "mm inside 'wall'" in reason


def test_a_way_on_that_is_blocked_says_after_how_much_of_it() -> None:
    reason = refusal(down(0.5, 0.2, 0.05), TABLE)
    assert "straight motion stops after" in reason
    assert "'table'" in reason


def test_a_start_in_collision_is_explained_with_its_depth() -> None:
    inside = inverse(UR5E, down(0.55, 0.0, 0.2))[0]
    reason = refusal(down(0.5, 0.4, 0.2), WALL, start=inside)
    assert "start is blocked" in reason
    assert "inside 'wall'" in reason
