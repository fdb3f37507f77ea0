"""Fingers that open while the arm is under way: which do, and that it takes less time."""

from __future__ import annotations

import json
import sys

import pytest
from conftest import ROOT

from cramlite.model import AnyStep, MoveJoints, Parallel, Program, SetGripper, typed_code
from cramlite.model.program.program import Section
from cramlite_plugins.backends.stream.backend import Stream
from cramlite_plugins.backends.stream.on_the_way import opened_on_the_way
from cramlite_plugins.backends.stream.run import drive
from cramlite_plugins.robots.ur5e import UR5E

GO = MoveJoints(((*UR5E.home[:5], UR5E.home[5] + 0.3),), 1.0, 2.0, origin="1.Grasping/transfer")
BACK = MoveJoints((UR5E.home,), 1.0, 2.0, origin="2.PickingUp/lift")
OPEN = SetGripper(opening=0.08, speed=0.1, force=30.0, origin="1.Grasping/open")
LET_GO = SetGripper(opening=0.08, speed=0.1, force=30.0, expect="none", origin="1.Releasing/open")
HALF = SetGripper(opening=0.04, speed=0.1, force=30.0, expect="none", origin="1.Opening/half")
NARROW = SetGripper(opening=0.03, speed=0.1, force=30.0, origin="1.Grasping/open")
CLOSE = SetGripper(opening=0.0, speed=0.1, force=30.0, expect="object", origin="1.Grasping/close")
SHUT = SetGripper(opening=0.0, speed=0.1, force=30.0, origin="1.Opening/shut")
ON_NOTHING = SetGripper(opening=0.0, speed=0.1, force=30.0, expect="none", origin="1.Grasping/shut")
OTHERS = SetGripper(opening=0.0, speed=0.1, force=30.0, expect="none", origin="2.Closing/shut")


def program(*steps: AnyStep) -> Program:
    sections = (Section("1.Grasping", "", 0, len(steps) - 1), Section("2.PickingUp", "", len(steps) - 1, len(steps)))
    return Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, steps, sections)


@pytest.mark.parametrize("before", [(), (LET_GO,), (HALF,)])
def test_empty_fingers_open_on_the_way(before: tuple[AnyStep, ...]) -> None:
    made = opened_on_the_way(program(*before, OPEN, GO, BACK))
    assert made.steps[len(before) :] == (Parallel(((OPEN,), (GO,)), origin=GO.origin, comment="; "), BACK)
    first, second = made.sections
    assert (first.first, first.last, second.first, second.last) == (0, len(before) + 1, len(before) + 1, len(before) + 2)


@pytest.mark.parametrize("narrower", [NARROW, ON_NOTHING])
def test_fingers_that_have_let_go_close_on_the_way(narrower: SetGripper) -> None:
    made = opened_on_the_way(program(LET_GO, narrower, GO, BACK))
    assert made.steps == (LET_GO, Parallel(((narrower,), (GO,)), origin=GO.origin, comment="; "), BACK)


@pytest.mark.parametrize("before", [(), (LET_GO,), (HALF,)])
def test_empty_fingers_close_on_nothing_on_the_way_there(before: tuple[AnyStep, ...]) -> None:
    made = opened_on_the_way(program(*before, GO, ON_NOTHING, BACK))
    assert made.steps[len(before) :] == (Parallel(((ON_NOTHING,), (GO,)), origin=GO.origin, comment="; "), BACK)


@pytest.mark.parametrize(
    "waited",
    [
        (GO, CLOSE), (CLOSE, GO, ON_NOTHING), (GO, SHUT), (GO, LET_GO), (GO, OTHERS), (CLOSE, ON_NOTHING, GO),
        (CLOSE, OPEN, GO), (SHUT, GO), (LET_GO, GO), (SHUT, OPEN, GO), (OPEN, CLOSE, GO), (GO, OPEN), (LET_GO, SHUT, GO),
    ],
)  # fmt: skip
def test_fingers_that_hold_let_go_or_close_are_waited_for(waited: tuple[AnyStep, ...]) -> None:
    whole = program(*waited) if waited[-1] in (OPEN, OTHERS) else program(*waited, BACK)
    assert opened_on_the_way(whole) == whole


def test_what_opens_on_the_way_takes_no_time() -> None:
    def taken(text: str) -> float:
        arm = [sys.executable, str(ROOT / "tests" / "helpers" / "perfect_arm.py"), "ur5e", json.dumps(UR5E.home), "0.03"]
        ran = drive(text, UR5E, arm)
        assert ran.outcome == "finished" and ran.opening[-1] == pytest.approx(0.08, abs=0.002)
        return float(ran.times[-1])

    whole = program(OPEN, GO, BACK)
    apart, together = taken(typed_code(whole).text), taken(Stream().emit(whole, UR5E).text)
    assert apart - together == pytest.approx(0.5, abs=0.11)  # 50 mm at 0.1 m/s
