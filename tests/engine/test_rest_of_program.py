"""The rest of a stopped program: what it begins with, which tasks and handovers are left, how near to new things it may pass."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.short_runs import good
from helpers.watched_runs import proof, readings
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine
from cramlite.engine.recovery.expectation import RunWatch
from cramlite.engine.recovery.rest_of_program import ROOM, _boxes, _passed, may_be_finished, rest_of
from cramlite.engine.setting import Setting
from cramlite.model import Action, Deviation, Geom, MoveJoints, Notice, Pose, Thing
from cramlite.model.handover import Handover
from cramlite.model.program.program import Section
from cramlite.model.program.steps import ForceInsert, MoveLinear, MoveUntilContact, SetGripper, ZeroSensor
from cramlite.model.world.world import InHand
from cramlite.plugin import Candidate

PATH = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


@given(st.integers(1, 3), st.floats(0.1, 0.9))
def test_via_points_that_were_passed_are_left_out(line: int, share: float) -> None:
    start, end = PATH[line - 1], PATH[line]
    here = tuple(a + share * (b - a) for a, b in zip(start, end, strict=True))
    assert _passed(PATH, here) == line


def test_before_the_first_line_no_via_point_is_passed() -> None:
    assert _passed(PATH, (-0.5, 0.3)) == 0 and _passed(PATH[:1], (-0.5, 0.3)) == 0


def test_what_came_is_larger_on_each_side() -> None:
    thing = Thing("can", "soma:DesignedArtifact", Pose(), (Geom("cylinder", (0.03, 0.05)),))
    (box,) = _boxes(thing)
    assert box.half_extents == pytest.approx((0.03 + ROOM, 0.03 + ROOM, 0.05 + ROOM))
    lying = replace(thing, pose=Pose.from_rotvec((0.5, 0.0, 0.03), (1.5708, 0.0, 0.0)))
    (box,) = _boxes(lying)
    assert (lying.pose * box.pose).position == pytest.approx((0.5, 0.0, 0.03 + ROOM), abs=1e-5)


@pytest.mark.parametrize(
    ("deviation", "block", "may"),
    [
        (Deviation.STOPPED, 0.5, True), (Deviation.ADDED, 0.5, True), (Deviation.ADDED, 0.53, False),
        (Deviation.CONTACT, 0.5, False), (Deviation.STUCK, 0.5, False), (Deviation.GOAL_CHANGED, 0.5, False),
    ],
)  # fmt: skip
def test_a_program_is_finished_only_where_nothing_moved_and_its_stop_is_explained(deviation: Deviation, block: float, may: bool) -> None:
    watch = RunWatch(proof())
    watch.see(readings(0.0))
    watch.rest(readings(0.04, block=Pose((block, 0.0, 0.05))))
    assert may_be_finished(Notice(deviation, 0.04, "", ""), watch) is may


@pytest.fixture
def stopped() -> tuple[Candidate, Setting]:
    """A candidate of four steps in two tasks, with the setting of its believed world."""
    base = good()
    at = tuple(base.program.start)
    steps = (
        MoveJoints((at,), 1.0, 1.0, origin="1.Grasping/transfer"),
        SetGripper(0.02, 0.1, 40.0, "object", origin="1.Grasping/close"),
        MoveUntilContact((0.0, 0.0, -1.0), 0.01, 5.0, 0.05, 5.0, origin="2.Placing/lower"),
        SetGripper(0.08, 0.1, 40.0, origin="2.Placing/open"),
        ForceInsert(Pose(), 5.0, 0.01, 0.01, 20.0, 5.0, origin="3.Inserting/push"),
    )
    sections = (Section("1.Grasping", "", 0, 2), Section("2.Placing", "", 2, 4), Section("3.Inserting", "", 4, 5))
    program = replace(base.program, steps=steps, sections=sections)
    handovers = (Handover("cup", "1.Grasping/close", True), Handover("cup", "2.Placing/open", False))
    actions = tuple(Action(name, "soma:Placing") for name in ("1.Grasping", "2.Placing", "3.Inserting"))
    engine = Engine()
    setting = Setting("s", base.world, (), base.robot, engine.knowledge.backends[base.robot.backend], 0)
    return replace(base, program=program, actions=actions, handovers=handovers), setting


def begun(found: Candidate | None) -> list[Any]:
    assert found is not None
    return [type(s) for s in found.program.steps]


def test_the_step_under_way_is_finished_and_later_tasks_are_judged(stopped: tuple[Candidate, Setting]) -> None:
    candidate, setting = stopped
    found = rest_of(candidate, "1.Grasping/transfer", setting)
    assert begun(found) == [MoveJoints, SetGripper, MoveUntilContact, SetGripper, ForceInsert]
    assert found is not None and [a.name for a in found.actions] == ["2.Placing", "3.Inserting"]
    assert [(s.first, s.last) for s in found.program.sections] == [(0, 2), (2, 4), (4, 5)]
    assert found.handovers == candidate.handovers


def test_a_guarded_motion_begins_again_with_a_tared_sensor_and_the_payload_in_the_hand(stopped: tuple[Candidate, Setting]) -> None:
    candidate, setting = stopped
    mount, thing = setting.world.robots[0], next(t.name for t in setting.world.things if t.movable)
    holding = replace(setting, world=replace(setting.world, robots=(replace(mount, holds=InHand(thing, Pose(), 40.0)),)))
    found = rest_of(candidate, "2.Placing/lower", holding)
    assert begun(found) == [ZeroSensor, MoveUntilContact, SetGripper, ForceInsert]
    assert found is not None and [(s.task, s.first, s.last) for s in found.program.sections] == [("2.Placing", 0, 3), ("3.Inserting", 3, 4)]
    assert found.handovers == (Handover(thing, "", True), Handover("cup", "2.Placing/open", False))


@pytest.mark.parametrize("origin", ["3.Inserting/push", "4.Nowhere", ""])
def test_of_a_force_controlled_motion_there_is_no_rest(origin: str, stopped: tuple[Candidate, Setting]) -> None:
    assert rest_of(stopped[0], origin, stopped[1]) is None


def test_two_steps_of_one_origin_are_not_told_apart(stopped: tuple[Candidate, Setting]) -> None:
    candidate, setting = stopped
    line = MoveLinear(Pose(), 0.1, 0.1, origin="1.Grasping/transfer")
    twice = replace(candidate, program=replace(candidate.program, steps=(line, *candidate.program.steps)))
    assert rest_of(twice, "1.Grasping/transfer", setting) is None
