"""What explains a grip: the handover whose code runs where it begins, the one where it ends, and what comes in between."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from helpers.short_runs import COUNT, HANDOVERS, LEFT, OPENED, ORIGINS, RIGHT, TAKEN, candidate, good, touching
from msgspec.structs import replace

from cramlite.model import Handover, Object, Touch, Wait
from cramlite.plugin import Allowance, Candidate
from cramlite_plugins.validators.explained import ExplainedGrip, explained_at, explained_grips

HELD = [""] * TAKEN + ["block"] * (OPENED - TAKEN) + [""] * (COUNT - OPENED)


def pinched(thing: str, first: int, end: int) -> Candidate:
    return touching(range(first, end), Touch(LEFT, thing, 20.0, 1.0), Touch(thing, RIGHT, 20.0, -1.0))


def only_grip(of: Candidate) -> ExplainedGrip:
    (found,) = explained_grips(of)
    return found


def running(code: Mapping[str, range], of: Candidate) -> Candidate:
    """The candidate, each of whose origins runs at some samples."""
    lines, number = np.zeros(COUNT), {origin: k for k, origin in ORIGINS.items()}
    for origin, rows in code.items():
        lines[rows.start : rows.stop] = number[origin]
    assert of.rollout is not None
    return replace(of, rollout=replace(of.rollout, lines=lines))


def test_what_is_in_the_hand_is_told_of_each_sample() -> None:
    assert explained_at(good()) == HELD
    assert explained_at(pinched("cup", 88, 95)) == HELD  # nobody takes the cup
    elsewhere = (HANDOVERS[0], replace(HANDOVERS[1], by="4.ParkingArms/move"))
    unfinished = replace(good(), handovers=elsewhere)
    assert explained_at(unfinished) == HELD and only_grip(unfinished).wrong  # it was taken as the plan says
    assert explained_at(replace(good(), handovers=(HANDOVERS[1],))) == [""] * COUNT


@pytest.mark.parametrize(("rows", "found"), [((19, 22), True), ((21, 24), False), ((5, 8), True), ((3, 6), False)])
def test_a_grip_begins_about_the_code_that_takes_it(rows: tuple[int, int], found: bool) -> None:
    code = {"1.Grasping/close": range(*rows), "2.PickingUp/lift": range(rows[1], 65), "3.Placing/Releasing/open": range(70, 80)}
    grip = only_grip(running({"2.PickingUp/lift": range(rows[0]), **code}, good()))
    assert (grip.wrong == "") is found is grip.taken and grip.at == TAKEN


@pytest.mark.parametrize(("rows", "found"), [((72, 80), True), ((75, 80), False), ((55, 61), True), ((55, 59), False)])
def test_a_grip_ends_about_the_code_that_lets_go_of_it(rows: tuple[int, int], found: bool) -> None:
    code = {"1.Grasping/close": range(2, 25), "2.PickingUp/lift": range(25, 99), "3.Placing/Releasing/open": range(*rows)}
    grip = only_grip(running(code, good()))
    assert (grip.wrong == "") is found and grip.taken
    assert (grip.at, grip.left) == ((TAKEN, HANDOVERS[1]) if found else (OPENED - 1, None))


def test_what_the_plan_keeps_may_be_in_the_hand_at_the_end() -> None:
    base = good().rollout
    assert base is not None
    pads = (Touch(LEFT, "block", 50.0, 1.0), Touch("block", RIGHT, 50.0, -1.0))
    rows = tuple(r if k < OPENED else (*r, *pads) for k, r in enumerate(base.touches))
    kept = candidate(replace(base, touches=rows, opening=np.where(np.arange(COUNT) < TAKEN, 0.085, 0.06)))
    taken = Handover("cup", "9.Other", taken=True)
    for handovers, explained in (((HANDOVERS[0],), True), ((HANDOVERS[0], taken), True), (HANDOVERS, False), ((*HANDOVERS, taken), False)):
        grip = only_grip(replace(kept, handovers=handovers))
        assert grip.grip.last == COUNT - 1 and (grip.wrong == "") is explained
    short = replace(good(), handovers=(HANDOVERS[0],))
    assert only_grip(short).wrong == "no task of the plan lets go of it then"  # it ends before the run does


def moving(thing: str, task: str, of: Candidate) -> Candidate:
    return replace(of, allowances={**of.allowances, task: Allowance(moves=frozenset({thing}))})


def test_who_says_that_it_moves_a_thing_may_press_it_with_both_pads() -> None:
    pushed = moving("cup", "4.ParkingArms", pinched("cup", 82, 88))
    wrong = [g.wrong for g in explained_grips(pushed)]
    assert wrong == ["", ""] and explained_at(pushed)[82:88] == ["cup"] * 6
    for first, end in ((76, 88), (82, 96)):  # not all the while: before, another task runs
        half = moving("cup", "4.ParkingArms", pinched("cup", first, end))
        assert [g.wrong == "" for g in explained_grips(half)] == [True, first == 82]
    declared = replace(pushed, handovers=(*HANDOVERS, Handover("cup", "4.ParkingArms/other", taken=True)))
    assert [g.wrong for g in explained_grips(declared)] == ["", "no task of the plan takes it then"]
    others = replace(pushed, handovers=(*HANDOVERS, Handover("cup", "9.Other/other", taken=True)))
    assert [g.wrong for g in explained_grips(others)] == ["", ""]


@pytest.mark.parametrize(("end", "explained"), [(79, True), (80, True), (81, False)])
def test_who_says_that_it_moves_a_thing_presses_it_to_its_last_sample_at_most(end: int, explained: bool) -> None:
    """The fingers open at samples 70 to 79."""
    found = explained_grips(moving("cup", "3.Placing/Releasing", pinched("cup", 73, end)))
    assert [g.wrong == "" for g in found] == [True, explained]


def test_a_task_that_hands_one_thing_over_takes_no_other_that_its_roles_name() -> None:
    other = pinched("cup", 52, 60)
    base = other.rollout
    assert base is not None
    free = tuple(tuple(t for t in row if "block" not in (t.a, t.b)) for row in base.touches)
    taken = replace(other, rollout=replace(base, touches=free))
    roles = {"Locatum": Object("it", entity="cup")}
    about = tuple(replace(a, roles=roles) if a.name == "3.Placing" else a for a in taken.actions)
    assert only_grip(replace(taken, actions=about)).wrong == "no task of the plan takes it then"
    silent = replace(taken, actions=about, handovers=())
    assert only_grip(silent).wrong == ""


def test_where_no_task_runs_none_takes_anything() -> None:
    for handovers in (HANDOVERS, ()):
        early = replace(running({"2.PickingUp/lift": range(90, 95)}, pinched("cup", 75, 85)), handovers=handovers)
        assert [g.wrong for g in explained_grips(early) if g.grip.thing == "cup"] == ["no task of the plan takes it then"]


def test_without_handovers_roles_say_who_takes_what() -> None:
    unknown = replace(good(), handovers=None)
    assert only_grip(unknown) == ExplainedGrip(only_grip(good()).grip, "", TAKEN, None)
    assert [(g.wrong, g.taken) for g in explained_grips(replace(pinched("cup", 82, 88), handovers=None))] == [
        ("", True), ("no task that runs then is about it", False)
    ]  # fmt: skip


def test_code_that_comes_after_the_release_is_after_it() -> None:
    steps = tuple(Wait(0.1, origin=o) for o in ORIGINS.values())
    planned = replace(good(), program=replace(good().program, steps=steps))
    for first, wrong in ((60, True), (66, False), (TAKEN, True)):  # in the last fifth of a second fingers open
        code = {"1.Grasping/close": range(2, 12), "2.PickingUp/lift": range(12, first), "4.ParkingArms/move": range(first, 70)}
        late = only_grip(running({**code, "3.Placing/Releasing/open": range(70, 80)}, planned))
        assert (late.wrong != "") is wrong and (not wrong or late.at == first)
        assert not wrong or "3.Placing/Releasing/open lets go of it, but it is still in the hand during 4.ParkingArms/move" in late.wrong
    unknown = replace(planned, program=replace(planned.program, steps=steps[:3] + steps[4:]))
    assert only_grip(unknown).wrong == ""


def test_fingers_may_take_their_time_to_open() -> None:
    steps = tuple(Wait(0.1, origin=o) for o in ORIGINS.values())
    planned = replace(good(), program=replace(good().program, steps=steps))
    slow = {"1.Grasping/close": range(2, 12), "2.PickingUp/lift": range(12, 60), "3.Placing/Releasing/open": range(60, 80)}
    assert only_grip(running(slow, planned)).wrong == ""


def test_code_of_no_step_comes_behind_none() -> None:
    """The release may be the program's first step, where the hand held the thing from the start."""
    alone = replace(good().program, steps=(Wait(0.1, origin="3.Placing/Releasing/open"),))
    assert only_grip(replace(good(), program=alone)).wrong == ""
