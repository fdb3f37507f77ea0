"""Guarded motions and their like: pressed no harder than the plan's force leads to, and ended in the range that the plan gives them."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from helpers.edited import against, findings, proven, run
from helpers.short_runs import COUNT, only, taxonomy, touching
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Floats,
    ForceExtract,
    ForceInsert,
    MoveLinear,
    MoveUntilContact,
    Pose,
    SpiralSearch,
    Touch,
    Wait,
)
from cramlite.plugin import Candidate
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.contact_force import IN_DOUBT, RISE, SPREAD, STOPPED, guard_forces
from cramlite_plugins.validators.physics import ForcePeak
from cramlite_plugins.validators.step_ends import wrong_end

ORIGIN, FIRST, END = "2.PickingUp/lift", 25, 50  # its samples in a short run
MET = Touch("block", "cup", 5.0, 0.0)
DOWN = Pose.from_axes((0, 0, 0), (0, 0, -1), (1, 0, 0))


def guard(force: float = 3.0, speed: float = 0.01, expect: str = "contact") -> MoveUntilContact:
    return MoveUntilContact((0.0, 0.0, -1.0), speed, force, 0.05, 9.0, expect, origin=ORIGIN)  # type: ignore[arg-type]


def felt(newtons: float, sample: int, *steps: AnyStep, met: range = range(COUNT)) -> Candidate:
    """A candidate of some steps, in whose run something is met, and so much is felt at one sample."""
    base = touching(met, MET)
    assert base.rollout is not None
    force: Floats = np.zeros(COUNT)
    force[sample] = newtons
    return replace(base, rollout=replace(base.rollout, force=force), program=replace(base.program, steps=steps))


def limit(force: float, speed: float) -> float:
    return STOPPED * (force + RISE * speed) + IN_DOUBT * 0.2 * 9.81


@pytest.mark.parametrize(("force", "speed"), [(3.0, 0.01), (1.0, 0.01), (5.0, 0.02)])
def test_a_guard_presses_no_harder_than_its_own_force_and_speed_lead_to(force: float, speed: float) -> None:
    inside, outside = (felt(limit(force, speed) + more, 40, guard(force, speed)) for more in (-0.01, 0.01))
    assert only(ForcePeak(), inside).passed
    found = only(ForcePeak(), outside)
    assert not found.passed and found.origin == "2.PickingUp" and f"of {ORIGIN}, which ends at {force:g} N" in found.reason


def test_where_no_guard_runs_or_nothing_is_met_the_task_says_how_hard() -> None:
    for sample in (FIRST - 1, FIRST + SPREAD - 1, END):
        assert only(ForcePeak(), felt(24.0, sample, guard())).passed, "before it, at its first samples, and after it"
    assert not only(ForcePeak(), felt(24.0, FIRST + SPREAD, guard())).passed
    assert not only(ForcePeak(), felt(24.0, END - 1, guard())).passed
    assert only(ForcePeak(), felt(24.0, 40, guard(), met=range(80, 81))).passed


def test_of_two_guards_of_one_name_the_harder_one_counts_and_a_harder_one_than_the_task_does_not() -> None:
    assert only(ForcePeak(), felt(limit(9.0, 0.01) - 0.01, 40, guard(), guard(9.0), guard(2.0))).passed
    base = felt(14.0, 40, guard(9.0))
    tight = replace(base.allowances["2.PickingUp"], force=12.0)
    assert only(ForcePeak(), base).passed
    assert not only(ForcePeak(), replace(base, allowances={**base.allowances, "2.PickingUp": tight})).passed
    assert guard_forces(felt(0.0, 40)) == [None] * COUNT


@pytest.mark.parametrize(("begins", "known"), [(0, 0), (1, 3), (2, 4), (30, 32)])
def test_the_first_samples_of_a_guard_are_of_the_code_before_it_unless_it_runs_first(begins: int, known: int) -> None:
    base = felt(0.0, 40, guard())
    assert base.rollout is not None
    lines = np.full(COUNT, 9.0)
    lines[begins:60] = 3.0
    guards = guard_forces(replace(base, rollout=replace(base.rollout, lines=lines)))
    assert [k for k, one in enumerate(guards) if one is not None] == list(range(known, 60))


# Where they end


@cache
def lowered(height: float) -> tuple[float, ...]:
    """Joints of the arm with its tool so far below that of its home [m]."""
    from cramlite_plugins.kinematics.inverse import nearest_branch

    home = forward(UR5E, UR5E.home)
    x, y, z = home.position
    found = nearest_branch(UR5E, replace(home, position=(x, y, z - height)), UR5E.home)
    assert found is not None
    return tuple(found)


def gone(*ways: float, met: range = range(0), force: float = 0.0) -> Candidate:
    """A candidate whose tool goes down by ways in turn, from one sample of the step on [m]."""
    base = felt(force, END - 1, met=met)
    assert base.rollout is not None
    joints = base.rollout.joints.copy()
    for k, way in enumerate(ways):
        joints[FIRST + 1 + k :] = lowered(way)
    return replace(base, rollout=replace(base.rollout, joints=joints))


def said(run: Candidate, *steps: AnyStep) -> str:
    return wrong_end(run, steps, (FIRST, END))


AT_END = range(END - 1, END + 1)


def test_a_guard_ends_where_it_meets_something() -> None:
    assert taxonomy() is not None
    assert said(gone(0.02, met=AT_END), guard()) == ""
    assert said(gone(0.02), guard()) == "it ended after 20 of at most 50 mm without a contact"
    assert said(gone(0.02, met=range(FIRST, END - SPREAD - 2)), guard()), "what it met on its way is not where it ended"
    assert said(gone(0.05), guard()), "one that must meet something does not end at the end of its range"
    assert said(gone(0.0, met=AT_END), guard()) == "", "it may meet it at once"
    for late, refused in ((2 * SPREAD, False), (2 * SPREAD + 1, True)):
        assert bool(said(gone(0.02, met=range(END + late, END + late + 1)), guard())) is refused, "samples lag a little"
    for early, refused in ((2 * SPREAD, False), (2 * SPREAD + 1, True)):
        assert bool(said(gone(0.02, met=range(END - early, END - early + 1)), guard())) is refused, "or are a little ahead"


def test_where_a_guard_ends_is_where_the_sample_after_its_code_has_it() -> None:
    run = gone(0.02, met=AT_END)
    assert run.rollout is not None
    joints = run.rollout.joints.copy()
    joints[END] = lowered(0.08)
    assert said(replace(run, rollout=replace(run.rollout, joints=joints)), guard()).startswith("it went on 30 mm beyond")


@pytest.mark.parametrize(("way", "fine"), [(0.05, True), (0.041, True), (0.039, False)])
def test_a_guard_that_need_not_meet_anything_goes_to_the_end_of_its_range(way: float, fine: bool) -> None:
    assert (said(gone(way), guard(expect="any")) == "") is fine
    assert said(gone(0.01, met=AT_END), guard(expect="any")) == ""
    run = gone(0.03)
    assert run.rollout is not None
    joints = run.rollout.joints.copy()
    joints[END:] = lowered(way)
    late = replace(run, rollout=replace(run.rollout, joints=joints))
    assert (said(late, guard(expect="any")) == "") is fine, "at its last sample"


@pytest.mark.parametrize(("way", "fine"), [(0.05, True), (0.059, True), (0.061, False)])
def test_a_guard_goes_no_farther_than_its_range(way: float, fine: bool) -> None:
    assert (said(gone(way, met=AT_END), guard()) == "") is fine


@pytest.mark.parametrize(("way", "fine"), [(0.15, True), (0.159, True), (0.161, False)])
def test_its_range_begins_where_the_part_in_the_air_leads(way: float, fine: bool) -> None:
    air = MoveLinear(forward(UR5E, lowered(0.1)), 0.1, 0.5, origin=ORIGIN)
    high = replace(air, target=forward(UR5E, lowered(0.0)))
    for before in ((air,), (high, air)):
        assert (said(gone(way, met=AT_END), *before, guard()) == "") is fine, "the last part leads there"
    for other in (replace(air, relative="block"), Wait(1.0, origin=ORIGIN)):
        assert said(gone(way, met=AT_END), other, guard()) == "", "nobody knows where that is"


def test_code_that_never_ran_ends_nowhere() -> None:
    assert wrong_end(gone(0.05), [guard()], (FIRST, FIRST)) == "none of its code ran"


@pytest.mark.parametrize(("advance", "force", "fine"), [(0.002, 0.0, True), (0.0009, 0.0, False), (0.0, 5.5, True), (0.0, 5.3, False)])
def test_a_search_ends_where_it_gives_way_or_a_rim_holds_it(advance: float, force: float, fine: bool) -> None:
    search = SpiralSearch(DOWN, 3.0, 0.001, 0.008, 0.01, 0.002, 25.0, 9.0, origin=ORIGIN)
    assert (said(gone(advance, force=force), search) == "") is fine


def test_a_search_ends_within_its_radius() -> None:
    sideways = Pose.from_axes((0, 0, 0), (1, 0, 0), (0, 0, 1))
    search = SpiralSearch(sideways, 3.0, 0.001, 0.008, 0.01, 0.002, 25.0, 9.0, origin=ORIGIN)
    assert said(gone(0.017, force=6.0), search) == ""
    assert said(gone(0.019, force=6.0), search).startswith("it ended 19 mm from where it began")
    assert said(gone(0.019, force=6.0), replace(search, frame=DOWN)) == "", "along its axis it goes by its advance"
    run = gone(0.0, force=6.0)
    assert run.rollout is not None
    joints = run.rollout.joints.copy()
    joints[END] = lowered(0.019)
    assert said(replace(run, rollout=replace(run.rollout, joints=joints)), search) != "", "where it ends is its last sample"
    assert said(replace(run, rollout=replace(run.rollout, joints=joints)), replace(search, frame=DOWN)) == ""


@pytest.mark.parametrize(("way", "fine"), [(0.02, True), (0.0, False)])
def test_an_insertion_and_an_extraction_end_at_their_last_sample(way: float, fine: bool) -> None:
    run = gone(0.0)
    assert run.rollout is not None
    joints = run.rollout.joints.copy()
    joints[END:] = lowered(way)
    moved = replace(run, rollout=replace(run.rollout, joints=joints))
    assert (said(moved, ForceInsert(DOWN, 8.0, 0.03, 0.02, 25.0, 9.0, origin=ORIGIN)) == "") is fine
    assert (said(moved, ForceExtract(DOWN, 8.0, (0.0, 0.0), 0.03, 0.02, 25.0, 9.0, origin=ORIGIN)) == "") is fine


@pytest.mark.parametrize(("sample", "held"), [(FIRST - 1, False), (FIRST, True), (END, True), (END + 1, False)])
def test_a_rim_holds_a_search_while_its_code_runs(sample: int, held: bool) -> None:
    search = SpiralSearch(DOWN, 3.0, 0.001, 0.008, 0.01, 0.002, 25.0, 9.0, origin=ORIGIN)
    assert (said(felt(6.0, sample), search) == "") is held


@pytest.mark.parametrize(("way", "fine"), [(0.021, True), (0.019, False), (0.05, True), (0.059, True), (0.061, False)])
def test_an_insertion_covers_its_depth_and_no_more(way: float, fine: bool) -> None:
    insert = ForceInsert(DOWN, 8.0, 0.05, 0.02, 25.0, 9.0, origin=ORIGIN)
    assert (said(gone(way), insert) == "") is fine


@pytest.mark.parametrize(("way", "fine"), [(0.021, True), (0.019, False), (0.08, True), (-0.01, False)])
def test_an_extraction_covers_its_way_and_may_go_on(way: float, fine: bool) -> None:
    pull = ForceExtract(DOWN, 8.0, (0.0, 0.0), 0.05, 0.04, 25.0, 9.0, origin=ORIGIN)
    assert (said(gone(way), pull) == "") is fine


# In real programs

LOWER = "0.03, 0.01, 3.0, 9.0"


def with_lower(numbers: str) -> str:
    good = proven("placing")
    assert good.code is not None and LOWER in good.code.text
    return good.code.text.replace(LOWER, numbers)


@pytest.mark.heavy
@pytest.mark.parametrize("force", [2.0, 6.0])
def test_a_softer_and_a_little_harder_guard_put_the_block_down_too(force: float) -> None:
    assert against(proven("placing"), with_lower(f"0.03, 0.01, {force}, 9.0")) == {}


@pytest.mark.heavy
def test_a_guard_of_25_n_presses_harder_than_the_plan() -> None:
    assert "which ends at 3 N" in against(proven("placing"), with_lower("0.03, 0.01, 25.0, 9.0"))["force_peak"]


@pytest.mark.heavy
def test_a_guard_that_stops_in_the_air_put_nothing_down() -> None:
    text = with_lower("0.012, 0.01, 3.0, 9.0")
    found = against(proven("placing"), re.sub(r'(0\.012, 0\.01, 3\.0, 9\.0, )"contact"', r'\1"any"', text))
    assert re.match(r"3.Placing/PuttingDown/lower was not carried out: it ended after \d+ of at most 30 mm", found["steps"])


@pytest.mark.heavy
def test_a_jug_that_is_turned_back_half_of_the_way_still_leans() -> None:
    good = proven("pouring")
    assert good.code is not None
    half = [line for line in good.code.text.splitlines() if not re.search(r"movej\(pouring_3_back_joints_(1[1-9]|2\d),", line)]
    (reason,) = (f.reason for f in findings(run(good, "\n".join(half))) if f.validator == "steps" and not f.passed)
    assert re.match(r"3.Pouring/back was not carried out: 'jug' leans \d+ deg", reason)
