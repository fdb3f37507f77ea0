"""Steps of a program in runs that are written by hand: which have code, which ran in their turn, and how much of its way each covered."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from helpers.short_runs import COUNT, STEP, good
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    Drive,
    Fallback,
    Finding,
    ForceMove,
    Joint,
    Joints,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Pose,
    SetGripper,
    SetPayload,
    Touch,
    Wait,
    ZeroSensor,
)
from cramlite.plugin import Allowance, Candidate
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.steps import Steps, _covered, _lean, _way, validators

A, B, C = "1.Moving/there", "2.Moving/on", "3.Moving/back"
FREE = (True, True, True, False, False, False)
HOME = forward(UR5E, UR5E.home)


def up(height: float, turn: float = 0.0) -> Pose:
    """The pose of the tool so high over that of the home posture [m], turned about the vertical [rad]."""
    x, y, z = HOME.position
    return Pose.from_matrix(Pose.from_rotvec((x, y, z + height), (0, 0, turn)).matrix @ np.block([
        [HOME.matrix[:3, :3], np.zeros((3, 1))], [np.zeros((1, 3)), 1.0],
    ]))  # fmt: skip


@cache
def joints(pose: Pose) -> Joints:
    """Joints that lead the tool there."""
    return next(iter(inverse(UR5E, pose, seed=UR5E.home)))


def line(origin: str, target: Pose) -> MoveLinear:
    return MoveLinear(target, 0.1, 0.5, origin=origin)


def opened(origin: str) -> SetGripper:
    return SetGripper(0.085, 0.1, 50.0, origin=origin)


def ran(
    steps: tuple[AnyStep, ...], stretches: list[tuple[str, int]], hand: dict[int, Pose], without: tuple[str, ...] = ()
) -> Candidate:
    """A run of a program.

    Args:
        steps: of the program.
        stretches: origins whose code ran one after the other, each for so many samples; "" where none did.
        hand: sample -> where the tool is from then on.
        without: origins that have no code.
    """
    names = sorted({o for o, _ in stretches if o} | {i for s in steps for i in _origins(s)} - {*without})
    numbers = {o: k for k, o in enumerate(names, 1)} | {"": 0}
    lines = np.zeros(COUNT)
    ran_ = [numbers[o] for o, count in stretches for _ in range(count)]
    lines[: len(ran_)] = ran_
    turned = np.array([joints(hand[max(s for s in hand if s <= k)]) for k in range(COUNT)])
    base = good(lines=lines, joints=turned)
    code = replace(base.code, origins={k: o for o, k in numbers.items() if o})  # type: ignore[type-var]
    return replace(base, program=replace(base.program, steps=steps), code=code)


def _origins(step: AnyStep) -> list[str]:
    inner = [i for branch in getattr(step, "branches", ()) for s in branch for i in _origins(s)]
    return [step.origin, *inner] if step.origin else inner


def judged(candidate: Candidate) -> list[Finding]:
    return list(Steps().check(candidate))


def wrong(candidate: Candidate) -> list[tuple[str, str]]:
    """Origin and reason of each objection."""
    return [(f.origin, f.reason) for f in judged(candidate) if not f.passed]


def share(candidate: Candidate) -> float | None:
    """What the only objection says was covered; None without one."""
    found = [f for f in judged(candidate) if not f.passed]
    assert len(found) < 2, found
    return found[0].value if found else None


TWO = (line(A, up(0.1)), line(B, up(0.0)))
THERE = {0: up(0.0), 20: up(0.1), 40: up(0.0)}
"""Where the tool is when A runs for the first twenty samples and B for twenty more."""


def test_the_validator_is_asked_of_runs() -> None:
    assert [(v.name, v.cost) for v in validators()] == [("steps", "rollout")]


# Good runs


def test_steps_that_ran_in_their_turn_and_covered_their_way_pass() -> None:
    assert [(f.validator, f.passed) for f in judged(ran(TWO, [(A, 20), (B, 20)], THERE))] == [("steps", True)]


def test_a_program_without_steps_that_have_an_origin_has_no_finding() -> None:
    assert judged(ran((), [], {0: up(0.0)})) == []
    assert judged(ran((line("", up(0.1)),), [], {0: up(0.0)})) == []


# How much of its way


@pytest.mark.parametrize(("covered", "enough"), [(0.041, True), (0.039, False)])
def test_two_fifths_of_a_way_are_enough(covered: float, enough: bool) -> None:
    hand = {0: up(0.0), 20: up(covered)}
    found = judged(ran(TWO[:1], [(A, 20)], hand))
    assert [f.passed for f in found] == [enough]
    if not enough:
        assert (found[0].validator, found[0].origin, found[0].limit) == ("steps", A, 0.4)
        assert found[0].value == pytest.approx(0.39, abs=1e-6)


@pytest.mark.parametrize(("length", "passed"), [(0.039, True), (0.041, False)])
def test_a_short_way_is_not_judged(length: float, passed: bool) -> None:
    assert [f.passed for f in judged(ran((line(A, up(length)),), [(A, 20)], {0: up(0.0)}))] == [passed]


@pytest.mark.parametrize(("turn", "passed"), [(0.39, True), (0.41, False)])
def test_a_turn_is_a_way_too(turn: float, passed: bool) -> None:
    assert [f.passed for f in judged(ran((line(A, up(0.0, turn)),), [(A, 20)], {0: up(0.0)}))] == [passed]


def test_position_and_rotation_count_together_and_what_leads_aside_does_not() -> None:
    both = (line(A, up(0.1, 1.0)),)
    assert share(ran(both, [(A, 20)], {0: up(0.0), 20: up(0.0, 0.7)})) == pytest.approx(0.35, abs=1e-3)
    assert share(ran(both, [(A, 20)], {0: up(0.0), 20: up(0.0, 1.0)})) is None
    assert share(ran(both, [(A, 20)], {0: up(0.0), 20: up(0.1, -0.5)})) == pytest.approx(0.25, abs=1e-3)
    assert share(ran(TWO[:1], [(A, 20)], {0: up(0.0), 20: up(0.0, 3.0)})) == pytest.approx(0.0, abs=1e-3)
    assert share(ran(TWO[:1], [(A, 20)], {0: up(0.0), 20: up(-0.05)})) == pytest.approx(-0.5, abs=1e-3)


def test_a_way_is_from_the_first_sample_of_the_steps_code_to_the_one_after_its_last() -> None:
    late = [("", 10), (A, 20)]
    assert share(ran(TWO[:1], late, {0: up(0.1), 10: up(0.0), 30: up(0.1)})) is None
    assert share(ran(TWO[:1], [*late, (B, 5)], {0: up(0.0), 30: up(0.1), 31: up(0.0)})) is None
    assert share(ran(TWO[:1], [*late, (B, 5)], {0: up(0.0), 31: up(0.1)})) == pytest.approx(0.0, abs=1e-6)


def test_the_way_of_the_last_step_ends_with_the_run() -> None:
    assert share(ran(TWO[:1], [(A, 20)], {0: up(0.0), COUNT - 1: up(0.1)})) is None


def test_a_step_may_pause_on_its_way() -> None:
    pause = [(A, 10), ("", 10), (A, 10), (B, 10)]
    assert wrong(ran(TWO, pause, {0: up(0.0), 10: up(0.09), 30: up(0.1), 40: up(0.0)})) == []


@pytest.mark.parametrize("kind", [ForceMove, CompliantSlide])
def test_a_step_along_waypoints_leads_to_the_last(kind: type[ForceMove] | type[CompliantSlide]) -> None:
    ways = (up(0.0), up(0.0), up(0.1))
    step: AnyStep = CompliantSlide(ways, up(0.0), 5.0, 0.1, 0.01, 30.0, 5.0, origin=A)
    if kind is ForceMove:
        step = ForceMove(ways, up(0.0), FREE, (0.0,) * 6, (0.1,) * 6, 0.1, 30.0, 5.0, origin=A)
    assert share(ran((step,), [(A, 20)], {0: up(0.0)})) == pytest.approx(0.0, abs=1e-6)
    assert share(ran((step,), [(A, 20)], {0: up(0.0), 20: up(0.1)})) is None
    assert share(ran((step, line(A, up(0.0))), [(A, 20)], {0: up(0.0)})) is None


def test_a_motion_of_joints_leads_to_the_last_of_its_path() -> None:
    step = MoveJoints((joints(up(0.0)), joints(up(0.0)), joints(up(0.1))), 1.0, 1.0, origin=A)
    assert share(ran((step,), [(A, 20)], {0: up(0.0)})) == pytest.approx(0.0, abs=1e-6)
    assert share(ran((step,), [(A, 20)], {0: up(0.0), 20: up(0.1)})) is None


def test_of_steps_under_one_origin_the_last_motion_counts() -> None:
    both = (line(A, up(0.1)), line(A, up(0.2)), opened(A))
    assert share(ran(both, [(A, 20)], {0: up(0.0), 20: up(0.07)})) == pytest.approx(0.35, abs=1e-3)


def test_behind_a_drive_and_in_a_control_step_no_pose_is_stated() -> None:
    drive = Drive(((0.1, 0.0, 0.0),), 0.1, 0.5, 0.1, 0.5, origin=A)
    assert wrong(ran((line(A, up(0.1)), drive), [(A, 20)], {0: up(0.0)})) == []
    assert wrong(ran((line(A, up(0.1)), Fallback(((opened(B),),), origin=A)), [(A, 20)], {0: up(0.0)})) == []
    assert share(ran((drive, line(A, up(0.1))), [(A, 20)], {0: up(0.0)})) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("planned", "angle", "share"),
    [(3.12, 3.1, 1.0), (3.12, 3.18, 1.0), (3.12, 1.6, 0.51), (3.12, 0.1, 0.03), (-3.12, 1.5, -0.48), (-3.12, 1.65, 1.485)],
)
def test_about_half_a_turn_a_rotation_counts_as_the_one_that_was_planned(planned: float, angle: float, share: float) -> None:
    way = _way(np.eye(4), Pose.from_rotvec((0, 0, 0), (planned, 0, 0)).matrix)
    turned = _covered(np.eye(4), Pose.from_rotvec((0, 0, 0.05), (angle, 0, 0)).matrix, way)
    assert float(turned @ way) / float(way @ way) == pytest.approx(share, abs=0.03)
    assert turned[2] == 0.05


# Code that never ran


def test_a_step_whose_code_never_ran_covered_nothing() -> None:
    assert wrong(ran(TWO, [(A, 20)], {0: up(0.0), 20: up(0.1)}))[0][0] == B
    assert share(ran(TWO, [(A, 20)], {0: up(0.0), 20: up(0.1)})) == pytest.approx(0.0, abs=1e-6)


def test_a_step_that_never_ran_and_whose_pose_is_reached_already_lacks_nothing() -> None:
    three = (*TWO, line(C, up(0.2)))
    high = {20: up(0.0), 40: up(0.2)}
    assert wrong(ran(three, [(A, 20), (C, 20)], {0: up(0.0), 20: up(0.1), 40: up(0.2)}))[0][0] == B
    assert wrong(ran((line(A, up(0.0)), TWO[1], line(C, up(0.2))), [(A, 20), (C, 20)], {0: up(0.0), **high})) == []
    assert wrong(ran((line(A, up(0.1)), line(B, up(0.0))), [(B, 20)], {0: up(0.1), 1: up(0.0)})) == []
    assert wrong(ran((line(A, up(0.1)), line(B, up(0.0))), [(B, 20)], {0: up(0.0), 1: up(0.1), 20: up(0.0)}))[0][0] == A


# Without code


def proven_with(candidate: Candidate, *others: str) -> Candidate:
    """The candidate, whose proven text had code of other steps, too."""
    assert candidate.code is not None
    count = max(candidate.code.origins)
    return replace(candidate, proven=replace(candidate.code, origins=candidate.code.origins | dict(enumerate(others, count + 1))))


LOSS = " has no line of code in this text, while the proven text had some"


def test_a_step_that_lost_its_code_is_told_by_its_name_and_a_task_by_its_own() -> None:
    steps = (*TWO, line("2.Moving/off", up(0.0)), opened(C))
    hand = THERE
    some = ran(steps, [(A, 20), (B, 20)], hand, without=("2.Moving/off", C))
    assert wrong(some) == []
    assert wrong(proven_with(some, "2.Moving/off")) == [("2.Moving/off", f"2.Moving/off{LOSS}")]
    assert wrong(proven_with(some, "2.Moving/off", C)) == [("2.Moving/off", f"2.Moving/off{LOSS}"), ("3.Moving", f"3.Moving{LOSS}")]
    whole = ran(steps, [(A, 20)], {0: up(0.0), 20: up(0.1)}, without=(B, "2.Moving/off", C))
    assert wrong(proven_with(whole, "2.Moving/off", B)) == [("2.Moving", f"2.Moving{LOSS}")]


def test_the_way_of_a_step_without_code_is_not_judged() -> None:
    some = ran(TWO, [(B, 20)], {0: up(0.0)}, without=(A,))
    assert [f.passed for f in judged(some)] == [True]
    assert [f.passed for f in judged(proven_with(some, A))] == [False]


def test_a_line_that_is_a_comment_is_no_code() -> None:
    some = ran(TWO, [(A, 20), (B, 20)], THERE)
    assert some.code is not None
    blank = replace(some.code, text="\n".join("# gone" if k == 2 else t for k, t in enumerate(some.code.text.splitlines(), 1)))
    assert wrong(replace(some, code=blank, proven=some.code)) == [("2.Moving", f"2.Moving{LOSS}")]


def test_of_a_run_that_halted_only_lost_code_is_told() -> None:
    some = ran(TWO, [(A, 20)], {0: up(0.0)}, without=(B,))
    assert some.rollout is not None
    halted = replace(some, rollout=replace(some.rollout, outcome="protective stop"))
    assert wrong(halted) == []
    assert [origin for origin, _ in wrong(proven_with(halted, B))] == ["2.Moving"]


# Turns


def test_code_that_runs_after_that_of_a_later_step_is_late() -> None:
    found = wrong(ran(TWO, [("", 2), (B, 20), (A, 20)], {0: up(0.1), 22: up(0.0), 42: up(0.0)}))
    assert found == [(A, f"the code of {A} ran at {22 * STEP:.2f} s, after that of {B}, which comes later in the program")]


def test_a_step_that_comes_twice_in_a_program_may_run_twice() -> None:
    steps = (line(A, up(0.1)), line(B, up(0.0)), line(A, up(0.1)), line(C, up(0.0)))
    hand = {0: up(0.0), 20: up(0.1), 40: up(0.0), 60: up(0.1), 80: up(0.0)}
    assert wrong(ran(steps, [(A, 20), (B, 20), (A, 20), (C, 20)], hand)) == []
    assert share(ran(steps, [(A, 20), (B, 20), (A, 20), (C, 20)], hand | {60: up(0.03)})) == pytest.approx(0.3, abs=1e-3)
    (late,) = wrong(ran(steps, [(A, 20), (B, 20), (C, 20), (A, 20)], {**hand, 60: up(0.0), 80: up(0.1)}))
    assert late[0] == A and late[1].endswith(f"after that of {C}, which comes later in the program")


def test_a_step_that_runs_on_behind_a_late_one_is_judged_once_for_all_of_its_code() -> None:
    (late,) = wrong(ran(TWO, [(B, 10), (A, 10), (B, 10)], {0: up(0.1), 30: up(0.0)}))
    assert late[0] == A
    both = wrong(ran(TWO, [(B, 10), (A, 10), (B, 10)], {0: up(0.1), 10: up(0.0), 20: up(0.1)}))
    assert [origin for origin, _ in both] == [A, B]


@pytest.mark.parametrize(
    ("step", "late"),
    [(SetPayload(1.0, (0.0, 0.0, 0.1), origin=A), False), (ZeroSensor(origin=A), False), (Wait(0.1, origin=A), False), (opened(A), True)],
    ids=["payload", "zero", "wait", "gripper"],
)
def test_what_moves_nothing_may_change_places_with_its_neighbour(step: AnyStep, late: bool) -> None:
    found = wrong(ran((step, line(B, up(0.1))), [(B, 20), (A, 20)], {0: up(0.0), 20: up(0.1)}))
    assert [origin for origin, _ in found] == ([A] if late else [])


def test_a_control_step_is_one_whatever_it_does_in_it() -> None:
    way = Fallback(((line("2.Moving/a", up(0.1)),), (line("2.Moving/b", up(0.2)),)))
    steps = (line(A, up(0.1)), way, line(C, up(0.0)))
    hand = {0: up(0.0), 20: up(0.1), 60: up(0.0)}
    assert wrong(ran(steps, [(A, 20), ("2.Moving/b", 10), ("2.Moving/a", 10), (C, 20)], hand)) == []
    assert wrong(ran(steps, [(A, 20), ("2.Moving/a", 20), (C, 20)], hand, without=("2.Moving/b",))) == []
    (late,) = wrong(ran(steps, [(A, 20), (C, 20), ("2.Moving/b", 10)], {**hand, 40: up(0.0)}))
    assert late[0] == "2.Moving/a"


# What is felt


@pytest.mark.parametrize("met", [True, False])
def test_a_step_that_feels_its_way_ends_where_it_meets_something(met: bool) -> None:
    guard = MoveUntilContact((0.0, 0.0, -1.0), 0.01, 3.0, 0.05, 9.0, "contact", origin=A)
    made = ran((guard,), [(A, 20), ("9.Other/on", 20)], {0: up(0.1), 10: up(0.08)})
    assert made.rollout is not None
    rows = tuple((Touch("effector/left", "cup", 5.0, 0.0),) if met and k in (19, 20) else () for k in range(COUNT))
    (found,) = judged(replace(made, rollout=replace(made.rollout, touches=rows)))
    assert (found.passed, found.origin) == ((True, "") if met else (False, A))
    assert met or found.reason == f"{A} was not carried out: it ended after 20 of at most 50 mm without a contact"


# What is pushed


PUSHING = "4.Pushing"
PUSH = f"{PUSHING}/push"


def pushing(far: float, *, hand: float = 0.06, step: AnyStep | None = None, moves: str = "cup") -> Candidate:
    """A run in which the hand is to go 60 mm along x and goes so far, and the cup before it gets so far."""
    x, y, z = HOME.position
    there, gone = (Pose((x + way, y, z), HOME.quaternion) for way in (0.06, hand))
    made = ran((step or line(PUSH, there),), [("", 10), (PUSH, 20)], {0: HOME, 20: gone})
    assert made.rollout is not None
    cup = made.rollout.poses["cup"].copy()
    cup[25:, 0] += far
    return replace(
        made, rollout=replace(made.rollout, poses={**made.rollout.poses, "cup": cup}),
        allowances={**made.allowances, PUSHING: Allowance(moves=frozenset({moves}))},
    )  # fmt: skip


@pytest.mark.parametrize(("far", "passes"), [(0.057, True), (0.069, True), (0.071, False), (0.12, False)])
def test_what_is_pushed_gets_as_far_as_the_hand_was_to_go_and_slides_on_a_little(far: float, passes: bool) -> None:
    found = wrong(pushing(far, hand=max(far, 0.06)))
    assert (found == []) is passes
    if not passes:
        said = f"{PUSH} pushed 'cup' by {1000 * far:.0f} mm, where the hand was to go 60 mm"
        said = f"{said}; a pushed thing may go 10 mm farther than the hand"
        assert found == [(PUSH, said)]
        (finding,) = (f for f in judged(pushing(far)) if not f.passed)
        assert (finding.value, finding.limit) == (pytest.approx(far), pytest.approx(0.07)) and finding.things


def test_a_hand_that_begins_nearer_pushes_less() -> None:
    """The hand was to go 20 mm from where the step begins, as it is there already for the most part."""
    x, y, z = HOME.position
    nearer = replace(line(PUSH, Pose((x + 0.02, y, z), HOME.quaternion)))
    assert wrong(pushing(0.029, hand=0.02, step=nearer)) == []
    assert len(wrong(pushing(0.031, hand=0.02, step=nearer))) == 1


def test_only_what_a_task_pushes_and_where_a_step_says_where_it_leads() -> None:
    x, y, z = HOME.position
    assert wrong(pushing(0.2, moves="shelf")) == []
    assert wrong(pushing(0.2, moves="ghost")) == []
    late = replace(line(PUSH, Pose((x + 0.06, y, z), HOME.quaternion)), relative="cup")
    assert wrong(pushing(0.2, step=late)) == []
    assert wrong(pushing(0.2, step=Drive((), 0.1, 0.1, 0.1, 0.1, origin=PUSH))) == []
    made = pushing(0.2)
    on_joint = tuple(replace(t, joint=Joint("slide", Pose(), 0.0, 1.0)) if t.name == "cup" else t for t in made.world.things)
    assert wrong(replace(made, world=replace(made.world, things=on_joint))) == []


def test_what_the_hand_holds_is_carried_and_not_pushed() -> None:
    """As by a task that lets go of a thing, and pushes it then."""
    made = pushing(0.2)
    assert made.rollout is not None and len(wrong(made)) == 1
    pads = (Touch("effector/left", "cup", 5.0, 0.0), Touch("cup", "effector/right", 5.0, 0.0))
    rows = tuple(pads if 12 <= k < 20 else () for k, row in enumerate(made.rollout.touches))
    assert wrong(replace(made, rollout=replace(made.rollout, touches=rows, opening=made.rollout.opening * 0 + 0.06))) == []


def test_what_is_pushed_upwards_gets_as_far_as_the_hand_was_to_go() -> None:
    x, y, z = HOME.position
    raised = line(PUSH, Pose((x, y, z + 0.06), HOME.quaternion))
    for far, passes in ((0.069, True), (0.071, False)):
        made = pushing(0.0, hand=0.0, step=raised)
        assert made.rollout is not None
        cup, arm = made.rollout.poses["cup"].copy(), made.rollout.joints.copy()
        cup[25:, 2] += far
        arm[30:] = joints(Pose((x, y, z + 0.06), HOME.quaternion))
        rollout = replace(made.rollout, poses={**made.rollout.poses, "cup": cup}, joints=arm)
        assert (wrong(replace(made, rollout=rollout)) == []) is passes


def test_what_is_pushed_may_turn() -> None:
    made = pushing(0.06)
    assert made.rollout is not None
    cup = made.rollout.poses["cup"].copy()
    cup[25:, 3:] = Pose.from_rotvec((0, 0, 0), (0, 0, 1.5)).quaternion
    assert wrong(replace(made, rollout=replace(made.rollout, poses={**made.rollout.poses, "cup": cup}))) == []


# What leans in the hand


def tilted(lean: float, turn: float = 0.0) -> Pose:
    """The pose of the tool 100 mm over that of the home posture, tilted, then turned about the vertical."""
    over = Pose.from_rotvec((0, 0, 0), (0, 0, turn)) * Pose.from_rotvec((0, 0, 0), (lean, 0, 0))
    return Pose(up(0.1).position, (over * Pose((0, 0, 0), HOME.quaternion)).quaternion)


def leaning(lean: float, *more: AnyStep, planned: float = 0.0, turn: float = 0.0, waits: int = 10) -> Candidate:
    """A run of one task that leads the block 100 mm upwards, and ends with the hand so tilted [rad]."""
    steps = (line(A, tilted(planned)), *more)
    rest = [*((s.origin, 5) for s in more), ("9.Other/on", 10)]
    return ran(steps, [("", waits), (A, 20), *rest], {0: up(0.0), waits + 20: tilted(lean, turn)})


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("degrees", "passes"), [(0.0, True), (9.5, True), (10.5, False), (80.0, False), (170.0, False)]
)
def test_what_is_held_when_a_task_ends_leans_as_planned(degrees: float, way: float, passes: bool) -> None:
    lean = float(np.radians(degrees)) * way
    found = [f for f in judged(leaning(lean)) if not f.passed]
    assert (found == []) is passes
    if not passes:
        assert (found[0].origin, found[0].unit, found[0].limit) == (A, "rad", pytest.approx(np.radians(10.0)))
        assert found[0].value == pytest.approx(abs(lean), abs=1e-6)
        assert found[0].reason.startswith(f"{A} was not carried out: 'block' leans {degrees:.0f} deg")


def test_what_is_meant_to_lean_does() -> None:
    assert wrong(leaning(1.0, planned=1.0)) == []
    assert [origin for origin, _ in wrong(leaning(0.0, planned=1.0))] == [A]


def test_about_the_vertical_it_may_be_turned() -> None:
    assert wrong(leaning(0.0, turn=1.0)) == []
    assert wrong(leaning(0.5, planned=0.5, turn=1.0)) == []


def test_only_what_hangs_in_the_hand_alone_leans() -> None:
    assert wrong(leaning(0.5)) != []
    assert wrong(leaning(0.5, waits=60)) == []  # the hand is empty by then
    made = leaning(0.5)
    drawer = Joint("slide", Pose(), 0.0, 1.0)
    things = tuple(replace(t, joint=drawer) if t.name == "block" else t for t in made.world.things)
    assert wrong(replace(made, world=replace(made.world, things=things))) == []


def test_the_last_step_that_leads_the_hand_says_how_it_leans() -> None:
    """Steps after it that wait, weigh or grip lead nowhere; one without a pose leaves open how it leans."""
    later = "1.Moving/then"
    weighs = SetPayload(1.0, (0.0, 0.0, 0.1), origin=later)
    for still in (Wait(0.1, origin=later), weighs, opened(later), ZeroSensor(origin=later)):
        assert [origin for origin, _ in wrong(leaning(0.5, still))] == [A]
    assert wrong(leaning(0.5, Drive((), 0.1, 0.1, 0.1, 0.1, origin=later))) == []
    two = (line(A, tilted(0.0)), line(later, tilted(0.0)))
    assert wrong(ran(two, [(A, 15), (later, 15)], {0: up(0.0), 15: tilted(0.5), 30: tilted(0.0)})) == []


def test_each_task_says_how_what_it_leaves_in_the_hand_leans() -> None:
    two = (line(A, tilted(0.0)), line(B, tilted(0.0)))
    hand = {0: up(0.0), 15: tilted(0.5), 30: tilted(0.0)}
    assert [origin for origin, _ in wrong(ran(two, [(A, 15), (B, 15)], hand))] == [A]


def test_rounding_does_not_hide_a_lean() -> None:
    one = np.eye(4) * (1 + 1e-9)
    assert _lean(one, -one) == pytest.approx(np.pi) and _lean(one, one) == 0.0
