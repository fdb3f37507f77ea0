"""Execution, force peaks, commanded forces and slip: each validator passes a run just inside its limit and refuses one just outside."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import COUNT, LEFT, LINES, OPENED, STEP, TAKEN, good, only, posed, said, shifted, touching
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Floats, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.validators.physics import CommandedForce, Execution, ForcePeak, GraspSlip, validators


def forced(**newtons: float) -> Floats:
    """(COUNT,) a force at the samples k17, k40, ... alone [N]."""
    force = np.zeros(COUNT)
    for name, value in newtons.items():
        force[int(name[1:])] = value
    return force


def limited(candidate: Candidate, task: str, newtons: float | None) -> Candidate:
    """The candidate with another force limit of one task [N]."""
    own = candidate.allowances[task]
    return replace(candidate, allowances={**candidate.allowances, task: replace(own, force=newtons)})


def test_all_of_them_are_asked() -> None:
    assert [v.name for v in validators()] == ["execution", "collision", "force_peak", "commanded_force", "grasp_slip"]


def test_a_program_that_ran_to_its_end_did() -> None:
    found = only(Execution(), good())
    assert found.passed and found.value == pytest.approx(89 * STEP) and found.reason == "the program ran to its end in 4.5 s"


@pytest.mark.parametrize("outcome", ["halted", "protective stop", "timeout", "error"])
def test_one_that_stopped_did_not(outcome: str) -> None:
    found = only(Execution(), good(outcome=outcome, reason="no contact", lines=np.where(np.arange(COUNT) < 60, LINES, 0.0)))
    assert not found.passed and found.origin == "3.Placing"
    assert found.reason == f"{outcome} at line 5, 3.0 s: no contact"
    assert found.stopped  # told before what other validators object to


def test_one_that_never_began_did_not_either() -> None:
    found = only(Execution(), good(outcome="error", reason="line 1", lines=np.zeros(COUNT)))
    assert not found.passed and found.reason == "error at line 0, 0.0 s: line 1"


@pytest.mark.parametrize(("newtons", "passes"), [(28.7, True), (28.8, False)])
def test_a_task_that_stops_at_its_limit_may_exceed_it_by_what_stopping_takes(newtons: float, passes: bool) -> None:
    found = only(ForcePeak(), good(force=forced(k55=newtons)))
    assert (found.passed, found.origin) == (passes, "3.Placing/PuttingDown")
    assert found.reason == f"peak {newtons} N at 2.8 s, limit 28.75 N of 3.Placing/PuttingDown (25 N, plus 15% while the arm stops)"


@pytest.mark.parametrize(("newtons", "passes"), [(60.0, True), (60.001, False)])
def test_what_is_felt_while_nothing_is_touched_has_the_programs_limit(newtons: float, passes: bool) -> None:
    """A heavy load that is accelerated pulls at the sensor, too."""
    found = only(ForcePeak(), good(force=forced(k40=newtons)))
    assert (found.passed, found.origin, found.limit) == (passes, "2.PickingUp", 60.0)
    assert found.reason.endswith("limit 60 N of robot 'ur5e'")


@pytest.mark.parametrize(("own", "limit"), [(52.0, 52.0 * 1.15), (52.2, 60.0), (70.0, 60.0), (60.0 / 1.15, 60.0)])
def test_the_programs_limit_is_above_no_tasks(own: float, limit: float) -> None:
    found = only(ForcePeak(), limited(good(force=forced(k55=10.0)), "3.Placing/PuttingDown", own))
    assert found.limit == pytest.approx(limit)
    assert ("of robot" in found.reason) == (limit == 60.0)


def test_the_peak_is_the_highest_share_of_its_own_limit() -> None:
    found = only(ForcePeak(), good(force=forced(k40=50.0, k55=29.0)))
    assert not found.passed and found.value == 29.0


def test_what_is_felt_while_nothing_runs_is_no_peak() -> None:
    assert only(ForcePeak(), good(force=forced(k0=500.0, k95=500.0))).value == 0.0
    assert list(ForcePeak().check(good(force=forced(k40=500.0), lines=np.zeros(COUNT)))) == []


def test_what_is_felt_in_the_first_line_counts() -> None:
    assert only(ForcePeak(), good(force=forced(k40=500.0), lines=np.ones(COUNT))).value == 500.0


def test_without_a_sensor_the_wrench_counts() -> None:
    wrench = np.zeros((COUNT, 6))
    wrench[40] = (36.0, 0.0, -48.1, 900.0, 0.0, 0.0)
    assert not only(ForcePeak(), good(force=None, wrench=wrench)).passed


@pytest.mark.parametrize(("newtons", "passes"), [(25.0, True), (25.001, False)])
def test_no_task_is_told_to_press_harder_than_its_limit(newtons: float, passes: bool) -> None:
    found = only(CommandedForce(), good(commanded=forced(k55=newtons)))
    assert (found.passed, found.limit, found.origin) == (passes, 25.0, "3.Placing/PuttingDown")
    assert found.reason == f"told the arm to apply {newtons:.1f} N at 2.8 s, limit 25 N of 3.Placing/PuttingDown"


@pytest.mark.parametrize(("newtons", "passes"), [(25.0, True), (25.001, False)])
def test_a_task_that_declares_no_force_may_be_told_as_much_as_motions_by_force_end_at(newtons: float, passes: bool) -> None:
    for sample in ("k40", "k75"):
        found = only(CommandedForce(), good(commanded=forced(**{sample: newtons, "k55": 20.0})))
        assert (found.passed, found.limit) == (passes, 25.0) and found.reason.endswith("limit 25 N of every task that declares none")


@pytest.mark.parametrize(("newtons", "passes"), [(60.0, True), (60.001, False)])
def test_no_task_may_be_told_more_than_the_program(newtons: float, passes: bool) -> None:
    found = only(CommandedForce(), limited(good(commanded=forced(k55=newtons)), "3.Placing/PuttingDown", 70.0))
    assert (found.passed, found.limit) == (passes, 60.0) and found.reason.endswith("of robot 'ur5e'")


def test_nothing_is_said_of_forces_where_none_was_commanded() -> None:
    assert list(CommandedForce().check(good(commanded=None))) == list(CommandedForce().check(good())) == []


@pytest.mark.parametrize(("way", "passes"), [(0.0119, True), (0.0121, False)])
def test_what_is_held_may_settle_and_not_slip(way: float, passes: bool) -> None:
    found = only(GraspSlip(), shifted((0, way, 0), "block", 40, 41))
    assert (found.passed, found.origin, found.unit) == (passes, "2.PickingUp", "m")
    assert found.reason == f"'block' moved {1000 * way:.1f} mm in the hand, limit 12 mm"
    assert found.value == pytest.approx(way) and found.limit == 0.012
    assert (found.remedy is None) is passes and (passes or "force_n" in str(found.remedy))
    assert found.things, "another grasp may change it, and hardly another height of the lift"


def test_the_peak_of_commands_is_the_highest_share_of_its_own_limit() -> None:
    assert only(CommandedForce(), limited(good(commanded=forced(k40=24.0, k55=16.0)), "3.Placing/PuttingDown", 15.0)).value == 16.0


def test_the_first_line_of_a_program_counts() -> None:
    assert only(ForcePeak(), good(force=forced(k10=61.0))).origin == "1.Grasping"


def test_a_slip_while_it_is_put_down_is_one_of_that_task() -> None:
    assert only(GraspSlip(), shifted((0, 0.02, 0), "block", 60)).origin == "3.Placing"


@pytest.mark.parametrize(("lifted", "origin"), [(0.0119, "3.Placing"), (0.0121, "2.PickingUp")])
def test_what_slips_ever_further_is_one_of_the_task_where_it_first_went_too_far(lifted: float, origin: str) -> None:
    poses = shifted((0, lifted, 0), "block", 40).rollout.poses["block"].copy()  # type: ignore[union-attr]
    poses[60:, 1] += 0.02
    found = only(GraspSlip(), posed(block=poses))
    assert (found.passed, found.origin) == (False, origin) and found.value == pytest.approx(lifted + 0.02)


@given(way=st.floats(-0.1, 0.1), sample=st.integers(TAKEN + 3, OPENED - 4), axis=st.sampled_from([0, 1, 2]))
@examples(30)
def test_slip_is_how_far_it_got_whenever_and_whichever_way(way: float, sample: int, axis: int) -> None:
    found = only(GraspSlip(), shifted(np.eye(3)[axis] * way, "block", sample, sample + 1))
    assert found.value == pytest.approx(abs(way), abs=1e-9) and found.passed == (abs(way) <= 0.012)


@pytest.mark.parametrize("sample", [TAKEN, TAKEN + 1, OPENED - 1, OPENED - 2])
def test_fingers_that_close_or_open_may_push(sample: int) -> None:
    assert only(GraspSlip(), shifted((0, 0.05, 0), "block", sample, sample + 1)).value == pytest.approx(0.0)


def test_one_pad_holds_nothing_that_could_slip() -> None:
    one = touching(range(TAKEN, OPENED), without=lambda t: LEFT in (t.a, t.b))
    assert list(GraspSlip().check(one)) == []


def test_what_turns_with_the_hand_does_not_slip() -> None:
    base = good().rollout
    assert base is not None
    hand, block = base.poses["effector"].copy(), base.poses["block"].copy()
    turned = slice(40, 60)
    hand[turned, 3:] = block[turned, 3:] = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    block[:, 0] += 0.01  # it is held 10 mm beside the middle
    block[turned, :2] += (-0.01, 0.01)
    assert only(GraspSlip(), good(poses={**base.poses, "effector": hand, "block": block})).value == pytest.approx(0.0)
    still = block.copy()
    still[turned, :2] -= (-0.01, 0.01)
    assert said(GraspSlip(), good(poses={**base.poses, "effector": hand, "block": still})) != []


def test_each_grip_is_judged() -> None:
    again = (Touch(LEFT, "cup", 5.0, 0.0), Touch("cup", "effector/right", 5.0, 0.0))
    two = touching(range(80, 95), *again)
    assert two.rollout is not None
    opening = two.rollout.opening.copy()
    opening[80:95] = 0.06
    hand = two.rollout.poses["effector"].copy()
    hand[88:, 2] += 0.03
    both = replace(two, rollout=replace(two.rollout, opening=opening, poses={**two.rollout.poses, "effector": hand}))
    assert [f.reason.split()[0] for f in GraspSlip().check(both)] == ["'block'", "'cup'"]
    assert "'cup' moved" in said(GraspSlip(), both)[0]


def test_exactly_at_the_limit_it_has_not_slipped() -> None:
    base = good().rollout
    assert base is not None
    still = np.tile((0.0, 0, 0, 1.0, 0, 0, 0), (COUNT, 1))
    moved = still.copy()
    moved[40:60, 0] = 0.012
    found = only(GraspSlip(), good(poses={**base.poses, "effector": still, "block": moved}))
    assert (found.value, found.passed) == (0.012, True)


def test_where_nothing_is_felt_the_peak_is_none() -> None:
    assert only(ForcePeak(), good()).reason == "peak 0.0 N at 0.0 s, limit 60 N of robot 'ur5e'"
