"""Transfers and straight lines: where they may end, and why they are refused."""

from __future__ import annotations

import math
from typing import Any

import pytest
from helpers.scenes import TABLE, WALL, box, down, world
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Geom, Held, Location, Motion, MoveJoints, Place, Pose, Swing, Thing, initial_belief
from cramlite.model.run.judging_limits import JudgingLimits
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motions.free_motion import resolve_motion
from cramlite_plugins.robots.ur5e import UR5E

MOTION = Motion("1.Reaching/move", "transfer", Location("there", "on"))


BESIDE = box("beside", (0.01, 0.004, 0.004), (0.55, 0.055, 0.19))
"""Box that a finger is inside if it is wide open, and not if half open, with the tool at (0.55, 0, 0.2)."""


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


@pytest.mark.parametrize(("thing", "moved", "elsewhere"), [(WALL, False, True), (WALL, True, False), (BESIDE, False, False)])
def test_a_start_that_is_blocked_however_it_is_left_is_blamed_on_no_place(thing: Thing, moved: bool, elsewhere: bool) -> None:
    """So no other place is tried; but one is where the arm came there by an earlier choice, or narrower fingers would be free."""
    inside = inverse(UR5E, down(0.55, 0.0, 0.2))[0]
    room, pose = world(thing), down(0.5, 0.4, 0.2)
    mount = replace(room.robots[0], joints=UR5E.home if moved else inside)
    context = Context(UR5E, mount, {"there": Place(pose * Pose((0, 0, 0.05)), pose)}, None)  # type: ignore[arg-type]
    with pytest.raises(Unresolvable, match="start is blocked") as caught:
        list(resolve_motion(MOTION, initial_belief(room, "arm1", inside, 0.085), context) or ())
    assert caught.value.earlier_tasks is elsewhere


def test_what_hangs_from_the_fingers_is_led_where_no_way_keeps_it_as_it_hangs() -> None:
    """And a plate that is held upright is not."""
    plate = Thing("plate", "soma:Plate", Pose((0.9, 0.9, 0.1)), (Geom("box", (0.05, 0.05, 0.01)),))
    room, before = world(TABLE, plate), down(0.5, 0.2, 0.4) * Pose.from_rotvec((0.0, 0.0, 0.0), (0.6, 0.0, 0.0))
    context = Context(UR5E, room.robots[0], {"there": Place(before, before)}, Engine().knowledge.taxonomy)
    held = Held("plate", Pose.from_rotvec((0.0, 0.0, 0.08), (math.pi, 0.0, 0.0)), 0.01)
    start = inverse(UR5E, down(0.5, 0.2, 0.4))[0]
    belief = initial_belief(room, "arm1", start, 0.05)
    with pytest.raises(Unresolvable, match="'plate' would be tilted by 34 deg > 15 deg"):
        list(resolve_motion(MOTION, belief.grasped(held), context) or ())
    hangs = replace(held, swing=Swing(held.tcp_to_thing, held.tcp_to_thing, (0.0, 0.0, 0.0)))
    assert next(iter(resolve_motion(MOTION, belief.grasped(hangs), context) or ())).value


PUSHES, KEEPS = JudgingLimits(may_push=True), JudgingLimits(may_push=True, keep=(("lid", 0.001),))


@pytest.mark.parametrize(("mass", "gap", "limits", "free"), [
    (0.2, -0.0002, PUSHES, True), (0.2, -0.0002, JudgingLimits(), False), (0.2, -0.0002, KEEPS, False), (0.2, 0.004, PUSHES, False),
    (None, -0.0002, PUSHES, False),
])  # fmt: skip
def test_what_leans_on_the_payload_is_pushed_off_where_a_plan_may_push(
    mass: float | None, gap: float, limits: JudgingLimits, free: bool
) -> None:
    """Only what is loose, need not keep its place, and touches the payload before it moves."""
    lid = box("lid", (0.03, 0.03, 0.01), (0.7, 0.2, 0.22 + gap), mass)
    room, there = world(TABLE, box("bar", (0.15, 0.01, 0.01), (0.6, 0.2, 0.2), 0.1), lid), down(0.5, 0.2, 0.25)
    up = Motion("2.PickingUp/lift", "linear", Location("up", "lift"))
    context = Context(UR5E, room.robots[0], {"up": Place(there, there)}, Engine().knowledge.taxonomy, limits=limits)
    here = down(0.5, 0.2, 0.2)
    belief = initial_belief(room, "arm1", inverse(UR5E, here)[0], 0.02).grasped(Held("bar", here.inverse() * Pose((0.6, 0.2, 0.2)), 0.02))
    if free:
        assert next(iter(resolve_motion(up, belief, context) or ())).value
        return
    with pytest.raises(Unresolvable, match=r"'bar' is .* mm (inside|from) 'lid'"):
        list(resolve_motion(up, belief, context) or ())
